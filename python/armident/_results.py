"""Results of commands."""

from __future__ import annotations

import json
import os
import warnings
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ._armident import Answer, Recording, Robot

if TYPE_CHECKING:
    from ._fields import CheckReport, DiagnoseReport, FleetReport, IdentifyReport, ValidateReport
else:
    # the fields come from the JSON
    CheckReport = DiagnoseReport = FleetReport = IdentifyReport = ValidateReport = object


class ArmidentWarning(UserWarning):
    """What is wrong and its consequence, with a code in brackets."""


class Fields(dict):  # type: ignore[type-arg]
    """Fields of a result: a dict whose keys are attributes too."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"no field {name!r}; fields: {', '.join(self)}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]


class Result:
    """Result of a command: its fields are attributes, in SI units; `str` is the text of the command line."""

    def __init__(self, answer: Answer) -> None:
        self._answer = answer
        for warning in answer.warnings():
            warnings.warn(warning, ArmidentWarning, stacklevel=3)

    @cached_property
    def fields(self) -> Fields:
        """All fields, as documented in docs/json.md."""
        fields: Fields = json.loads(self._answer.json(), object_hook=Fields)
        return fields

    @property
    def warnings(self) -> list[str]:
        """What is wrong and its consequence, each with a code in brackets."""
        return self._answer.warnings()

    @property
    def notes(self) -> list[str]:
        """Automatic choices and repairs."""
        return self._answer.notes()

    def __getattr__(self, name: str) -> Any:
        # fields that are absent have nothing to report
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self.fields, name)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.fields]

    def to_dict(self) -> dict[str, Any]:
        """The JSON of the command line, in dicts and lists."""
        document: dict[str, Any] = json.loads(self._answer.json())
        return document

    def to_json(self, *, traces: bool = False) -> str:
        """The JSON of the command line; with chart data for `armident report` where `traces`."""
        return self._answer.document(traces)

    def save_report(self, path: str | os.PathLike[str]) -> None:
        """Write the HTML report: one file with charts, for any browser."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._answer.page())

    def __str__(self) -> str:
        return self._answer.text()

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {str(self).splitlines()[0]}>"

    def _repr_html_(self) -> str:
        return self._answer.excerpt()


class ModelResult(Result):
    """Result with a model."""

    @cached_property
    def model(self) -> Robot | None:
        """The model, for every command that takes a robot; None where there is none."""
        return self._answer.model()


class MinimalSet(Result):
    """Driving-axis frames and minimal set of an arm."""


class Check(Result, CheckReport):
    """Checks of recordings: signs, units, order, delay, noise and excitation."""


class Identification(ModelResult, IdentifyReport):
    """Inertia and friction parameters with their standard errors, and the identified model."""

    def save_card(
        self, path: str | os.PathLike[str], *, serial: str | None = None, date: str | None = None
    ) -> None:
        """Write the model card: an HTML page, and its JSON beside it.

        Args:
            path: File with the extension `.html`.
            serial: Serial number of the arm.
            date: Date of the recordings. Default: that of their stamps, where these count from 1970.
        """
        self._answer.save_card(os.fspath(path), serial, date)


class TopicsResult(Result):
    """Result of recordings that can be seen beside predictions."""

    def save_mcap(self, path: str | os.PathLike[str]) -> None:
        """Write the recordings with predicted efforts, residuals and findings as topics of MCAP, for Foxglove, PlotJuggler
        and Rerun."""
        self._answer.save_mcap(os.fspath(path))


class Diagnosis(TopicsResult, ModelResult, DiagnoseReport):
    """Effects that a model lacks, and the model with them."""

    #: Motion that separates indistinguishable effects, where it was requested and exists.
    separating_motion: Recording | None = None


class Validation(TopicsResult, ValidateReport):
    """Errors of a model on recordings that it was not fitted to."""


class Prediction(Result):
    """Efforts of a motion."""

    #: The efforts at the stamps of the motion [N m or N].
    efforts: Recording


class Info(Result):
    """What logs hold, and the mapping that their names suggest."""


class Conversion(Result):
    """A log that was converted."""

    #: Channels that the format cannot hold, `<joint>/<quantity>`.
    omitted: list[str]


class Suite(Result):
    """Motions of an identification, with the standard errors that they will give."""


class Accumulation(Result):
    """Recordings that were reduced to states."""


class Merge(ModelResult):
    """The arm that states of its recordings identify, and its model."""


class History(Result, FleetReport):
    """Robots over their recordings: trends, changes, and what is unlike the fleet."""


class Export(Result):
    """What was exported, and what the format could not hold."""

    #: The file as text.
    text: str
