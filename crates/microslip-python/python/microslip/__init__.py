"""Frequency and damping of bolted joints against amplitude, from surface scans and a finite-element model.

Units are SI everywhere, but for scenes, whose fields are in the units that they declare.
"""

from microslip._native import version as _version
from microslip.errors import ConvergenceError, Error, FileError, InputError, SceneError, SolverError
from microslip.results import (
    Backbone,
    Ensemble,
    Fields,
    ForcedResponse,
    Interface,
    MethodBackbone,
    Mode,
    ModelWarning,
    Regime,
    Run,
    load,
    run,
)
from microslip.scene import Scene, benchmarks

__all__ = [
    "Backbone",
    "ConvergenceError",
    "Ensemble",
    "Error",
    "Fields",
    "FileError",
    "ForcedResponse",
    "InputError",
    "Interface",
    "MethodBackbone",
    "Mode",
    "ModelWarning",
    "Regime",
    "Run",
    "Scene",
    "SceneError",
    "SolverError",
    "benchmarks",
    "load",
    "run",
]

__version__ = _version()
