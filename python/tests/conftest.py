"""Files of the project, and the command line to compare with."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

import armident

PROJECT = Path(__file__).resolve().parents[2]
URDF = PROJECT / "urdf" / "ur5.urdf"
TRAIN = PROJECT / "examples" / "ur5" / "train.csv"
HOLDOUT = PROJECT / "examples" / "ur5" / "holdout.csv"


@pytest.fixture(scope="session")
def cli():
    """`cli(*arguments)` gives the JSON of the command line; ARMIDENT names its binary."""
    binary = os.environ.get("ARMIDENT") or shutil.which("armident")
    if binary is None:
        pytest.skip("set ARMIDENT to the binary of the command line")

    def run(*arguments):
        # in the folder of the project, as the paths of the tests are absolute
        command = [binary, *map(str, arguments), "--json", "-", "--quiet"]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    run.binary = binary
    return run


@pytest.fixture(scope="session")
def robot():
    return armident.Robot(URDF)


@pytest.fixture(scope="session")
def train():
    return armident.Recording(TRAIN)


@pytest.fixture(scope="session")
def holdout():
    return armident.Recording(HOLDOUT)


@pytest.fixture(scope="session")
def diagnosis(robot, train, holdout):
    return armident.diagnose(robot, train, holdout=holdout)


@pytest.fixture(scope="session")
def identification(robot, train, holdout):
    return armident.identify(robot, train, holdout=holdout)
