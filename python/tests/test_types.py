"""Types of the package, for editors and type checkers."""

import importlib.metadata
import importlib.util
import os
import subprocess
import sys

import pytest

import armident
import fields
from conftest import PROJECT


def test_fields_are_those_of_the_schemas():
    renew = "run `python python/tests/fields.py`"
    assert fields.stub() == fields.TARGET.read_text(encoding="utf-8"), renew


def test_fields_of_a_result_are_in_its_class(diagnosis, identification, robot, train):
    checked = armident.check(robot, train)
    for name, result in [
        ("DiagnoseReport", diagnosis),
        ("IdentifyReport", identification),
        ("CheckReport", checked),
    ]:
        start = fields.stub().index(f"class {name}:")
        known = fields.stub()[start:].split("\n\nclass ")[0]
        for field in set(result.to_dict()) - fields.OF_RESULT:
            assert f"\n    {field}: " in known, field


def test_types_are_shipped():
    shipped = {file.name for file in importlib.metadata.files("armident") or []}
    assert {"py.typed", "_armident.pyi", "_fields.pyi"} <= shipped


def test_type_checker_finds_nothing():
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("mypy is not installed")
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", os.devnull, "python/armident"]
    done = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
