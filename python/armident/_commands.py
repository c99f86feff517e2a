"""The commands. A robot is a `Robot` or the path of a URDF or model file; recordings are `Recording`s, paths of files, or
folders of them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

from . import _armident
from ._armident import Recording
from ._progress import working
from ._recordings import Path, RecordingsLike, RobotLike, as_recordings, as_robot
from ._results import (
    Accumulation,
    Check,
    Conversion,
    Diagnosis,
    Export,
    Identification,
    Info,
    Merge,
    MinimalSet,
    Prediction,
    Suite,
    Validation,
)


def params(robot: RobotLike) -> MinimalSet:
    """Driving-axis frames and minimal parameter set of an arm.

    Raises:
        ArmidentError: A chain that cannot be chosen.
    """
    return MinimalSet(_armident.params(as_robot(robot)))


def check(
    robot: RobotLike,
    recordings: RecordingsLike,
    *,
    cutoff_hz: float | None = None,
    mapping: Path | None = None,
    topic: str | None = None,
) -> Check:
    """Check recordings: signs, units, order, delay, noise and excitation.

    Args:
        cutoff_hz: Low-pass [Hz]. Default: from the spectrum of the motion.
        mapping: TOML file that maps columns of files to joints, quantities and units.
        topic: Joint state topic of MCAP files.

    Raises:
        ArmidentError: Recordings without the joints or efforts of the arm.
    """
    read = as_recordings(recordings, mapping, topic)
    return Check(_armident.check(as_robot(robot), read, cutoff_hz))


def identify(
    robot: RobotLike,
    recordings: RecordingsLike,
    *,
    holdout: RecordingsLike | None = None,
    cutoff_hz: float | None = None,
    method: str = "irls",
    cross_validate: bool = False,
    prior: Literal["urdf", "none"] = "urdf",
    payload: Iterable[Mapping[str, Any]] = (),
    coupling: Literal["auto", "none"] = "auto",
    viscous: Literal["auto", "linear"] = "auto",
    raw_estimate: bool = False,
    mapping: Path | None = None,
    topic: str | None = None,
) -> Identification:
    """Estimate inertia and friction parameters from recordings.

    Args:
        recordings: Recordings; or a folder with `plan.json` and one CSV file an experiment (Algorithm 2).
        holdout: Recordings that are predicted only, for validation.
        cutoff_hz: Low-pass [Hz]. Default: from the spectrum of the motion.
        method: Estimator: `irls`, `wls`, `ols`, `iv`.
        cross_validate: Leave-one-recording-out cross-validation.
        prior: Prior on link inertias: about the URDF with a scale from the recordings, or none.
        payload: Known payloads, each a dict with `file` (path or name of a recording's file, or its `source`), `mass`
            [kg], and optionally `com` [m, frame of the last moving link] and `com_error` [m].
        coupling: Transmissions shared by neighbouring joints: where cross-validation supports them, or none.
        viscous: Viscous friction: sublinear where the recordings support it, or linear.
        raw_estimate: Skip the projection to physically consistent parameters.
        mapping: TOML file that maps columns of files to joints, quantities and units.
        topic: Joint state topic of MCAP files.

    Raises:
        ArmidentError: Recordings that cannot be used.
    """
    plan = None
    if isinstance(recordings, (str, os.PathLike)):
        folder = os.fspath(recordings)
        if os.path.isfile(os.path.join(folder, "plan.json")):
            plan = os.path.join(folder, "plan.json")
    train = [] if plan else as_recordings(recordings, mapping, topic)
    loads = [
        (os.fspath(load["file"]), load["mass"], load.get("com"), load.get("com_error", 0.0))
        for load in payload
    ]
    held_out = as_recordings(holdout, mapping, topic)
    with working("fitting"):
        answer = _armident.identify(
            as_robot(robot),
            train,
            held_out,
            plan,
            cutoff_hz,
            method,
            cross_validate,
            _one_of("prior", prior, ("urdf", "none")) == "urdf",
            loads,
            _one_of("coupling", coupling, ("auto", "none")) == "auto",
            _one_of("viscous", viscous, ("auto", "linear")) == "auto",
            raw_estimate,
        )
    return Identification(answer)


def diagnose(
    robot: RobotLike,
    recordings: RecordingsLike,
    *,
    holdout: RecordingsLike | None = None,
    reference: RecordingsLike | None = None,
    placebo: int | None = None,
    replay: bool = True,
    trust_columns: bool = False,
    next_motion: Path | None = None,
    mapping: Path | None = None,
    topic: str | None = None,
) -> Diagnosis:
    """Find effects missing from a model and confirm them on hold-out recordings.

    Args:
        holdout: Recordings that are never fitted, for confirmation.
        reference: Earlier recordings of the same arm; only changes since then are reported.
        placebo: Run a placebo test with this many wrong terms.
        replay: Forward replay of the hold-out.
        trust_columns: Use columns that fail the input checks.
        next_motion: File for a motion that separates indistinguishable effects; also in `result.separating_motion`.
        mapping: TOML file that maps columns of files to joints, quantities and units.
        topic: Joint state topic of MCAP files.

    Raises:
        ArmidentError: Recordings that cannot be used.
    """
    path = None if next_motion is None else os.fspath(next_motion)
    train, held_out, earlier = (
        as_recordings(each, mapping, topic) for each in (recordings, holdout, reference)
    )
    with working("diagnosing"):
        answer, motion = _armident.diagnose(
            as_robot(robot), train, held_out, earlier, placebo, replay, trust_columns, path
        )
    result = Diagnosis(answer)
    result.separating_motion = motion
    if motion is not None and path is not None:
        motion.save(path)
    return result


def validate(
    robot: RobotLike,
    recordings: RecordingsLike,
    *,
    cutoff_hz: float | None = None,
    replay: bool = True,
    mapping: Path | None = None,
    topic: str | None = None,
) -> Validation:
    """Evaluate a model on hold-out recordings.

    Args:
        cutoff_hz: Low-pass [Hz]. Default: the model's, else from the spectrum of the motion.
        replay: Forward replay: recorded efforts drive the simulated arm.
        mapping: TOML file that maps columns of files to joints, quantities and units.
        topic: Joint state topic of MCAP files.

    Raises:
        ArmidentError: Recordings without the joints or efforts of the arm.
    """
    read = as_recordings(recordings, mapping, topic)
    with working("validating"):
        answer = _armident.validate(as_robot(robot), read, cutoff_hz, replay)
    return Validation(answer)


def predict(
    robot: RobotLike,
    motion: Recording | Path,
    *,
    cutoff_hz: float | None = None,
    mapping: Path | None = None,
    topic: str | None = None,
) -> Prediction:
    """Predict the joint efforts of a motion; `result.efforts` is a `Recording`.

    Args:
        cutoff_hz: Low-pass of the positions [Hz]. Default: the model's, else from the spectrum of the motion.
        mapping: TOML file that maps columns of files to joints, quantities and units.
        topic: Joint state topic of MCAP files.

    Raises:
        ArmidentError: A motion without the positions of the joints.
    """
    (read,) = as_recordings(motion, mapping, topic)
    answer, efforts = _armident.predict(as_robot(robot), read, cutoff_hz)
    result = Prediction(answer)
    result.efforts = efforts
    return result


def simulate(
    robot: RobotLike,
    trajectories: RecordingsLike,
    *,
    direction: Literal["inverse", "forward"] = "inverse",
    torque_noise: float | str | None = None,
    encoder_bits: int | None = None,
    rate_hz: float | None = None,
    effect: Iterable[tuple[str, str, Sequence[float]]] = (),
    seed: int = 0,
    mapping: Path | None = None,
    topic: str | None = None,
) -> list[Recording]:
    """Simulate recordings from trajectories.

    Args:
        direction: From motion to efforts, or from efforts to motion.
        torque_noise: Standard deviation of white effort noise [N m or N], or a share of each joint's effort (`"5%"`).
        encoder_bits: Quantise positions to this many bits per turn (or metre).
        rate_hz: Resample to this rate first [Hz].
        effect: Effects to add, each `(effect, joint, parameters)`.
        seed: Random seed of the noise.
        mapping: TOML file that maps columns of files to joints, quantities and units.
        topic: Joint state topic of MCAP files.

    Returns:
        One recording a trajectory. Without `encoder_bits` it has exact accelerations too.

    Raises:
        ArmidentError: A trajectory that the arm cannot follow; an effect that it cannot have.
    """
    forward = _one_of("direction", direction, ("inverse", "forward")) == "forward"
    effects = [(name, joint, list(parameters)) for name, joint, parameters in effect]
    noise = None if torque_noise is None else str(torque_noise)
    read = as_recordings(trajectories, mapping, topic)
    with working("simulating"):
        simulated, _ = _armident.simulate(
            as_robot(robot), read, forward, noise, encoder_bits, rate_hz, effects, seed
        )
    return simulated


def export(
    robot: RobotLike,
    path: Path,
    *,
    format: Literal["urdf", "mjcf", "drake-sdf", "isaaclab", "usd", "c"] | None = None,
    false_alarms_per_hour: float | None = None,
    without_contact: RecordingsLike | None = None,
    holdout: RecordingsLike | None = None,
    observer_gain: float | None = None,
    mapping: Path | None = None,
    topic: str | None = None,
) -> Export:
    """Export a model to URDF, MJCF, SDFormat, USD, Isaac Lab or C.

    Args:
        path: Output file (`.urdf`, `.xml` for MJCF, `.sdf`, `.usda`, `.py` for Isaac Lab, or `.c`).
        format: Output format. Default: from the extension.
        false_alarms_per_hour: Thresholds of the momentum observer for this rate of the whole arm (C).
        without_contact: Recordings of ordinary motion without contact, for the thresholds.
        holdout: Other recordings without contact, on which the thresholds are tried.
        observer_gain: Gain of the observer [1/s]. Default: 30, at most a tenth of the rate of the recordings.
        mapping: TOML file that maps columns of files to joints, quantities and units.
        topic: Joint state topic of MCAP files.

    Raises:
        ArmidentError: A format that is not known; a file that cannot be written; recordings that give no thresholds.
    """
    if (false_alarms_per_hour is None) != (without_contact is None):
        _armident.refuse(
            "thresholds need a rate and recordings",
            "false_alarms_per_hour, without_contact",
            "pass both, or neither",
        )
    answer, text = _armident.export(
        as_robot(robot),
        os.fspath(path),
        format,
        false_alarms_per_hour,
        as_recordings(without_contact, mapping, topic),
        as_recordings(holdout, mapping, topic),
        observer_gain,
    )
    result = Export(answer)
    result.text = text
    return result


def info(
    recordings: Path | Iterable[Path],
    *,
    robot: RobotLike | None = None,
    write_mapping: Path | None = None,
    mapping: Path | None = None,
    topic: str | None = None,
) -> Info:
    """What logs hold: format, joints, rate, quality, and the mapping that their names suggest.

    Args:
        recordings: Paths of files, or folders of them.
        robot: Robot that names numbered joints.
        write_mapping: File for the guessed mapping of the first log.
        mapping: TOML file that maps columns to joints, quantities and units.
        topic: Joint state topic of bags of ROS.

    Raises:
        ArmidentError: A file that cannot be read; names that suggest no mapping to be written.
    """
    given = None if robot is None else as_robot(robot)
    paths = _paths(recordings)
    return Info(
        _armident.info(paths, given, _path(write_mapping), _path(mapping), topic)
    )


def convert(
    recording: Recording | Path,
    path: Path,
    *,
    mapping: Path | None = None,
    topic: str | None = None,
) -> Conversion:
    """Convert a log to a file with standard names and SI units.

    Args:
        recording: Recording, path of a file, or a folder with one.
        path: Output file; its extension is the format.
        mapping: TOML file that maps columns to joints, quantities and units.
        topic: Joint state topic of bags of ROS.

    Raises:
        ArmidentError: A log that cannot be read; a format that is not written.
    """
    if isinstance(recording, Recording):
        read = recording
    else:
        one = _armident.one_to_convert(os.fspath(recording), os.fspath(path))
        (read,) = as_recordings(one, mapping, topic)
    answer, omitted = _armident.convert(read, os.fspath(path))
    result = Conversion(answer)
    result.omitted = omitted
    return result


def excite(
    robot: RobotLike,
    folder: Path,
    *,
    limits: Path | None = None,
    keep_out: Path | None = None,
    diagnosis: Path | None = None,
    format: Sequence[Literal["csv", "ros2", "urscript", "json"]] = ("csv",),
    given: RecordingsLike | None = None,
    seconds: float = 20.0,
    budget: float = 30.0,
    rate_hz: float = 100.0,
    only: Sequence[str] = (),
    seed: int = 1992,
    mapping: Path | None = None,
    topic: str | None = None,
) -> Suite:
    """Design the motions of an identification, with the standard errors that they will give.

    Args:
        folder: Output folder for the motions and `suite.toml`, their list.
        limits: TOML file of limits that differ from those of the robot.
        keep_out: TOML file of boxes and planes that the arm keeps out of.
        diagnosis: JSON of a diagnosis: a motion that separates its findings from their alternatives (`--for`).
        format: Formats of the motions.
        given: Recordings that exist already: the training motion adds most to these.
        seconds: Length of the training motion [s].
        budget: Time for the search [s].
        rate_hz: Sample rate of the motions [Hz].
        only: Parts that are designed; all by default.
        seed: Random seed.
        mapping: TOML file that maps columns of `given` to joints, quantities and units.
        topic: Joint state topic of bags of ROS.

    Raises:
        ArmidentError: Limits or regions that cannot be read; a robot without limits.
    """
    recorded = as_recordings(given, mapping, topic)
    with working("designing motions"):
        answer = _armident.excite(
            as_robot(robot),
            os.fspath(folder),
            _path(limits),
            _path(keep_out),
            _path(diagnosis),
            list(format),
            recorded,
            seconds,
            budget,
            rate_hz,
            list(only),
            seed,
        )
    return Suite(answer)


def accumulate(
    robot: RobotLike,
    recordings: Path | Iterable[Path],
    output_file: Path,
    *,
    cutoff_hz: float = 5.0,
    mapping: Path | None = None,
    topic: str | None = None,
) -> Accumulation:
    """Reduce recordings to states: small, merged in any order.

    Args:
        recordings: Paths of files, or folders of them.
        output_file: File of states, continued where it exists.
        cutoff_hz: Low-pass [Hz], the same for all recordings that are merged.
        mapping: TOML file that maps columns to joints, quantities and units.
        topic: Joint state topic of bags of ROS.

    Raises:
        ArmidentError: An output file that holds something else; no recording that can be reduced.
    """
    paths = _paths(recordings)
    with working("reducing recordings"):
        answer = _armident.accumulate(
            as_robot(robot), paths, os.fspath(output_file), cutoff_hz, _path(mapping), topic
        )
    return Accumulation(answer)


def merge(robot: RobotLike, states: Path | Iterable[Path]) -> Merge:
    """Identify an arm from the states of its recordings; `result.model` is the model.

    Args:
        states: Files that `accumulate` has written.

    Raises:
        ArmidentError: A file that cannot be read; no states of this robot.
    """
    return Merge(_armident.merge(as_robot(robot), _paths(states)))


def _path(given: Path | None) -> str | None:
    return None if given is None else os.fspath(given)


def _paths(given: Path | Iterable[Path]) -> list[str]:
    several = [given] if isinstance(given, (str, os.PathLike)) else list(given)
    return [os.fspath(one) for one in several]


def _one_of(name: str, given: str, known: tuple[str, ...]) -> str:
    if given not in known:
        _armident.refuse(f"unknown value `{given}`", name, f"pass one of {', '.join(known)}")
    return given
