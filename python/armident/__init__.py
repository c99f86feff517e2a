"""Identification and diagnosis of serial robot arms from a URDF and recordings.

Units are SI: m, rad, s, kg, N m (rotational joints) or N (translational joints).

    import armident

    result = armident.diagnose("robot.urdf", "train.csv", holdout="holdout.csv")
    print(result)
    result.model.predict(q, v, a)
"""

from ._armident import ArmidentError, Recording, Robot, __version__
from ._commands import (
    accumulate,
    check,
    convert,
    diagnose,
    excite,
    export,
    identify,
    info,
    merge,
    params,
    predict,
    simulate,
    validate,
)
from ._progress import show_progress
from ._recordings import read
from ._results import (
    Accumulation,
    ArmidentWarning,
    Check,
    Conversion,
    Diagnosis,
    Export,
    Fields,
    Identification,
    Info,
    Merge,
    MinimalSet,
    Prediction,
    Result,
    Suite,
    Validation,
)

__all__ = [
    "Accumulation",
    "ArmidentError",
    "ArmidentWarning",
    "Check",
    "Conversion",
    "Diagnosis",
    "Export",
    "Fields",
    "Identification",
    "Info",
    "Merge",
    "MinimalSet",
    "Prediction",
    "Recording",
    "Result",
    "Robot",
    "Suite",
    "Validation",
    "__version__",
    "accumulate",
    "check",
    "convert",
    "diagnose",
    "excite",
    "export",
    "identify",
    "info",
    "merge",
    "params",
    "predict",
    "read",
    "show_progress",
    "simulate",
    "validate",
]
