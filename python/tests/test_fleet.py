"""Three robots with four recordings each on Ray Data and DataFusion, against one process."""

import json
import os
import random
import resource
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import armident
from armident import fleet
from conftest import URDF

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
#: Viscous friction of the elbow [N m s/rad], which one robot doubles.
ELBOW = 4.0
#: Body that another robot gains on link 3.
CLAMP = """<link name="clamp"><inertial><origin xyz="0 0 0"/><mass value="0.6"/><inertia ixx="0.0006" iyy="0.0006"
 izz="0.0006" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="clamp_joint" type="fixed"><parent link="link_3"/>
<child link="clamp"/><origin xyz="-0.2 0.03 0.05" rpy="0 0 0"/></joint></robot>"""


def motion(number):
    time_s = np.arange(1500) * 0.01
    columns = []
    for joint in range(6):
        place = 1 + joint + 7 * number

        def wave(hz, phase, place=place):
            return np.sin(2 * np.pi * hz * time_s + phase * place)

        columns.append(0.9 * wave(0.13 + 0.03 * joint, 1.3) + 0.35 * wave(0.41, 2.1))
    return armident.Recording.from_arrays(time_s, JOINTS, position=np.stack(columns, axis=1))


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fleet")
    loaded = folder / "loaded.urdf"
    loaded.write_text(URDF.read_text().replace("</robot>", CLAMP))
    for index, robot in enumerate(["gains", "rubs", "stays"]):
        (folder / robot).mkdir()
        for recording in range(4):
            changed = recording >= 2
            elbow = 2 * ELBOW if changed and robot == "rubs" else ELBOW
            friction = [("viscous_friction", joint, [elbow if joint == "elbow_joint" else 2.0]) for joint in JOINTS]
            friction += [("coulomb_friction", joint, [1.5]) for joint in JOINTS]
            number = 4 * index + recording
            arm = loaded if changed and robot == "gains" else URDF
            found = armident.simulate(arm, motion(number), torque_noise="1%", effect=friction, seed=number)
            found[0].save(folder / robot / f"day{recording + 1}.csv")
    whole = (folder / "stays" / "day1.csv").read_text()
    (folder / "stays" / "day5.csv").write_text(whole[:60])
    (folder / "stays" / "day6.csv").write_text("t,hinge/position,hinge/effort\n0,0,0\n0.01,0,0\n0.02,0,0\n")
    return folder


@pytest.fixture(scope="module")
def alone(logs, tmp_path_factory):
    """Each robot in one process."""
    folder = tmp_path_factory.mktemp("alone")
    found = {}
    for robot in ["gains", "rubs", "stays"]:
        armident.accumulate(URDF, logs / robot, folder / f"{robot}.jsonl")
        found[robot] = armident.merge(URDF, folder / f"{robot}.jsonl")
    return found


@pytest.fixture(scope="module")
def ray():
    ray = pytest.importorskip("ray")
    pytest.importorskip("pyarrow")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    yield ray
    ray.shutdown()


def items(logs):
    return [{"path": str(path)} for path in sorted(logs.glob("*/*.csv"))]


def same(found, expected):
    """Largest difference of parameters, relative to their size."""
    pairs = zip(found.to_dict()["parameters"], expected.to_dict()["parameters"], strict=True)
    return max(abs(a["value"] - b["value"]) / (1 + abs(b["value"])) for a, b in pairs)


@pytest.mark.parametrize("partitions", [1, 2, 5])
def test_ray_equals_one_process_in_any_partition(ray, logs, alone, partitions):
    shuffled = items(logs)
    random.Random(partitions).shuffle(shuffled)
    found = fleet.identify(ray.data.from_items(shuffled, override_num_blocks=partitions), robot=URDF)
    assert sorted(found.robots) == ["gains", "rubs", "stays"]
    for robot, merged in found.robots.items():
        assert same(merged, alone[robot]) < 1e-9
    aside = [Path(of.recording).name for of in found.set_aside]
    assert aside == ["day5.csv", "day6.csv"] and all(of.reason for of in found.set_aside)
    # a state does not grow with its recording
    print(f"{partitions} partitions: {found.state_bytes} bytes of states from 12 recordings")
    assert found.state_bytes < 12 * 200_000
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    print(f"peak memory of the process that merges: {peak_mb:.0f} MB")
    assert peak_mb < 2000


def workers():
    """Processes of Ray that run tasks of this test."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            command = (folder / "cmdline").read_bytes().decode(errors="replace")
            if command.startswith("ray::") and "Map" in command and os.stat(folder).st_uid == os.getuid():
                found.append(int(folder.name))
        except OSError:
            continue
    return found


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="workers are found in /proc")
def test_killed_worker_changes_nothing(ray, logs, alone):
    killed = []

    def kill():
        until = time.monotonic() + 60
        while not killed and time.monotonic() < until:
            for worker in workers():
                os.kill(worker, signal.SIGKILL)
                killed.append(worker)
                return
            time.sleep(0.005)

    killer = threading.Thread(target=kill)
    killer.start()
    found = fleet.identify(ray.data.from_items(items(logs), override_num_blocks=6), robot=URDF)
    killer.join()
    assert killed
    for robot, merged in found.robots.items():
        assert same(merged, alone[robot]) < 1e-9
    assert len(found.set_aside) == 2


def test_changes_from_states_of_ray(ray, logs, cli, tmp_path):
    dataset = ray.data.from_items(items(logs))
    aside = fleet.write(fleet.states(dataset, robot=URDF), tmp_path / "states.jsonl")
    assert len(aside) == 2
    result = cli("fleet", URDF, tmp_path / "states.jsonl")
    changes = {robot["robot"]: robot["changes"] for robot in result["robots"]}
    assert [(c["link"], c["number"]) for c in changes["gains"]] == [("link_3", 3)]
    assert [(c["what"], c["joint"], c["number"]) for c in changes["rubs"]] == [("viscous friction", "elbow_joint", 3)]
    assert changes["stays"] == []


def test_follow_is_the_command(logs, cli, tmp_path):
    with pytest.warns(armident.ArmidentWarning, match=r"\[scatter\]"):
        found = fleet.follow(URDF, logs, states=tmp_path / "states.parquet")
    assert found.to_dict() == cli("fleet", URDF, logs, "--states", tmp_path / "states.jsonl")
    assert [of.parameter for of in found.robots[1].changes] == ["viscous_friction(elbow_joint)"]
    found.save_report(tmp_path / "fleet.html")
    assert "<code>elbow_joint</code>" in (tmp_path / "fleet.html").read_text()


def test_states_merge_in_any_order(logs, alone, tmp_path):
    states = []
    for path in sorted((logs / "stays").glob("day[1-4].csv")):
        armident.accumulate(URDF, path, tmp_path / f"{path.stem}.jsonl")
        states.append((tmp_path / f"{path.stem}.jsonl").read_text())
    merged = [fleet.merge_states(URDF, order) for order in (states, states[::-1])]
    assert merged[0].to_dict()["parameters"] == merged[1].to_dict()["parameters"]
    assert same(merged[0], alone["stays"]) < 1e-9


def test_table_of_states_is_the_states(logs, alone, tmp_path):
    pytest.importorskip("pyarrow")
    pandas = pytest.importorskip("pandas")
    states, table, back = (tmp_path / name for name in ("states.jsonl", "states.parquet", "back.jsonl"))
    armident.accumulate(URDF, logs / "rubs", states)
    assert fleet.to_parquet(states, table) == 4
    read = pandas.read_parquet(table)
    assert len(read) == 4 * len(JOINTS) and set(read["joint"]) == set(JOINTS)
    assert (read["noise"] > 0).all() and (read["effective_rows"] < read["rows"]).all()
    assert fleet.from_parquet(table, back) == 4
    assert [json.loads(line) for line in back.open()] == [json.loads(line) for line in states.open()]
    assert same(armident.merge(URDF, back), alone["rubs"]) == 0


def test_table_of_the_library_is_that_of_python(logs, alone, tmp_path):
    pytest.importorskip("pyarrow")
    pandas = pytest.importorskip("pandas")
    states, own, theirs, back = (tmp_path / name for name in ("s.jsonl", "python.parquet", "rust.parquet", "back.jsonl"))
    armident.accumulate(URDF, logs / "rubs", states)
    armident.accumulate(URDF, logs / "rubs", theirs)
    fleet.to_parquet(states, own)
    expected, found = pandas.read_parquet(own), pandas.read_parquet(theirs)
    assert list(found.columns) == list(expected.columns) and list(found.dtypes) == list(expected.dtypes)
    for column in set(expected.columns) - {"noise", "triangle", "head"}:
        assert found[column].equals(expected[column]), column
    np.testing.assert_allclose(found["noise"], expected["noise"], rtol=1e-9)
    assert fleet.from_parquet(theirs, back) == 4
    assert [json.loads(line) for line in back.open()] == [json.loads(line) for line in states.open()]
    for table in (own, theirs):
        assert same(armident.merge(URDF, table), alone["rubs"]) == 0


@pytest.mark.parametrize("partitions", [1, 2, 5])
def test_datafusion_equals_one_process(logs, alone, tmp_path, partitions):
    datafusion = pytest.importorskip("datafusion")
    pa = pytest.importorskip("pyarrow")
    rows = [fleet._reduce(str(URDF), item["path"], Path(item["path"]).parent.name, 5.0) for item in items(logs)]
    random.Random(partitions).shuffle(rows)
    schema = pa.schema([(name, pa.string()) for name in ("robot", "recording", "state", "reason")])
    batches = [pa.RecordBatch.from_pylist(rows[k::partitions], schema=schema) for k in range(partitions)]
    context = datafusion.SessionContext()
    context.register_record_batches("states", [[batch] for batch in batches])
    fleet.register(context, robot=URDF)
    query = "SELECT robot, armident_merge(state) AS model FROM states WHERE state IS NOT NULL GROUP BY robot"
    found = [row for batch in context.sql(query).collect() for row in batch.to_pylist()]
    assert sorted(row["robot"] for row in found) == ["gains", "rubs", "stays"]
    for row in found:
        expected = alone[row["robot"]].to_dict()["parameters"]
        for a, b in zip(json.loads(row["model"])["parameters"], expected, strict=True):
            assert abs(a["value"] - b["value"]) < 1e-9 * (1 + abs(b["value"]))
