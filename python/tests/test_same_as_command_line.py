"""Results have the JSON of the command line, whether recordings come from files or from memory."""

import json

import numpy as np
import pytest

import armident
from conftest import HOLDOUT, PROJECT, TRAIN, URDF


def test_params(cli, robot):
    assert armident.params(robot).to_dict() == cli("params", URDF)


def test_check(cli, robot, train):
    assert armident.check(robot, train).to_dict() == cli("check", URDF, TRAIN)


def test_identify(cli, identification):
    assert identification.to_dict() == cli("identify", URDF, TRAIN, "--holdout", HOLDOUT)


def test_identify_options(cli):
    with pytest.warns(armident.ArmidentWarning, match="not-determined"):
        found = armident.identify(
            URDF,
            [TRAIN],
            cutoff_hz=5,
            method="ols",
            prior="none",
            coupling="none",
            viscous="linear",
            raw_estimate=True,
            payload=[{"file": "train.csv", "mass": 0.5, "com": [0, 0, 0.05], "com_error": 0.01}],
        )
    options = "--cutoff-hz 5 --method ols --prior none --coupling none --viscous linear --raw-estimate"
    payload = "file=train.csv,mass=0.5,com=0:0:0.05,com_error=0.01"
    assert found.to_dict() == cli(
        "identify", URDF, TRAIN, *options.split(), "--payload", payload
    )


def test_diagnose(cli, diagnosis):
    assert diagnosis.to_dict() == cli("diagnose", URDF, TRAIN, "--holdout", HOLDOUT)


def test_models_and_what_is_made_of_them(cli, tmp_path, identification, holdout):
    by_cli, by_python = tmp_path / "cli.json", tmp_path / "python.json"
    cli("identify", URDF, TRAIN, "--holdout", HOLDOUT, "--save-model", by_cli)
    identification.model.save(by_python)
    assert json.loads(by_python.read_text()) == json.loads(by_cli.read_text())

    model = armident.Robot(by_cli)
    assert armident.validate(model, holdout).to_dict() == cli("validate", by_cli, HOLDOUT)

    predicted = tmp_path / "predicted.csv"
    prediction = armident.predict(model, holdout)
    assert prediction.to_dict() == cli("predict", by_cli, HOLDOUT, "-o", predicted)
    prediction.efforts.save(tmp_path / "python.csv")
    assert (tmp_path / "python.csv").read_bytes() == predicted.read_bytes()

    urdf = tmp_path / "model.urdf"
    exported = cli("export", by_cli, "-o", urdf)
    text = urdf.read_text()
    assert armident.export(model, urdf).to_dict() == exported
    assert urdf.read_text() == text


def test_simulate(cli, tmp_path, robot, train):
    simulated = tmp_path / "simulated.csv"
    options = "--torque-noise 5% --encoder-bits 19 --rate-hz 100 --seed 7"
    effect = "coulomb_friction:elbow_joint=4.5"
    cli("simulate", URDF, TRAIN, "-o", simulated, *options.split(), "--effect", effect)
    (recording,) = armident.simulate(
        robot,
        train,
        torque_noise="5%",
        encoder_bits=19,
        rate_hz=100,
        seed=7,
        effect=[("coulomb_friction", "elbow_joint", [4.5])],
    )
    recording.save(tmp_path / "python.csv")
    assert (tmp_path / "python.csv").read_bytes() == simulated.read_bytes()


def test_arrays_are_as_good_as_files(robot, train, identification):
    arrays = armident.Recording.from_arrays(
        train.time,
        train.joints,
        position=train.channel("position"),
        effort=train.channel("effort"),
        source=train.source,
    )
    assert armident.check(robot, arrays).to_dict() == armident.check(robot, train).to_dict()


def test_planned_experiments(cli, tmp_path):
    urdf = PROJECT / "urdf" / "planar_2r.urdf"
    cli("plan", urdf, "-o", tmp_path / "plan")
    cli("simulate", urdf, tmp_path / "plan", "-o", tmp_path / "runs")
    found = armident.identify(urdf, tmp_path / "runs")
    assert found.to_dict() == cli("identify", urdf, tmp_path / "runs")


def test_info(cli, tmp_path, robot):
    log = tmp_path / "log.csv"
    rows = "".join(f"{k / 100},{k % 7 / 10},{k % 5 / 10}\n" for k in range(300))
    log.write_text("time,q_1,tau_1\n" + rows)
    assert armident.info(TRAIN).to_dict() == cli("info", TRAIN)
    by_cli, by_python = tmp_path / "cli.toml", tmp_path / "python.toml"
    expected = cli("info", log, "--robot", URDF, "--write-mapping", by_cli)
    found = armident.info([log], robot=robot, write_mapping=by_python)
    assert found.to_dict() == expected
    assert by_python.read_text() == by_cli.read_text() != ""
    assert "log.csv" in str(found)
    with pytest.raises(armident.ArmidentError, match="names of the columns"):
        log.write_text("a,b\n" + "1,2\n" * 20)
        armident.info(log, write_mapping=by_python)


def test_convert(cli, tmp_path, train):
    by_cli, by_python = tmp_path / "run.npz", tmp_path / "again.npz"
    expected = cli("convert", TRAIN, by_cli)
    found = armident.convert(TRAIN, by_cli)
    assert found.to_dict() == expected and found.omitted == []
    assert armident.convert(train, by_python).samples == expected["samples"]
    assert by_python.read_bytes() == by_cli.read_bytes()
    with pytest.raises(armident.ArmidentError, match="extension `pdf`"):
        armident.convert(TRAIN, tmp_path / "run.pdf")


def test_excite(cli, tmp_path):
    robot = PROJECT / "urdf" / "planar_2r.urdf"
    limits = tmp_path / "limits.toml"
    joints = armident.Robot(robot).joints
    limits.write_text("".join(f"[{name}]\nacceleration = 5.0\njerk = 50.0\n" for name in joints))
    by_cli, by_python = tmp_path / "cli", tmp_path / "python"
    # a search that ends before its first step is the same in every run
    options = "--seconds 5 --budget 1e-9 --only train --format csv,json --seed 3"
    expected = cli("excite", robot, "-o", by_cli, *options.split(), "--limits", limits)
    found = armident.excite(
        robot,
        by_python,
        seconds=5,
        budget=1e-9,
        only=["train"],
        format=["csv", "json"],
        seed=3,
        limits=limits,
    )
    assert found.to_dict() == expected
    names = sorted(file.name for file in by_cli.iterdir())
    assert names == sorted(file.name for file in by_python.iterdir()) and "suite.toml" in names
    for name in names:
        assert (by_python / name).read_bytes() == (by_cli / name).read_bytes(), name
    with pytest.raises(armident.ArmidentError, match="unknown part `all`"):
        armident.excite(robot, by_python, only=["all"])


def test_accumulate_and_merge(cli, tmp_path):
    by_cli, by_python = tmp_path / "cli.jsonl", tmp_path / "python.jsonl"
    expected = cli("accumulate", URDF, TRAIN, HOLDOUT, "-o", by_cli, "--cutoff-hz", 8)
    found = armident.accumulate(URDF, [TRAIN, HOLDOUT], by_python, cutoff_hz=8)
    assert found.to_dict() == expected
    assert by_python.read_text() == by_cli.read_text()
    model = tmp_path / "cli.json"
    merged = armident.merge(URDF, by_python)
    assert merged.to_dict() == cli("merge", URDF, by_cli, "--save-model", model)
    merged.model.save(tmp_path / "python.json")
    assert (tmp_path / "python.json").read_text() == model.read_text()


def test_topics_and_card(cli, tmp_path, identification, diagnosis):
    by_cli, by_python = tmp_path / "cli.mcap", tmp_path / "python.mcap"
    cli("diagnose", URDF, TRAIN, "--holdout", HOLDOUT, "--mcap", by_cli)
    diagnosis.save_mcap(by_python)
    assert by_python.read_bytes() == by_cli.read_bytes()
    card = tmp_path / "card.html"
    cli("identify", URDF, TRAIN, "--holdout", HOLDOUT, "--card", card, "--serial", "7")
    by_cli = json.loads((tmp_path / "card.json").read_text())
    identification.save_card(card, serial="7")
    assert json.loads((tmp_path / "card.json").read_text()) == by_cli
    assert [entry["used_as"] for entry in by_cli["inputs"]] == ["robot", "training", "hold-out"]


def test_thresholds(cli, tmp_path):
    robot = PROJECT / "urdf" / "planar_2r.urdf"
    random = np.random.default_rng(7)
    time = np.arange(0, 300, 0.02)
    position = np.stack([0.5 * np.sin(1.1 * time), 0.4 * np.cos(0.7 * time)], axis=1)
    free = armident.Recording.from_arrays(
        time,
        armident.Robot(robot).joints,
        position=position,
        effort=random.normal(size=position.shape),
    )
    log = tmp_path / "free.csv"
    free.save(log)
    by_cli, by_python = tmp_path / "cli.c", tmp_path / "python.c"
    options = ["--false-alarms-per-hour", 60, "--without-contact", log, "--holdout", log]
    expected = cli("export", robot, "-o", by_cli, *options)["thresholds"]
    found = armident.export(
        robot, by_python, false_alarms_per_hour=60, without_contact=log, holdout=log
    )
    assert found.thresholds == expected and expected["gain"] == 5
    assert by_python.read_text() == by_cli.read_text()
    with pytest.raises(armident.ArmidentError, match="a rate and recordings"):
        armident.export(robot, by_python, false_alarms_per_hour=60)
