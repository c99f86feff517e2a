"""Robots, recordings, and commands that turn them into results."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, overload

import numpy
from numpy.typing import ArrayLike, NDArray

_Path = str | os.PathLike[str]
_Floats = NDArray[numpy.float64]

__version__: str

class ArmidentError(ValueError):
    """What failed, in three lines."""

    what: str
    """What was expected and found."""
    place: str
    """File, line or column, joint; may be empty."""
    hint: str | None
    """What to do."""

class Robot:
    """A robot arm: from a URDF, or a model that was identified or diagnosed."""

    def __init__(
        self,
        path: _Path,
        *,
        base: str | None = None,
        tip: str | None = None,
        lock: Mapping[str, float] | None = None,
        gravity: Sequence[float] | None = None,
        snap_rpy: float | None = None,
    ) -> None:
        """Read a URDF, or a model file (`.json`), which has its chain already.

        Args:
            base: First link of the chain. Default: the root of the URDF.
            tip: Last link of the chain. Default: the tip that contains the recorded joints, else the path with the most
                movable joints.
            lock: Joints locked at a position [rad or m].
            gravity: Gravity in the base link frame [m/s²], three numbers. Default: (0, 0, -9.81).
            snap_rpy: Snap URDF joint angles within this tolerance [rad] to multiples of pi/12. Default: 1e-4.

        Raises:
            ArmidentError: A file that cannot be read or is not valid.
        """
    @property
    def source(self) -> str:
        """Path of the file, or a description of a model in memory."""
    @property
    def is_model(self) -> bool:
        """Whether it is a model that was identified or diagnosed."""
    @property
    def joints(self) -> list[str]:
        """Names of the joints of the arm in order."""
    @property
    def effects(self) -> list[tuple[str, str, list[float]]]:
        """Effects on joints beyond the rigid body: law, joint, parameters in the units of the law."""
    @property
    def omitted_from_arrays(self) -> list[str]:
        """What a diagnosed model holds that `predict(q, v, a)` lacks, one sentence each."""
    @overload
    def predict(self, q: Recording, *, cutoff_hz: float | None = None) -> _Floats:
        """Efforts of a recorded motion at its stamps, shape (samples, joints) [N m or N].

        Args:
            q: Recording with the positions of the joints.
            cutoff_hz: Low-pass of the positions [Hz]. Default: the model's, else from the spectrum of the motion.
        """
    @overload
    def predict(
        self, q: ArrayLike, v: ArrayLike, a: ArrayLike, *, t: ArrayLike | None = None
    ) -> _Floats:
        """Efforts of positions, velocities and accelerations as they are, shape (samples, joints) [N m or N].

        A diagnosed model predicts recordings from their positions; of arrays it predicts what a simulated arm has,
        without `omitted_from_arrays`.

        Args:
            q: Positions [rad or m], shape (samples, joints).
            v: Velocities [rad/s or m/s], shape (samples, joints).
            a: Accelerations [rad/s² or m/s²], shape (samples, joints).
            t: Times [s], shape (samples,), for laws with a memory, such as presliding friction. Default: 10 ms a row.

        Raises:
            ArmidentError: Arrays of other shapes.
        """
    def save(self, path: _Path) -> None:
        """Write the model as JSON, for every command that takes a robot."""

class Recording:
    """Time stamps and joint channels of one measured run, checked and repaired as on the command line."""

    def __init__(
        self, path: _Path, *, mapping: _Path | None = None, topic: str | None = None
    ) -> None:
        """Read a file (CSV, MCAP, Parquet where built in).

        Args:
            mapping: TOML file that maps columns to joints, quantities and units.
            topic: Joint state topic of an MCAP file. Default: the only one, else `/joint_states`.

        Raises:
            ArmidentError: A file that cannot be read, or is refused.
        """
    @staticmethod
    def from_arrays(
        time: ArrayLike,
        joints: Sequence[str],
        *,
        position: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        effort: ArrayLike | None = None,
        current: ArrayLike | None = None,
        voltage: ArrayLike | None = None,
        motor_position: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
        command: ArrayLike | None = None,
        source: str = "arrays",
    ) -> Recording:
        """Recording in arrays, with the checks and repairs of a file.

        Args:
            time: Time stamps [s], shape (samples,).
            joints: Names of the joints, as in the URDF.
            position: Positions [rad or m], shape (samples, joints), as all others.
            velocity: Velocities [rad/s or m/s].
            acceleration: Accelerations [rad/s² or m/s²].
            effort: Efforts on the joint side [N m or N].
            current: Motor currents [A].
            voltage: Motor voltages [V].
            motor_position: Motor encoders divided by the gear ratio [rad or m].
            temperature: Temperatures of motors or drives [°C].
            command: Positions that the controllers of the joints are given [rad or m].
            source: Name of the recording in results.

        Raises:
            ArmidentError: Arrays of other shapes, or no usable recording.
        """
    @staticmethod
    def from_table(
        table: Any, *, mapping: _Path | None = None, source: str = "table"
    ) -> Recording:
        """Recording in a table whose columns are named as those of a file, with the checks and repairs of a file.

        Args:
            table: pandas or Polars data frame, Arrow table, or dict of arrays, with a column `t` [s] and columns
                `<joint>/<quantity>`, or what the mapping expects.
            mapping: TOML file that maps columns to joints, quantities and units.
            source: Name of the recording in results.

        Raises:
            ArmidentError: Columns that are not numbers, or no usable recording.
        """
    @property
    def source(self) -> str:
        """Path of the file, or a description."""
    @property
    def joints(self) -> list[str]:
        """Names of the joints in order."""
    @property
    def time(self) -> _Floats:
        """Time stamps [s], shape (samples,)."""
    @property
    def notes(self) -> list[str]:
        """Repairs on reading, one sentence each."""
    @property
    def ignored_columns(self) -> list[str]:
        """Columns of the file that are not used."""
    def channel(self, quantity: str) -> _Floats | None:
        """Samples of one quantity of all joints in SI units, shape (samples, joints); None unless every joint has it.

        Args:
            quantity: `position`, `velocity`, `acceleration`, `effort`, `current`, `voltage`, `motor_position`,
                `temperature` or `command`.
        """
    def quality_notes(self) -> list[str]:
        """Gaps, stuck or saturated channels and other findings that reading keeps, one sentence each."""
    def save(self, path: _Path) -> list[str]:
        """Write the recording in the format of the extension.

        Returns:
            Channels that the format cannot hold.
        """
    def __len__(self) -> int:
        """Number of samples."""

class Answer:
    """The result of a command; `armident.Result` gives its fields."""

    def json(self) -> str: ...
    def document(self, traces: bool) -> str: ...
    def text(self) -> str: ...
    def page(self) -> str: ...
    def save_mcap(self, path: str) -> None: ...
    def save_card(self, path: str, serial: str | None, date: str | None) -> None: ...
    def excerpt(self) -> str: ...
    def model(self) -> Robot | None: ...
    def warnings(self) -> list[str]: ...
    def notes(self) -> list[str]: ...

def read(paths: Sequence[str], mapping: str | None, topic: str | None) -> list[Recording]: ...
def refuse(what: str, place: str, hint: str) -> None: ...
def schemas() -> list[tuple[str, str]]: ...
def params(robot: Robot) -> Answer: ...
def check(robot: Robot, recordings: list[Recording], cutoff_hz: float | None) -> Answer: ...
def identify(
    robot: Robot,
    recordings: list[Recording],
    holdout: list[Recording],
    plan: str | None,
    cutoff_hz: float | None,
    method: str,
    cross_validate: bool,
    prior: bool,
    payloads: list[tuple[str, float, Sequence[float] | None, float]],
    couplings: bool,
    sublinear: bool,
    raw_estimate: bool,
) -> Answer: ...
def diagnose(
    robot: Robot,
    recordings: list[Recording],
    holdout: list[Recording],
    reference: list[Recording],
    placebo: int | None,
    replay: bool,
    trust_columns: bool,
    next_motion: str | None,
) -> tuple[Answer, Recording | None]: ...
def validate(
    robot: Robot, recordings: list[Recording], cutoff_hz: float | None, replay: bool
) -> Answer: ...
def predict(
    robot: Robot, motion: Recording, cutoff_hz: float | None
) -> tuple[Answer, Recording]: ...
def simulate(
    robot: Robot,
    trajectories: list[Recording],
    forward: bool,
    torque_noise: str | None,
    encoder_bits: int | None,
    rate_hz: float | None,
    effects: list[tuple[str, str, list[float]]],
    seed: int,
) -> tuple[list[Recording], list[str]]: ...
def export(
    robot: Robot,
    path: str,
    format: str | None,
    false_alarms_per_hour: float | None,
    without_contact: list[Recording],
    holdout: list[Recording],
    observer_gain: float | None,
) -> tuple[Answer, str]: ...
def info(
    recordings: list[str],
    robot: Robot | None,
    write_mapping: str | None,
    mapping: str | None,
    topic: str | None,
) -> Answer: ...
def convert(recording: Recording, path: str) -> tuple[Answer, list[str]]: ...
def one_to_convert(recording: str, path: str) -> str: ...
def excite(
    robot: Robot,
    folder: str,
    limits: str | None,
    keep_out: str | None,
    diagnosis: str | None,
    formats: list[str],
    given: list[Recording],
    seconds: float,
    budget: float,
    rate_hz: float,
    only: list[str],
    seed: int,
) -> Answer: ...
def accumulate(
    robot: Robot,
    recordings: list[str],
    output_file: str,
    cutoff_hz: float,
    mapping: str | None,
    topic: str | None,
) -> Answer: ...
def merge(robot: Robot, states: list[str]) -> Answer: ...
def fleet(
    robot: Robot,
    inputs: list[str],
    robot_of: str | None,
    states: str | None,
    cutoff_hz: float,
    false_alarm_rate: float,
    mapping: str | None,
    topic: str | None,
) -> Answer: ...
