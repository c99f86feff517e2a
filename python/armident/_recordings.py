"""Arguments of the commands: robots and recordings, in memory or by their paths."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Union

from . import _armident
from ._armident import Recording, Robot
from ._progress import steps

#: A path.
Path = Union[str, "os.PathLike[str]"]
#: A robot, or the path of its URDF or model file.
RobotLike = Union[Robot, Path]
#: Recordings, paths of files, or folders of them; one or several.
RecordingsLike = Union[Recording, Path, Iterable[Union[Recording, Path]]]


def read(
    path: Path | Iterable[Path], *, mapping: Path | None = None, topic: str | None = None
) -> list[Recording]:
    """Read recordings.

    Args:
        path: File (CSV, MCAP, Parquet where built in), folder of files, or several of them.
        mapping: TOML file that maps columns to joints, quantities and units.
        topic: Joint state topic of MCAP files. Default: the only one, else `/joint_states`.

    Raises:
        ArmidentError: A file that cannot be read, or is refused.
    """
    paths = [path] if isinstance(path, (str, os.PathLike)) else list(path)
    mapped = None if mapping is None else os.fspath(mapping)
    return _armident.read([os.fspath(p) for p in paths], mapped, topic)


def as_robot(given: RobotLike) -> Robot:
    """The robot, its file read."""
    return given if isinstance(given, Robot) else Robot(os.fspath(given))


def as_recordings(
    given: RecordingsLike | None, mapping: Path | None = None, topic: str | None = None
) -> list[Recording]:
    """All recordings, their files read."""
    if given is None:
        return []
    several = [given] if isinstance(given, (Recording, str, os.PathLike)) else list(given)
    found: list[Recording] = []
    for one in steps(several, "reading"):
        if isinstance(one, Recording):
            found.append(one)
        else:
            found.extend(read(one, mapping=mapping, topic=topic))
    return found
