"""Velocity, attitude and position of small helicopters and drones, from an inertial unit and a slow GPS.

Frames: position in latitude, longitude and height above the ellipsoid; velocity north, east, down; body axes forward,
right, down; Euler angles 3-2-1 (yaw, pitch, roll), heading 0 = north, clockwise. The specific
force of a level vehicle at rest is -9.81 m/s² along z. Times are seconds on the clock of the log.

    >>> import hovernav as hn
    >>> log = hn.read("datasets/heli-hover")
    >>> solution = hn.estimate(log, smooth=True)
    >>> solution.velocity_ned_mps[-1]
"""

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from . import _pickle as _pickle
from ._errors import ArrayError, ConfigError, Error, FaultError, LogError, ModelError, SetupError
from ._hovernav import (
    Autopilot,
    Campaign,
    Comparison,
    Estimator,
    Finding,
    Log,
    Model,
    Notice,
    Solution,
    State,
    __version__,
    allan,
    campaign,
    compare,
    design,
    estimate,
    identify,
    inject,
    read,
    score,
    simulate,
)
from ._table import Table

if TYPE_CHECKING:
    from . import cluster as cluster


def __getattr__(name: str) -> ModuleType:
    # Loaded at its first use: most programs need no cluster.
    if name == "cluster":
        return import_module(".cluster", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "ArrayError",
    "Autopilot",
    "Campaign",
    "Comparison",
    "ConfigError",
    "Error",
    "Estimator",
    "FaultError",
    "Finding",
    "Log",
    "LogError",
    "Model",
    "ModelError",
    "Notice",
    "SetupError",
    "Solution",
    "State",
    "Table",
    "__version__",
    "allan",
    "campaign",
    "cluster",
    "compare",
    "design",
    "estimate",
    "identify",
    "inject",
    "read",
    "score",
    "simulate",
]
