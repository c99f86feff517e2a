"""Attributes, pages and texts of results."""

import subprocess

import pytest

import armident
from conftest import HOLDOUT, TRAIN, URDF


def test_findings_have_attributes(diagnosis):
    forearm = next(f for f in diagnosis.findings if f.link == "link_3")
    assert forearm.effect == "link_inertia_error"
    assert forearm.confirmed
    # the forearm is 0.6 kg heavier than the URDF says
    assert forearm.parameters["delta_mass"].value == pytest.approx(0.6, abs=0.2)
    assert diagnosis.joints[0] == "shoulder_pan_joint"
    assert "findings" in dir(diagnosis)
    with pytest.raises(AttributeError, match="fields: "):
        diagnosis.finding


def test_text_is_that_of_the_command_line(cli, diagnosis, identification):
    command = [cli.binary, "identify", URDF, TRAIN, "--holdout", HOLDOUT, "--quiet"]
    utf_8 = {"LC_ALL": "C.UTF-8", "LANG": "C.UTF-8"}
    done = subprocess.run(command, capture_output=True, env=utf_8)
    assert str(identification) == done.stdout.decode()
    assert repr(diagnosis).startswith("<Diagnosis: ur5: 19 effects are missing from the model")


def test_notebooks_show_the_verdict(diagnosis, robot, train):
    html = diagnosis._repr_html_()
    assert "19 effects are missing from the model" in html
    assert "<script" not in html and len(html) < 200_000
    assert "<table" in armident.check(robot, train)._repr_html_()
    assert "ur5" in armident.params(robot)._repr_html_()


def test_reports_are_pages(tmp_path, diagnosis):
    diagnosis.save_report(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert page.startswith("<!doctype html>") and "plotly" in page
    assert "armident.diagnose" in page


def test_warnings_of_a_result_are_python_warnings(tmp_path, train):
    # a link without a mass
    urdf = tmp_path / "ur5.urdf"
    text = URDF.read_text()
    start = text.index("<inertial>", text.index('<link name="link_6"'))
    end = text.index("</inertial>", start) + len("</inertial>")
    urdf.write_text(text[:start] + text[end:])
    with pytest.warns(armident.ArmidentWarning, match="link_6"):
        result = armident.params(urdf)
    assert any("link_6" in warning for warning in result.warnings)
