"""Exceptions carry what, where, and what to do."""

import signal
import threading
import time

import numpy as np
import pytest

import armident
from conftest import HOLDOUT, TRAIN, URDF


def refused(call, *arguments, **keywords):
    with pytest.raises(armident.ArmidentError) as caught:
        call(*arguments, **keywords)
    error = caught.value
    lines = str(error).splitlines()
    assert lines[0] == error.what
    assert not error.place or lines[1] == f"   in: {error.place}"
    assert error.hint is None or lines[-1] == f" hint: {error.hint}"
    return error


def test_missing_file(tmp_path):
    error = refused(armident.Recording, tmp_path / "none.csv")
    assert error.place.endswith("none.csv")
    assert refused(armident.Robot, tmp_path / "none.urdf").place.endswith("none.urdf")
    assert refused(armident.read, tmp_path).what == "no recordings in the folder"


def test_fault_of_a_file_shows_its_line(tmp_path):
    text = TRAIN.read_text().splitlines()
    text[3] = text[3].replace(text[3].split(",")[1], "fast")
    bad = tmp_path / "bad.csv"
    bad.write_text("\n".join(text))
    error = refused(armident.Recording, bad)
    assert "line 4" in error.place and "column" in error.place
    assert "fast" in str(error) and "^^^^" in str(error)


def test_same_three_lines_as_the_command_line(cli, tmp_path):
    import subprocess

    command = [cli.binary, "identify", URDF, tmp_path / "none.csv"]
    said = subprocess.run(command, capture_output=True, text=True).stderr
    error = refused(armident.identify, URDF, tmp_path / "none.csv")
    assert said.rstrip("\n") == f"error: {error}"


@pytest.mark.parametrize(
    ("arrays", "place"),
    [
        ({"position": np.zeros((100, 5))}, "position"),
        ({"position": np.zeros(100)}, "position"),
        ({"position": [["fast"] * 6] * 100}, "position"),
        ({"position": np.zeros((90, 6))}, "shoulder_pan_joint/position"),
        ({"position": np.full((100, 6), np.inf)}, "position"),
        ({}, "arrays"),
    ],
)
def test_arrays_of_another_form(robot, arrays, place):
    error = refused(armident.Recording.from_arrays, 0.01 * np.arange(100), robot.joints, **arrays)
    assert place in error.place
    assert error.hint


def test_times_that_go_back(robot):
    t = 0.01 * np.arange(100)
    t[50] = 0
    error = refused(armident.Recording.from_arrays, t, robot.joints, position=np.zeros((100, 6)))
    assert "`t`" in error.place


def test_arguments_that_are_not_known(robot, train):
    assert refused(armident.identify, robot, train, method="magic").place == "method"
    assert refused(armident.identify, robot, train, prior="mine").place == "prior"
    assert refused(train.channel, "speed").place == "quantity"
    assert refused(armident.export, robot, "model.obj").hint
    assert refused(robot.predict, train, cutoff_hz=-1)
    assert refused(robot.predict, np.zeros((3, 6))).place == "predict"
    assert refused(robot.predict, np.zeros((3, 6)), np.zeros((2, 6)), np.zeros((3, 6))).place == "v"
    unknown = [("stickyness", "elbow_joint", [1.0])]
    assert "stickyness" in refused(armident.simulate, robot, train, effect=unknown).what
    with pytest.raises(TypeError):
        armident.diagnose(robot, train, hold_out=train)


def test_recording_without_efforts(robot, train):
    silent = armident.Recording.from_arrays(
        train.time, train.joints, position=train.channel("position"), source="silent"
    )
    error = refused(armident.identify, robot, silent)
    assert error.what.startswith("no effort column for") and error.place == "silent"


def test_columns_that_fail_the_checks_are_a_result(robot, train):
    upside_down = armident.Recording.from_arrays(
        train.time,
        train.joints,
        position=train.channel("position"),
        effort=-train.channel("effort"),
    )
    result = armident.diagnose(robot, upside_down)
    assert "input check failed" in str(result)
    assert result.model is None
    assert "do not match their headers" in result._repr_html_()


def test_other_threads_run_during_work(robot, train):
    ticks = []
    stop = threading.Event()

    def tick():
        while not stop.wait(0.005):
            ticks.append(time.perf_counter())

    thread = threading.Thread(target=tick)
    thread.start()
    start = time.perf_counter()
    armident.identify(robot, train)
    took = time.perf_counter() - start
    stop.set()
    thread.join()
    assert len(ticks) > took / 0.005 / 10


def test_ctrl_c_interrupts_work(robot):
    start = time.perf_counter()
    timer = threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        armident.diagnose(robot, TRAIN, holdout=HOLDOUT)
    assert time.perf_counter() - start < 2
