"""Visual-inertial odometry with points and lines: docs/guide/python.md."""

from ._plumbline import (
    Error,
    Estimator,
    Refused,
    Run,
    State,
    Trajectory,
    __version__,
    configurations,
    evaluate,
    run,
)

__all__ = [
    "Error",
    "Estimator",
    "Refused",
    "Run",
    "State",
    "Trajectory",
    "__version__",
    "configurations",
    "evaluate",
    "run",
]
