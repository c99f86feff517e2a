"""One run in the layouts of seven programs goes from `info` to `diagnose` in two commands."""

import subprocess
import sys

import pytest

import armident
from conftest import PROJECT, URDF

LOGS = PROJECT / "examples" / "logs"
#: Whether the guessed mapping is needed.
MAPPED = {
    "ros2_bag": False,
    "ros2_sqlite": False,
    "ros1.bag": False,
    "lerobot": True,
    "rtde.csv": True,
    "matlab.mat": False,
    "sage/state_motor.csv": False,
    "numpy.npz": False,
}


@pytest.fixture(scope="module")
def of_csv():
    """The findings on the same samples as CSV."""
    whole = armident.Recording(PROJECT / "examples" / "ur5" / "train.csv")
    every = slice(None, None, 2)
    half = armident.Recording.from_arrays(
        whole.time[every],
        whole.joints,
        position=whole.channel("position")[every],
        effort=whole.channel("effort")[every],
    )
    return names(armident.diagnose(URDF, half, replay=False))


def names(result):
    return {(one.effect, one.link or tuple(one.joints)) for one in result.findings}


@pytest.mark.parametrize("log", MAPPED)
def test_logs_go_from_info_to_diagnose(log, of_csv, tmp_path):
    written = tmp_path / "mapping.toml" if MAPPED[log] else None
    (found,) = armident.info(LOGS / log, robot=URDF, write_mapping=written).recordings
    assert found.names == ("guess" if MAPPED[log] else "standard"), found
    if MAPPED[log]:
        assert found.guess.unsure == []
    result = armident.diagnose(URDF, LOGS / log, mapping=written, replay=False)
    # LeRobot has a pause between its episodes, SAGE velocities
    same = names(result) & of_csv
    assert len(same) >= 0.8 * len(of_csv), (names(result) ^ of_csv)


def test_script_of_lerobot_runs(tmp_path):
    script = PROJECT / "examples" / "lerobot.py"
    done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "effects are missing" in done.stdout
    assert (tmp_path / "lerobot_report.html").exists() and (tmp_path / "lerobot_mapping.toml").exists()
