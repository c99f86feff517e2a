"""Results have the JSON of the command line, whether recordings come from files or from memory."""

import json

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
