"""Identification and diagnosis of serial robot arms from a URDF and recordings.

Units are SI: m, rad, s, kg, N m (rotational joints) or N (translational joints).

    import armident

    result = armident.diagnose("robot.urdf", "train.csv", holdout="holdout.csv")
    print(result)
    result.model.predict(q, v, a)
"""

from ._armident import ArmidentError, Recording, Robot, __version__
from ._commands import check, diagnose, export, identify, params, predict, simulate, validate
from ._recordings import read
from ._results import (
    ArmidentWarning,
    Check,
    Diagnosis,
    Export,
    Fields,
    Identification,
    MinimalSet,
    Prediction,
    Result,
    Validation,
)

__all__ = [
    "ArmidentError",
    "ArmidentWarning",
    "Check",
    "Diagnosis",
    "Export",
    "Fields",
    "Identification",
    "MinimalSet",
    "Prediction",
    "Recording",
    "Result",
    "Robot",
    "Validation",
    "__version__",
    "check",
    "diagnose",
    "export",
    "identify",
    "params",
    "predict",
    "read",
    "simulate",
    "validate",
]
