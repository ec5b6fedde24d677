"""Frequency and damping of bolted joints against amplitude, from surface scans and a finite-element model.

Units are SI everywhere, but for scenes, whose fields are in the units that they declare.
"""

from microslip import laws
from microslip._native import version as _version
from microslip.analyses import (
    CqsmaBackbone,
    EpmcBackbone,
    Interface,
    LinearModes,
    Pulse,
    ReducedModel,
    Release,
    RingDown,
    StaticState,
    cqsma,
    epmc,
    reduce,
    transient,
)
from microslip.errors import ConvergenceError, Error, FileError, InputError, SceneError, SolverError
from microslip.results import (
    Backbone,
    Ensemble,
    Fields,
    ForcedResponse,
    InterfaceMesh,
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
    "CqsmaBackbone",
    "Ensemble",
    "EpmcBackbone",
    "Error",
    "Fields",
    "FileError",
    "ForcedResponse",
    "InputError",
    "Interface",
    "InterfaceMesh",
    "LinearModes",
    "MethodBackbone",
    "Mode",
    "ModelWarning",
    "Pulse",
    "ReducedModel",
    "Regime",
    "Release",
    "RingDown",
    "Run",
    "Scene",
    "SceneError",
    "SolverError",
    "StaticState",
    "benchmarks",
    "cqsma",
    "epmc",
    "laws",
    "load",
    "reduce",
    "run",
    "transient",
]

__version__ = _version()
