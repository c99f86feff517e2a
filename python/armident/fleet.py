"""Fleets on engines that exist: recordings reduced by Ray Data, states merged by Ray Data or DataFusion.

The unit of work is one recording. What leaves a worker is its state, some ten kilobytes a joint, or its findings.

    import ray
    from armident import fleet

    paths = ray.data.from_items([{"path": "logs/arm-1/day1.csv"}, {"path": "logs/arm-2/day1.csv"}])
    found = fleet.identify(paths, robot="robot.urdf")
    found.robots["arm-1"].model.save("arm-1.json")

Ray and DataFusion are not installed with armident: `pip install ray pyarrow pandas`, `pip install datafusion`.
"""

from __future__ import annotations

import importlib
import json
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from . import _armident
from ._armident import ArmidentError
from ._commands import _path, _paths, accumulate, merge
from ._commands import diagnose as diagnose_one
from ._progress import working
from ._recordings import RobotLike, as_robot
from ._results import History, Merge

__all__ = [
    "Fleet",
    "History",
    "SetAside",
    "diagnose",
    "follow",
    "from_parquet",
    "identify",
    "merge_states",
    "register",
    "states",
    "to_parquet",
    "write",
]

#: Columns of a table of states, a row for each recording and joint, and its version.
TABLE = "armident.state-table/1"
#: Size of a column of a triangle, of the largest, below which it is none.
ZERO_COLUMN = 1e-10
#: Recordings of a row group: what is in memory when a table is written or read.
GROUP = 8

#: A Ray dataset with a column `path` and, if robots are not the folders, a column `robot`.
Paths = Any


@dataclass(frozen=True)
class SetAside:
    """A recording that is not part of the result, and why."""

    recording: str
    robot: str
    reason: str


@dataclass
class Fleet:
    """The robots of a fleet, each identified from the states of its recordings."""

    #: By name.
    robots: dict[str, Merge] = field(default_factory=dict)
    #: Recordings that could not be used.
    set_aside: list[SetAside] = field(default_factory=list)
    #: Bytes of states that left the workers.
    state_bytes: int = 0


def merge_states(robot: str | os.PathLike[str], states: Iterable[str]) -> Merge:
    """Identify an arm from states as text, in any order.

    The sums run in the order of the recordings' names, so that the result has the same bits however the states came.
    """
    ordered = sorted(states, key=lambda state: str(json.loads(state)["recording"]))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "states.jsonl"
        path.write_text("\n".join(state.strip() for state in ordered) + "\n")
        return merge(robot, path)


def _reduce(robot: str, path: str, name: str, cutoff_hz: float) -> dict[str, Any]:
    """State of one recording, or the reason why it has none."""
    row: dict[str, Any] = {"robot": name, "recording": path, "state": None, "reason": None}
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "state.jsonl"
        try:
            accumulate(robot, path, output, cutoff_hz=cutoff_hz)
        except ArmidentError as error:
            row["reason"] = str(error)
            return row
        state = json.loads(output.read_text())
    state["robot"] = name
    row["state"] = json.dumps(state, separators=(",", ":"))
    return row


def _name(row: dict[str, Any], robot_of: Callable[[str], str] | None) -> str:
    """The robot of a recording: a column, a function of its path, or its folder."""
    if row.get("robot") is not None:
        return str(row["robot"])
    path = str(row["path"])
    return robot_of(path) if robot_of else Path(path).parent.name


def states(
    recordings: Paths,
    *,
    robot: str | os.PathLike[str],
    cutoff_hz: float = 5.0,
    robot_of: Callable[[str], str] | None = None,
) -> Any:
    """Reduce each recording to its state: a Ray dataset of `robot`, `recording`, `state` and `reason`.

    Args:
        recordings: Ray dataset with a column `path`, which every worker can read, and perhaps a column `robot`.
        robot: URDF or model file, which every worker can read.
        cutoff_hz: Low-pass [Hz], the same for all recordings that are merged.
        robot_of: Name of the robot from the path, where there is no column; the folder by default.

    A task that is lost with its worker is run again by Ray; a recording that cannot be used has a `reason` and no `state`.
    """
    urdf = os.fspath(robot)

    def reduced(row: dict[str, Any]) -> dict[str, Any]:
        return _reduce(urdf, str(row["path"]), _name(row, robot_of), cutoff_hz)

    return recordings.map(reduced)


def identify(
    recordings: Paths,
    *,
    robot: str | os.PathLike[str],
    cutoff_hz: float = 5.0,
    robot_of: Callable[[str], str] | None = None,
) -> Fleet:
    """Identify each robot of a fleet from its recordings, on Ray Data; arguments as [`states`][armident.fleet.states].

    The parameters are those of `armident accumulate` and `armident merge` in one process.
    """
    found = Fleet()
    by_robot: dict[str, dict[str, str]] = {}
    reduced = states(recordings, robot=robot, cutoff_hz=cutoff_hz, robot_of=robot_of)
    for row in reduced.iter_rows():
        if row["state"] is None:
            found.set_aside.append(SetAside(row["recording"], row["robot"], row["reason"]))
            continue
        found.state_bytes += len(row["state"])
        # a recording that is there twice counts once
        by_robot.setdefault(row["robot"], {})[row["recording"]] = row["state"]
    found.set_aside.sort(key=lambda aside: aside.recording)
    for name in sorted(by_robot):
        found.robots[name] = merge_states(robot, by_robot[name].values())
    return found


def follow(
    robot: RobotLike,
    inputs: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    *,
    robot_of: str | None = None,
    states: str | os.PathLike[str] | None = None,
    cutoff_hz: float = 5.0,
    false_alarm_rate: float = 0.01,
    mapping: str | os.PathLike[str] | None = None,
    topic: str | None = None,
) -> History:
    """Follow the robots of a fleet over their recordings: trends, changes and outliers, as `armident fleet`.

    Args:
        robot: URDF or model file, or a robot.
        inputs: Files of states, recordings, and folders of both.
        robot_of: Which robot a recording is of: a pattern of the end of its path, `{robot}/*.csv`; its folder by default.
        states: File of states that recordings are reduced to, continued where it exists.
        cutoff_hz: Low-pass of recordings [Hz].
        false_alarm_rate: Probability that a robot that does not change has a change reported.
        mapping: TOML file that maps columns to joints, quantities and units.
        topic: Joint state topic of bags of ROS.

    Raises:
        ArmidentError: Inputs that cannot be read; no state of this robot.
    """
    with working("following robots"):
        answer = _armident.fleet(
            as_robot(robot),
            _paths(inputs),
            robot_of,
            _path(states),
            cutoff_hz,
            false_alarm_rate,
            _path(mapping),
            topic,
        )
    return History(answer)


def write(states: Any, path: str | os.PathLike[str]) -> list[SetAside]:
    """Write states of a Ray dataset to a file for `armident merge` and `armident fleet`, one after another.

    Returns the recordings that have none.
    """
    aside = []
    with open(path, "w", encoding="utf-8") as file:
        for row in states.iter_rows():
            if row["state"] is None:
                aside.append(SetAside(row["recording"], row["robot"], row["reason"]))
            else:
                file.write(row["state"] + "\n")
    return sorted(aside, key=lambda of: of.recording)


def _residual(triangle: list[float]) -> float:
    """Root of the sum of squares that the columns of a triangle leave of its effort."""
    width = round(((8 * len(triangle) + 1) ** 0.5 - 1) / 2)
    dense = np.zeros((width, width))
    dense[np.triu_indices(width)] = triangle
    columns, effort = dense[:, :-1], dense[:, -1]
    norms = np.linalg.norm(columns, axis=0)
    # a column of round-off explains nothing
    there = norms > ZERO_COLUMN * norms.max(initial=0.0)
    unit = columns[:, there] / norms[there]
    solved = np.linalg.lstsq(unit, effort, rcond=1e-9)[0]
    return float(np.linalg.norm(effort - unit @ solved))


def to_parquet(states: str | os.PathLike[str], path: str | os.PathLike[str]) -> int:
    """Write a file of states as a Parquet table, a row for each recording and joint; returns the number of recordings.

    [`accumulate`][armident.accumulate] writes the same table where its file is named `.parquet`, and `merge` and the command
    line read it.

    Columns: schema, robot, recording, recorded_at_s, joint, rows, effective_rows, noise (root mean square of what the columns
    leave of the effort [N m or N]), triangle (upper triangle of the columns and the effort, row by row), effort_sum,
    effort_squares, and `head`: all of the state that is not of one joint, as JSON.
    """
    pa: Any = importlib.import_module("pyarrow")
    parquet: Any = importlib.import_module("pyarrow.parquet")
    text, number, whole = pa.string(), pa.float64(), pa.int64()
    columns = {"schema": text, "robot": text, "recording": text, "recorded_at_s": number, "joint": text}
    columns |= {"rows": whole, "effective_rows": number, "noise": number, "triangle": pa.list_(number)}
    columns |= {"effort_sum": number, "effort_squares": number, "head": text}
    schema = pa.schema(list(columns.items()))
    count, rows = 0, []
    with parquet.ParquetWriter(path, schema, compression="zstd") as writer, open(states, encoding="utf-8") as lines:
        for line in lines:
            if not line.strip():
                continue
            state = json.loads(line)
            joints = state.pop("joints")
            count += 1
            shared = {"schema": TABLE, "recording": state["recording"], "head": json.dumps(state)}
            shared |= {"robot": state.get("robot"), "recorded_at_s": state.get("recorded_at_s")}
            for name, of in zip(state["arm"]["joints"], joints, strict=True):
                samples, total, squares = of["effort"]
                row = shared | {"joint": name, "rows": of["rows"], "triangle": of["triangle"]}
                row |= {"effective_rows": of["rows"] * state["independent_share"]}
                row |= {"noise": _residual(of["triangle"]) / max(samples, 1) ** 0.5}
                rows.append(row | {"effort_sum": total, "effort_squares": squares})
            if count % GROUP == 0:
                writer.write_table(pa.Table.from_pylist(rows, schema=schema))
                rows = []
        if rows:
            writer.write_table(pa.Table.from_pylist(rows, schema=schema))
    return count


def from_parquet(path: str | os.PathLike[str], states: str | os.PathLike[str]) -> int:
    """Write the states of a Parquet table to a file for `armident merge` and `armident fleet`; the number of recordings.

    Rows may be in any order inside a row group; those of one recording stand in one.
    """
    parquet: Any = importlib.import_module("pyarrow.parquet")
    count = 0
    table = parquet.ParquetFile(path)
    with open(states, "w", encoding="utf-8") as file:
        for group in range(table.num_row_groups):
            recordings: dict[str, dict[str, dict[str, Any]]] = {}
            for row in table.read_row_group(group).to_pylist():
                if row["schema"] != TABLE:
                    raise ValueError(f"{path}: expected a table `{TABLE}`, found `{row['schema']}`; write it with to_parquet")
                recordings.setdefault(row["head"], {})[row["joint"]] = row
            for head, by_joint in recordings.items():
                state = json.loads(head)
                missing = [joint for joint in state["arm"]["joints"] if joint not in by_joint]
                if missing:
                    raise ValueError(f"{path}: {state['recording']} has no row of joint {', '.join(missing)}")
                ordered = [by_joint[joint] for joint in state["arm"]["joints"]]
                state["joints"] = [
                    {
                        "rows": row["rows"],
                        "triangle": row["triangle"],
                        "effort": [row["rows"], row["effort_sum"], row["effort_squares"]],
                    }
                    for row in ordered
                ]
                file.write(json.dumps(state, separators=(",", ":")) + "\n")
                count += 1
    return count


def _findings(robot: str, path: str, name: str, holdout: str | None) -> Iterator[dict[str, Any]]:
    """Findings of one recording as rows; one row without a law where there is none or it could not be used."""
    base: dict[str, Any] = {"robot": name, "recording": path, "joint": None, "law": None, "parameter": None}
    base |= {"value": None, "sigma": None, "materiality": None, "holdout_gain": None, "confidence": None, "reason": None}
    try:
        result = diagnose_one(robot, path, holdout=holdout).to_dict()
    except ArmidentError as error:
        yield base | {"reason": str(error)}
        return
    rows = 0
    for finding in result["findings"]:
        place = finding.get("link") or ", ".join(finding.get("joints", []))
        row = base | {"joint": place, "law": finding["effect"]}
        row |= {key: finding["evidence"].get(key) for key in ("materiality", "holdout_gain")}
        row |= {"confidence": finding["confidence"]}
        for parameter, estimate in finding["parameters"].items():
            rows += 1
            yield row | {"parameter": parameter, "value": estimate["value"], "sigma": estimate["stderr"]}
    if rows == 0:
        yield base


def diagnose(
    recordings: Paths,
    *,
    robot: str | os.PathLike[str],
    robot_of: Callable[[str], str] | None = None,
    holdout_of: Callable[[str], str | None] | None = None,
) -> Any:
    """Diagnose each recording on its own: a Ray dataset of findings, one row a parameter, for `write_parquet`.

    Args:
        recordings: As in [`states`][armident.fleet.states].
        robot: URDF or model file, which every worker can read.
        robot_of: Name of the robot from the path, where there is no column; the folder by default.
        holdout_of: Path of another recording of the same robot, held out, from the path; none by default.

    Columns: robot, recording, joint (or link), law, parameter, value, sigma (standard error), materiality (in noise levels),
    holdout_gain (share of the squared hold-out error that the finding removes), confidence, and the reason where a recording
    could not be used.
    """
    urdf = os.fspath(robot)

    def found(row: dict[str, Any]) -> list[dict[str, Any]]:
        path = str(row["path"])
        return list(_findings(urdf, path, _name(row, robot_of), holdout_of(path) if holdout_of else None))

    return recordings.flat_map(found)


def register(context: Any, *, robot: str | os.PathLike[str]) -> None:
    """Add the aggregate function `armident_merge(state)` to a DataFusion session: states to a model, as JSON.

        SELECT robot, armident_merge(state) AS model FROM states GROUP BY robot

    Args:
        context: `datafusion.SessionContext`.
        robot: URDF or model file.
    """
    # not installed with armident, and without types
    pa: Any = importlib.import_module("pyarrow")
    datafusion: Any = importlib.import_module("datafusion")
    urdf = os.fspath(robot)

    class Merged(datafusion.Accumulator):  # type: ignore[misc]
        """States of one group, kept by recording."""

        def __init__(self) -> None:
            self.states: dict[str, str] = {}

        def update(self, *values: Any) -> None:
            for state in values[0].to_pylist():
                if state is not None:
                    self.states[str(json.loads(state)["recording"])] = state

        def merge(self, states: Any) -> None:
            columns = states if isinstance(states, list) else [states]
            for column in columns:
                for entry in column.to_pylist():
                    lists = entry if isinstance(entry, list) else [entry]
                    for state in (line for text in lists for line in str(text).splitlines()):
                        self.states[str(json.loads(state)["recording"])] = state

        def state(self) -> list[Any]:
            return [pa.scalar("\n".join(self.states.values()))]

        def evaluate(self) -> Any:
            if not self.states:
                return pa.scalar(None, pa.string())
            return pa.scalar(json.dumps(merge_states(urdf, self.states.values()).to_dict()))

    function = datafusion.udaf(Merged, pa.string(), pa.string(), [pa.string()], "stable", name="armident_merge")
    context.register_udaf(function)
