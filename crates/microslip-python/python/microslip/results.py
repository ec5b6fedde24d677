"""Runs and their results."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np
import numpy.typing as npt

from microslip import _native
from microslip.errors import FileError, InputError
from microslip.scene import Scene

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

__all__ = [
    "Backbone",
    "Ensemble",
    "Fields",
    "ForcedResponse",
    "InterfaceMesh",
    "MethodBackbone",
    "Mode",
    "ModelWarning",
    "Regime",
    "Run",
    "load",
    "run",
]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Truths = npt.NDArray[np.bool_]

_Row = Mapping[str, Any]
_PointFields = tuple[Floats, Floats, npt.NDArray[np.uint8], Floats]
_Table = TypeVar("_Table", "Backbone", "MethodBackbone")


class Regime(IntEnum):
    """What a point of the interface does.

    Examples
    --------
    >>> import microslip
    >>> microslip.Regime(1).name
    'SLIP'
    """

    STICK = 0
    """In contact below the slip limit."""
    SLIP = 1
    """In contact at the slip limit."""
    OPEN = 2
    """No contact."""
    INVALID = 3
    """Not finite."""


def _floats(values: Iterable[float | None]) -> Floats:
    """Numbers, with NaN for those that are missing."""
    return np.array([math.nan if value is None else value for value in values], dtype=np.float64)


def _equal(left: Any, right: Any) -> bool:
    """Whether two values of fields are the same, arrays bit by bit but for the kind of NaN."""
    if isinstance(left, np.ndarray):
        if not isinstance(right, np.ndarray):
            return False
        return np.array_equal(left, right, equal_nan=left.dtype.kind == "f")
    if isinstance(left, tuple) and isinstance(right, tuple):
        return len(left) == len(right) and all(map(_equal, left, right))
    if isinstance(left, dict) and isinstance(right, dict):
        return left.keys() == right.keys() and all(_equal(left[key], right[key]) for key in left)
    return bool(left == right)


class _Comparable:
    """Dataclasses that hold arrays: nobody may write to them, and they can be compared."""

    def __post_init__(self) -> None:
        for value in self.__dict__.values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return NotImplemented
        return all(_equal(getattr(self, f.name), getattr(other, f.name)) for f in fields(self) if f.compare)  # type: ignore[arg-type]

    __hash__ = None  # type: ignore[assignment]

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        # Pickling forgets that arrays must not be written to.
        self.__post_init__()


@dataclass(frozen=True, eq=False)
class Backbone(_Comparable):
    """Frequency and damping against amplitude, by coupled quasi-static modal analysis.

    All arrays run over the amplitudes, ascending, and have shape ``(n,)`` unless stated. What did not converge is NaN, or -1 where
    numbers are whole.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 3})
    >>> backbone = microslip.run(scene).modes[0].backbone
    >>> backbone.frequency_hz.shape, bool(backbone.converged.all())
    ((3,), True)
    """

    status: npt.NDArray[np.str_]
    """``"resolved"``, ``"below-floor"``, ``"below-round-off"``, ``"no-equilibrium"`` or ``"not-converged"``."""
    modal_force: Floats
    """Peak modal force (sqrt(kg) m/s^2)."""
    modal_amplitude: Floats
    """Modal amplitude (sqrt(kg) m)."""
    frequency_hz: Floats
    """Secant frequency (Hz)."""
    frequency_first_harmonic_hz: Floats
    """Frequency of the first harmonic of the modal force in a sinusoidal motion (Hz)."""
    half_frequencies_hz: Floats
    """Secant frequencies of the halves of positive and of negative modal force (Hz), shape ``(n, 2)``."""
    damping_ratio: Floats
    """Total damping ratio, friction plus background; NaN below the floor."""
    friction_damping_ratio: Floats
    """Part of it due to friction."""
    damping_ratio_first_harmonic: Floats
    """Total damping ratio with the frequency of the first harmonic in the place of the secant one."""
    damping_floor: Floats
    """What residuals and an open loop may make of the friction part."""
    dissipation: Floats
    """Energy dissipated per cycle, summed over the points (J)."""
    loop_area: Floats
    """The same from the modal loop (J)."""
    coarse_loop_area: Floats
    """The same from every second vertex of the loop (J)."""
    response_acceleration: Floats
    """Acceleration amplitude at the response point by the linearised mode (m/s^2)."""
    response_displacement: Floats
    """Displacement amplitude at the response point by the linearised mode (m)."""
    response_motion: Floats
    """Half the range of the displacement at the response point over the loop (m)."""
    slip_fraction: Floats
    """Area fraction that slips at the positive peak."""
    open_fraction: Floats
    """Area fraction that is open there."""
    shape_deviation: Floats
    """Part of the peak motion that is mass-orthogonal to the mode."""
    loop_closure: Floats
    """Distance between the ends of the loop relative to the motion there (energy norm)."""
    residual: Floats
    """Largest residual of a vertex relative to the peak load (energy norm)."""
    load_points: Integers
    """Equilibria found, all cycles together."""
    iterations: Integers
    """Newton iterations of the whole loop."""
    evaluations: Integers
    """Evaluations of the interface."""
    krylov_steps: Integers
    """Preconditioned Krylov steps."""
    factorisations: Integers
    """Direct factorisations."""
    cycles: Integers
    """Cycles computed, the measured one included."""
    converged: Truths
    """Whether all vertices converged."""
    failure: tuple[str | None, ...]
    """Why an amplitude did not converge."""


@dataclass(frozen=True, eq=False)
class MethodBackbone(_Comparable):
    """Frequency and damping against amplitude, by a method beside CQSMA.

    All arrays run over the amplitudes, ascending, and have shape ``(n,)``. What did not converge, and what a method does not give, is
    NaN, or -1 where numbers are whole.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick")
    >>> scene = scene.replace({"analyses.backbone": {"amplitudes": 3, "methods": ["masing"]}})
    >>> microslip.run(scene).methods["masing"].frequency_hz.shape
    (3,)
    """

    response_displacement: Floats
    """Displacement amplitude at the response point (m)."""
    frequency_hz: Floats
    """Secant frequency (Hz)."""
    frequency_first_harmonic_hz: Floats
    """Frequency of the first harmonic (Hz)."""
    damping_ratio: Floats
    """Total damping ratio, friction plus background; NaN below the floor."""
    damping_floor: Floats
    """What residuals may make of the friction part."""
    modal_force: Floats
    """Modal force (sqrt(kg) m/s^2)."""
    modal_amplitude: Floats
    """Modal amplitude (sqrt(kg) m)."""
    residual: Floats
    """Residual relative to the load (energy norm)."""
    dissipation: Floats
    """Energy that the contact takes per period (J), by ``epmc`` alone."""
    energy_error: Floats
    """What is missing in the balance of energies, as a damping ratio, by ``epmc`` alone."""
    drift: Floats
    """Change of the tractions from the last period to the one before, relative to their range, by ``epmc`` alone."""
    harmonics: Integers
    """Highest harmonic, by ``epmc`` alone."""
    samples: Integers
    """Samples per period, by ``epmc`` alone."""
    iterations: Integers
    """Newton iterations, by ``epmc`` alone."""
    evaluations: Integers
    """Residuals evaluated, by ``epmc`` alone."""
    krylov_steps: Integers
    """Preconditioned Krylov steps, by ``epmc`` alone."""
    converged: Truths
    """Whether it converged."""
    failure: tuple[str | None, ...]
    """Why an amplitude did not converge."""


def _table(kind: type[_Table], rows: Sequence[_Row]) -> _Table:
    """The columns of a table whose rows are those of a summary."""
    columns: dict[str, Any] = {}
    for column in fields(kind):
        values = [row.get(column.name) for row in rows]
        if column.name == "failure":
            columns[column.name] = tuple(values)
        elif column.name == "half_frequencies_hz":
            pairs = [(None, None) if value is None else value for value in values]
            columns[column.name] = _floats(x for pair in pairs for x in pair).reshape(len(rows), 2)
        elif column.type == "Integers":
            whole = [-1 if value is None else value for value in values]
            columns[column.name] = np.array(whole, dtype=np.int64)
        elif column.type == "Truths":
            columns[column.name] = np.array(values, dtype=np.bool_)
        elif column.type == "Floats":
            columns[column.name] = _floats(values)
        else:
            columns[column.name] = np.array(values, dtype=np.str_)
    return kind(**columns)


@dataclass(frozen=True, eq=False)
class InterfaceMesh(_Comparable):
    """Where the points of an interface lie.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 0})
    >>> interface = microslip.run(scene).interface
    >>> interface.points.shape[0] == interface.weights.size
    True
    """

    nodes: Floats
    """Nodes in the plane of the interface (m), shape ``(nodes, 2)``."""
    node_positions: Floats | None
    """Nodes in the coordinates of the model (m), shape ``(nodes, 3)``; None for matrices without positions."""
    elements: Integers
    """Nodes of each element, from 0, shape ``(elements, most nodes)``; rows of smaller elements end with -1."""
    points: Floats
    """Quadrature points in the plane of the interface (m), shape ``(points, 2)``."""
    point_positions: Floats | None
    """Quadrature points in the coordinates of the model (m), shape ``(points, 3)``."""
    weights: Floats
    """Area of each point (m^2), shape ``(points,)``."""
    element_of_point: Integers
    """Element of each point, from 0, shape ``(points,)``."""
    gap: Floats | None
    """Gap before loading at each point (m), shape ``(points,)``; None where there is none."""
    frame: Floats
    """Unit vectors x, y and normal, from the top body into the bottom one, in the coordinates of the model, shape ``(3, 3)``."""
    node_frames: Floats | None
    """The same at each node of an interface that is not plane, shape ``(nodes, 3, 3)``."""


@dataclass(frozen=True, eq=False)
class Fields(_Comparable):
    """What happens at the quadrature points: under the static load, or at the positive peak of a loop.

    Columns are x, y and normal of the interface. Jumps are motions of the top body less those of the bottom one, tractions act on the
    bottom body.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 0})
    >>> run = microslip.run(scene)
    >>> float(run.interface.weights @ run.prestress.traction[:, 2]) > 30e3  # three bolts (N)
    True
    """

    jump: Floats
    """Jump x, y and interference (m), shape ``(points, 3)``."""
    traction: Floats
    """Traction x, y and pressure (Pa), shape ``(points, 3)``."""
    regime: npt.NDArray[np.uint8]
    """:class:`Regime` of each point, shape ``(points,)``."""
    flux: Floats
    """Energy dissipated per area and cycle (J/m^2), shape ``(points, 3)``; zero for a static state."""
    number: int = 0
    """Number of the amplitude, from 1; 0 for the static state."""
    response_displacement: float = 0.0
    """Amplitude at the response point (m); 0 for the static state."""


@dataclass(frozen=True, eq=False)
class Mode(_Comparable):
    """A mode that was followed.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 1})
    >>> mode = microslip.run(scene).modes[0]
    >>> mode.number, bool(abs(mode.backbone.frequency_hz[0] / mode.linear_frequency_hz - 1.0) < 1e-3)
    (1, True)
    """

    number: int
    """The mode, from 1."""
    linear_frequency_hz: float
    """Frequency about the static state (Hz)."""
    backbone: Backbone
    """Its backbone by CQSMA."""
    methods: dict[str, MethodBackbone]
    """Its backbones by other methods, by the names that scenes use."""
    fields: tuple[Fields, ...]
    """Fields at the amplitudes of which the scene stores them; empty for results that were loaded."""
    validity: dict[str, Any]
    """Limits of the model, as in the summary."""


@dataclass(frozen=True, eq=False)
class ForcedResponse(_Comparable):
    """The response to a harmonic force. Arrays run along the curve, and have shape ``(n,)`` unless stated.

    Examples
    --------
    >>> import microslip
    >>> microslip.ForcedResponse.__dataclass_fields__["level"].type
    'float'
    """

    level: float
    """Amplitude of the force (N)."""
    frequency_hz: Floats
    """Frequency of the force (Hz)."""
    amplitude: Floats
    """Amplitude of the first harmonic of the displacement at the response point (m)."""
    phase: Floats
    """How far it lags behind the force (degrees)."""
    harmonics: Floats
    """Amplitudes of all harmonics from the first on (m), shape ``(n, harmonics)``."""
    mean: Floats
    """Mean displacement from the static state (m)."""
    residual: Floats
    """Residual relative to the elastic forces (energy norm)."""
    turning_points: Integers
    """Indices of the points at which the frequency turns back."""
    peak: tuple[float, float] | None
    """Frequency (Hz) and amplitude (m) of the largest first harmonic."""
    failure: str | None
    """Why the curve ends early, if it does."""


@dataclass(frozen=True, eq=False)
class Ensemble(_Comparable):
    """Bands about a backbone, from realisations of the laws. Columns are the percentiles 5, 50 and 95.

    Examples
    --------
    >>> import microslip
    >>> microslip.Ensemble.__dataclass_fields__["realisations"].type
    'int'
    """

    realisations: int
    """Realisations."""
    failed: int
    """How many of them have no backbone."""
    response_displacement: Floats
    """Displacement amplitude at the response point (m), shape ``(n,)``."""
    frequency_hz: Floats
    """Secant frequency (Hz), shape ``(n, 3)``."""
    frequency_first_harmonic_hz: Floats
    """Frequency of the first harmonic (Hz), shape ``(n, 3)``."""
    damping_ratio: Floats
    """Total damping ratio, shape ``(n, 3)``; NaN among dampings below their floor."""


@dataclass(frozen=True)
class ModelWarning:
    """Something implausible in the scene or the results.

    Examples
    --------
    >>> import microslip
    >>> microslip.ModelWarning("size", "the structure is 30 m long", 30.0, 20.0).limit
    20.0
    """

    kind: str
    """What it is about."""
    message: str
    """In words."""
    value: float
    """What was found."""
    limit: float
    """The limit that it is beyond."""


_COLUMNS = frozenset(column.name for column in fields(Backbone))


class _LikeFirstBackbone:
    """The columns of the backbone of the first mode as attributes."""

    if TYPE_CHECKING:
        status: npt.NDArray[np.str_]
        modal_force: Floats
        modal_amplitude: Floats
        frequency_hz: Floats
        frequency_first_harmonic_hz: Floats
        half_frequencies_hz: Floats
        damping_ratio: Floats
        friction_damping_ratio: Floats
        damping_ratio_first_harmonic: Floats
        damping_floor: Floats
        dissipation: Floats
        loop_area: Floats
        coarse_loop_area: Floats
        response_acceleration: Floats
        response_displacement: Floats
        response_motion: Floats
        slip_fraction: Floats
        open_fraction: Floats
        shape_deviation: Floats
        loop_closure: Floats
        residual: Floats
        load_points: Integers
        iterations: Integers
        evaluations: Integers
        krylov_steps: Integers
        factorisations: Integers
        cycles: Integers
        converged: Truths
        failure: tuple[str | None, ...]

    def __getattr__(self, name: str) -> Any:
        # Only what a run does not have itself comes here; while one is unpickled it has nothing yet.
        if name in _COLUMNS and "modes" in self.__dict__:
            return getattr(self.__dict__["modes"][0].backbone, name)
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *_COLUMNS})


@dataclass(frozen=True, eq=False, repr=False)
class Run(_LikeFirstBackbone, _Comparable):
    """A finished run.

    The columns of the backbone of the first mode are attributes of the run too: ``run.frequency_hz`` is
    ``run.modes[0].backbone.frequency_hz``. Runs are equal if all their numbers are; they can be pickled.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 3})
    >>> run = microslip.run(scene)
    >>> run
    Run('brb-quick', mode 1, 3 amplitudes, 3 converged)
    >>> bool((run.frequency_hz == run.modes[0].backbone.frequency_hz).all())
    True
    """

    scene: Scene
    """The scene."""
    summary: dict[str, Any]
    """What ``summary.json`` holds."""
    modes: tuple[Mode, ...]
    """The modes followed, in the scene's order."""
    linear_frequencies_hz: Floats
    """Frequencies about the static state (Hz)."""
    forced: tuple[ForcedResponse, ...]
    """Responses to harmonic forces, level by level."""
    ensemble: Ensemble | None
    """Bands, if they were asked for."""
    warnings: tuple[ModelWarning, ...]
    """What is implausible in the scene or the results."""
    timings: dict[str, float]
    """Seconds per stage, and in total."""
    _interface: InterfaceMesh | None = field(default=None)
    _prestress: Fields | None = field(default=None)
    _handle: _native.Run | None = field(default=None, compare=False)

    @property
    def backbone(self) -> Backbone:
        """The backbone of the first mode.

        Examples
        --------
        >>> import microslip
        >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 1})
        >>> microslip.run(scene).backbone.status.tolist()
        ['below-floor']
        """
        return self.modes[0].backbone

    @property
    def methods(self) -> dict[str, MethodBackbone]:
        """Backbones of the first mode by methods beside CQSMA, by the names that scenes use.

        Examples
        --------
        >>> import microslip
        >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick")
        >>> list(microslip.run(scene.replace({"analyses.backbone": {"amplitudes": 1, "methods": ["rqnma"]}})).methods)
        ['rqnma']
        """
        return self.modes[0].methods

    @property
    def fields(self) -> tuple[Fields, ...]:
        """Fields of the first mode at the amplitudes of which the scene stores them; empty for results that were loaded.

        Examples
        --------
        >>> import microslip
        >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick")
        >>> run = microslip.run(scene.replace({"analyses.backbone.amplitudes": 2, "output.fields_at": [2]}))
        >>> [fields.number for fields in run.fields]
        [2]
        """
        return self.modes[0].fields

    @property
    def interface(self) -> InterfaceMesh:
        """Where the points of the interface lie.

        Raises
        ------
        InputError
            The run was loaded from a summary, which has no fields.

        Examples
        --------
        >>> import microslip
        >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 0})
        >>> microslip.run(scene).interface.points.shape[1]
        2
        """
        return _there(self._interface)

    @property
    def prestress(self) -> Fields:
        """Fields under the static load; ``summary["prestress"]`` has its numbers.

        Raises
        ------
        InputError
            The run was loaded from a summary, which has no fields.

        Examples
        --------
        >>> import microslip
        >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 0})
        >>> microslip.run(scene).prestress.traction.shape[1]
        3
        """
        return _there(self._prestress)

    def to_pandas(self) -> pandas.DataFrame:
        """The backbones of all modes and methods as a table.

        Returns
        -------
        pandas.DataFrame
            One row per mode, method and amplitude; the columns are those of :class:`Backbone` and :class:`MethodBackbone`.

        Raises
        ------
        ImportError
            pandas is not installed.

        Examples
        --------
        >>> import microslip
        >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 2})
        >>> microslip.run(scene).to_pandas()[["mode", "method", "converged"]]
           mode method  converged
        0     1  cqsma       True
        1     1  cqsma       True
        """
        try:
            import pandas
        except ImportError as error:
            raise ImportError("to_pandas needs pandas; install it by `pip install microslip[pandas]`") from error
        frames = []
        for mode in self.modes:
            tables: dict[str, Backbone | MethodBackbone] = {"cqsma": mode.backbone, **mode.methods}
            for method, table in tables.items():
                columns: dict[str, Any] = {}
                for column in fields(table):
                    values = getattr(table, column.name)
                    if isinstance(values, np.ndarray) and values.ndim == 2:
                        for index, side in enumerate(("positive", "negative")):
                            columns[f"{column.name}_{side}"] = values[:, index]
                    else:
                        columns[column.name] = values
                frame = pandas.DataFrame(columns)
                frame.insert(0, "mode", mode.number)
                frame.insert(1, "method", method)
                frames.append(frame)
        return pandas.concat(frames, ignore_index=True)

    def plot(self, amplitude: str = "response_displacement") -> Figure:
        """Draws frequency and damping against amplitude.

        Parameters
        ----------
        amplitude : {"response_displacement", "response_acceleration", "modal_amplitude"}
            What to draw against. Other methods than CQSMA have no acceleration, and are left out of it.

        Returns
        -------
        matplotlib.figure.Figure
            Frequency above damping, with logarithmic amplitudes and dampings. It is not shown.

        Raises
        ------
        ImportError
            matplotlib is not installed.
        InputError
            There is no such amplitude.

        Examples
        --------
        >>> import microslip
        >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 3})
        >>> figure = microslip.run(scene).plot()
        >>> [axes.get_ylabel() for axes in figure.axes]
        ['frequency (Hz)', 'damping ratio (-)']
        """
        from microslip.plots import backbones

        return backbones(self, amplitude)

    def save(self, directory: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes the files that the program ``microslip run`` writes.

        Parameters
        ----------
        directory : path-like
            Folder, made if missing. Results of the same scene in it are replaced, other files are left alone.
        overwrite : bool
            Whether results of something else, and files that no manifest lists, may be replaced.

        Raises
        ------
        FileError
            The folder holds results of something else, is in use, or cannot be written.
        InputError
            The run was unpickled or loaded.

        Examples
        --------
        >>> import microslip, pathlib, tempfile
        >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 1})
        >>> folder = pathlib.Path(tempfile.mkdtemp()) / "results"
        >>> microslip.run(scene).save(folder)
        >>> (folder / "report.html").exists()
        True
        """
        if self._handle is None:
            remedy = "give `out` to microslip.run, or save before pickling"
            raise InputError(f"a run that was unpickled or loaded has no longer what its files are made of; {remedy}", remedy=remedy)
        self._handle.save(os.fspath(directory), overwrite)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_handle": None}

    def __repr__(self) -> str:
        converged = int(np.count_nonzero(self.backbone.converged))
        amplitudes = self.backbone.converged.size
        modes = ", ".join(str(mode.number) for mode in self.modes)
        return f"Run({self.scene.name!r}, mode {modes}, {amplitudes} amplitudes, {converged} converged)"


_T = TypeVar("_T")


def _there(value: _T | None) -> _T:
    """What only a run that was computed has."""
    if value is None:
        remedy = "run the scene by microslip.run"
        raise InputError(f"a run that was loaded from its summary has no fields; {remedy}", remedy=remedy)
    return value


def run(
    scene: Scene,
    *,
    progress: Callable[[str, float], object] | None = None,
    threads: int | None = None,
    cache: str | os.PathLike[str] | Literal[False] | None = None,
    ensemble: int | None = None,
    out: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
) -> Run:
    """Runs a scene: prestress, modes, and frequency and damping against amplitude.

    Other Python threads go on meanwhile. Ctrl-C stops the run within the stage at hand; what is finished is kept in the cache, and
    the next run of the scene goes on from there.

    Parameters
    ----------
    scene : Scene
        What is modelled.
    progress : callable, optional
        Called in this thread as ``progress(stage, fraction)`` with the name of the stage and what of it is done, from 0 to 1. What
        it raises stops the run, and is raised.
    threads : int, optional
        Threads to compute with, from 1 to 1024; one per processor by default. They change no bit of the results.
    cache : path-like or False, optional
        Folder of reduced models and finished amplitudes; that of the user by default, which the program ``microslip`` has too;
        ``False`` for none.
    ensemble : int, optional
        Also run so many bootstrap realisations of the laws, for bands; the surface must be scanned.
    out : path-like, optional
        Also write the files that the program writes into this folder, see :meth:`Run.save`.
    overwrite : bool
        Whether ``out`` may replace results of something else.

    Returns
    -------
    Run
        Amplitudes that did not converge are NaN in it.

    Raises
    ------
    SceneError
        The scene does not fit the files that it names.
    ConvergenceError
        The prestress did not converge.
    SolverError
        The structure cannot be solved.
    FileError
        A file cannot be read or written.
    InputError
        An argument is out of range.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 3})
    >>> run = microslip.run(scene)
    >>> [round(float(f), 1) for f in run.frequency_hz] == sorted(round(float(f), 1) for f in run.frequency_hz)[::-1]
    True
    """
    if not isinstance(scene, Scene):
        raise InputError(
            f"{type(scene).__name__} is no scene; make one by Scene.from_file or Scene.from_dict",
            field="scene",
            remedy="make one by Scene.from_file or Scene.from_dict",
        )
    if progress is not None and not callable(progress):
        raise InputError("progress cannot be called; give a function of a stage and a fraction", field="progress")
    folder = True if cache is None else False if cache is False else os.fspath(cache)
    native = _native.run(
        scene._handle, progress, threads, folder, ensemble, None if out is None else os.fspath(out), overwrite
    )
    return _of_summary(scene, json.loads(native.summary()), native)


def load(directory: str | os.PathLike[str]) -> Run:
    """Reads results that ``microslip run`` or :func:`run` wrote.

    Parameters
    ----------
    directory : path-like
        Folder with a ``summary.json``, or the file itself.

    Returns
    -------
    Run
        Without fields of the interface, which a summary does not have.

    Raises
    ------
    FileError
        There is no summary, or it cannot be read.
    SceneError
        Its scene is not understood.

    Examples
    --------
    >>> import microslip, pathlib, tempfile
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 1})
    >>> folder = pathlib.Path(tempfile.mkdtemp()) / "results"
    >>> run = microslip.run(scene, out=folder)
    >>> microslip.load(folder).summary == run.summary
    True
    """
    path = Path(directory)
    if path.is_dir():
        path = path / "summary.json"
    remedy = "name a folder that `microslip run` or microslip.run wrote"
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
        source = next((i for i in (summary.get("provenance") or {}).get("inputs", []) if "scene" in i["role"]), None)
        scene = Scene._from_state(json.dumps(summary["scene"]), json.dumps(source))
        return _of_summary(scene, summary, None)
    except OSError as error:
        raise FileError(f"{path}: {error.strerror or error}; {remedy}", path=str(path), remedy=remedy) from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        message = f"{path}: is not the summary of a run ({error}); {remedy}"
        raise FileError(message, path=str(path), remedy=remedy) from error


def _of_summary(scene: Scene, summary: dict[str, Any], native: _native.Run | None) -> Run:
    frequencies = [mode["frequency_hz"] for mode in summary["modes"]]
    first = {key: summary[key] for key in ("backbone", "methods", "validity")}
    number = _first_mode(summary["scene"])
    followed = summary.get("backbones") or [{"mode": number, "frequency_hz": frequencies[number - 1], **first}]
    stored: Sequence[Sequence[tuple[int, _PointFields]]] = [[]] * len(followed) if native is None else native.fields()
    modes = tuple(_mode(of_mode, at) for of_mode, at in zip(followed, stored, strict=True))
    ensemble = summary.get("ensemble")
    return Run(
        scene=scene,
        summary=summary,
        modes=modes,
        linear_frequencies_hz=_floats(frequencies),
        forced=tuple(_forced(level) for level in summary.get("forced") or []),
        ensemble=None if ensemble is None else _ensemble(ensemble),
        warnings=tuple(ModelWarning(**warning) for warning in summary["warnings"]),
        timings=summary["timings"],
        _interface=None if native is None else InterfaceMesh(*native.geometry()),
        _prestress=None if native is None else Fields(*native.prestress()),
        _handle=native,
    )


def _first_mode(scene: _Row) -> int:
    number: int = scene["analyses"]["modes"]["followed"][0]
    return number


def _mode(of_mode: _Row, stored: Sequence[tuple[int, _PointFields]]) -> Mode:
    backbone = _table(Backbone, of_mode["backbone"])
    return Mode(
        number=of_mode["mode"],
        linear_frequency_hz=of_mode["frequency_hz"],
        backbone=backbone,
        methods={name: _table(MethodBackbone, rows) for name, rows in of_mode["methods"].items()},
        fields=tuple(
            Fields(*arrays, number=number, response_displacement=float(backbone.response_displacement[number - 1]))
            for number, arrays in stored
        ),
        validity=of_mode["validity"],
    )


def _forced(level: _Row) -> ForcedResponse:
    points = len(level["frequency"])
    return ForcedResponse(
        level=level["level"],
        frequency_hz=_floats(level["frequency"]),
        amplitude=_floats(level["amplitude"]),
        phase=_floats(level["phase"]),
        harmonics=np.array(level["harmonics"], dtype=np.float64).reshape(points, -1 if points else 0),
        mean=_floats(level["mean"]),
        residual=_floats(level["residual"]),
        turning_points=np.array(level["turning_points"], dtype=np.int64),
        peak=None if level["peak"] is None else tuple(level["peak"]),
        failure=level["failure"],
    )


def _ensemble(of: _Row) -> Ensemble:
    bands = of["bands"]

    def columns(name: str) -> Floats:
        return _floats(x for band in bands for x in band[name]).reshape(len(bands), 3)

    return Ensemble(
        realisations=of["realisations"],
        failed=of["failed"],
        response_displacement=_floats(band["response_displacement"] for band in bands),
        frequency_hz=columns("frequency_hz"),
        frequency_first_harmonic_hz=columns("frequency_first_harmonic_hz"),
        damping_ratio=columns("damping_ratio"),
    )
