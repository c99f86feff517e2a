"""Predictions of recordings and of arrays."""

import numpy as np
import pytest

import armident
from conftest import URDF


def motion(samples=400, joints=6):
    t = 0.01 * np.arange(samples)
    phase = 1.3 * t[:, None] + np.arange(joints)
    return t, 0.5 * np.sin(phase), 0.65 * np.cos(phase), -0.845 * np.sin(phase)


def test_arrays_equal_a_recording_of_them(robot):
    t, q, v, a = motion()
    recording = armident.Recording.from_arrays(
        t, robot.joints, position=q, velocity=v, acceleration=a
    )
    efforts = robot.predict(q, v, a, t=t)
    assert efforts.shape == q.shape and efforts.dtype == np.float64
    np.testing.assert_allclose(robot.predict(recording), efforts, atol=1e-9)


def test_gravity_of_one_pose(robot):
    zero = np.zeros((1, 6))
    down = robot.predict(zero, zero, zero)
    weightless = armident.Robot(URDF, gravity=[0, 0, 0])
    assert np.abs(down).max() > 10
    np.testing.assert_allclose(weightless.predict(zero, zero, zero), 0, atol=1e-12)


def test_rows_do_not_depend_on_each_other(identification):
    _, q, v, a = motion(40)
    # where joints move fast, friction does not depend on the past
    v = v + np.sign(v)
    model = identification.model
    together = model.predict(q, v, a)
    alone = np.vstack([model.predict(q[k : k + 1], v[k : k + 1], a[k : k + 1]) for k in range(5)])
    np.testing.assert_allclose(alone, together[:5], atol=1e-9)


def test_models_predict_the_holdout(diagnosis, identification, holdout):
    measured = holdout.channel("effort")
    for result in (diagnosis, identification):
        error = result.model.predict(holdout) - measured
        assert (error.std(axis=0) < 0.3 * measured.std(axis=0)).all()


def test_diagnosed_model_predicts_arrays(diagnosis, holdout):
    model = diagnosis.model
    t = holdout.time
    q = holdout.channel("position")
    # smooth derivatives of the recorded positions
    kernel = np.hanning(41) / np.hanning(41).sum()
    q = np.column_stack([np.convolve(c, kernel, mode="same") for c in q.T])
    v = np.gradient(q, t, axis=0)
    a = np.gradient(v, t, axis=0)
    inner = slice(100, -100)
    measured = holdout.channel("effort")[inner]
    error = model.predict(q, v, a, t=t)[inner] - measured
    # gravity and inertia dominate the first joints of the forearm
    assert (error.std(axis=0)[1:3] < 0.3 * measured.std(axis=0)[1:3]).all()
    assert all(isinstance(sentence, str) for sentence in model.omitted_from_arrays)


@pytest.mark.parametrize("samples", [0, 1, 3, 50])
def test_any_number_of_rows(robot, samples):
    _, q, v, a = motion(samples)
    assert robot.predict(q, v, a).shape == (samples, 6)


def test_lists_are_arrays(robot):
    row = [[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]]
    np.testing.assert_array_equal(
        robot.predict(row, row, row), robot.predict(*[np.array(row)] * 3)
    )
