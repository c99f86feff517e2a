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


def test_every_result_shows_in_notebooks(tmp_path, robot, train, holdout, identification):
    path = tmp_path / "log.csv"
    results = [
        armident.info(TRAIN),
        armident.convert(train, path),
        armident.export(identification.model, tmp_path / "arm.sdf"),
        armident.predict(robot, train),
        armident.validate(robot, holdout, replay=False),
        identification,
    ]
    for result in results:
        html = result._repr_html_()
        # a notebook runs no script of a result, and shows each as its own
        assert "<script" not in html, type(result)
        assert "ur5" in html.lower() or "train.csv" in html, type(result)


def test_models_go_into_simulators(tmp_path, identification):
    for name, start in [("arm.sdf", "<?xml"), ("arm.usda", "#usda 1.0"), ("arm.py", '"""Actuators of ur5')]:
        exported = armident.export(identification.model, tmp_path / name)
        assert exported.text.startswith(start)
        assert (tmp_path / name).read_text() == exported.text
        assert {one.effect for one in exported.lost} == {"torque_offset"}


def test_mjcf_is_a_robot(tmp_path, robot, train):
    armident.export(robot, tmp_path / "arm.xml")
    again = armident.Robot(tmp_path / "arm.xml")
    difference = again.predict(train) - robot.predict(train)
    assert abs(difference).max() < 1e-6
