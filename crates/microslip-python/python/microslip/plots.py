"""Pictures of results, by matplotlib."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from microslip.errors import InputError
from microslip.results import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from microslip.results import Backbone, MethodBackbone

__all__ = ["plot"]

_AMPLITUDES = {
    "response_displacement": "displacement amplitude (m)",
    "response_acceleration": "acceleration amplitude (m/s$^2$)",
    "modal_amplitude": "modal amplitude (kg$^{1/2}$ m)",
}
_NAMES = {"masing": "Masing"}
_MARKERS = {"cqsma": "o", "epmc": "s", "masing": "^", "rqnma": "v", "qsma": "D"}


def backbones(run: Run, amplitude: str) -> Figure:
    """Frequency above damping against amplitude, see :meth:`microslip.Run.plot`."""
    if amplitude not in _AMPLITUDES:
        remedy = f"it must be one of {', '.join(_AMPLITUDES)}"
        raise InputError(f"there is no amplitude {amplitude!r}; {remedy}", field="amplitude", value=amplitude, remedy=remedy)
    from microslip._figure import picture

    figure = picture(6.4, 6.4)
    above, below = figure.subplots(2, 1, sharex=True)
    for mode in run.modes:
        tables: dict[str, Backbone | MethodBackbone] = {"cqsma": mode.backbone, **mode.methods}
        for method, table in tables.items():
            at = getattr(table, amplitude, None)
            if at is None or not np.isfinite(at).any():
                continue
            name = _NAMES.get(method, method.upper())
            label = f"mode {mode.number}, {name}" if len(run.modes) > 1 else name
            # Zero has no place on a logarithmic axis.
            damping = np.where(table.damping_ratio > 0.0, table.damping_ratio, np.nan)
            style = {"marker": _MARKERS.get(method, "."), "markersize": 4, "linewidth": 1.2, "label": label}
            above.plot(at, table.frequency_hz, **style)
            below.plot(at, damping, **style)
    above.set_xscale("log")
    below.set_yscale("log")
    above.set_ylabel("frequency (Hz)")
    below.set_ylabel("damping ratio (-)")
    below.set_xlabel(_AMPLITUDES[amplitude])
    above.set_title(run.scene.name)
    for axes in (above, below):
        axes.grid(visible=True, which="major", linewidth=0.5)
        axes.grid(visible=True, which="minor", linewidth=0.25, alpha=0.5)
    if len(above.lines) > 1:
        above.legend(frameon=False)
    return figure


_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#8c8c8c")
_DASHES = ("-", "--", ":", "-.")
_KINDS = ("backbone", "flux", "bands", "modes", "trade")


def plot(runs: Run | Sequence[Run] | str | os.PathLike[str], kind: str = "backbone") -> Figure:
    """Draws runs for a paper, by the names of the program ``microslip plot``: 85 mm wide, texts of 8 pt.

    Parameters
    ----------
    runs : Run, sequence of Run, or path
        What is drawn. Maps are of one run; mode shapes and errors against time are of a folder that the program has written.
    kind : {"backbone", "flux", "bands", "modes", "trade"}
        Frequency and damping of the first mode followed against amplitude; dissipation over the interface at the largest amplitude whose fields
        are stored; bands, from uncertain inputs or else of an ensemble; mode shapes, from the folder of ``microslip model SCENE --modes N``;
        or errors of settings against time, from that of ``cargo xtask trade SCENE``.

    Returns
    -------
    matplotlib.figure.Figure
        It is not shown.

    Raises
    ------
    ImportError
        matplotlib is not installed.
    InputError
        There is no such kind, or a run or a folder has not what it shows.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 3})
    >>> figure = microslip.plot(microslip.run(scene), kind="backbone")
    >>> round(25.4 * figure.get_figwidth())
    85
    """
    if kind not in _KINDS:
        remedy = f"it must be one of {', '.join(_KINDS)}"
        raise InputError(f"there is no kind {kind!r} of picture here; {remedy}", field="kind", value=kind, remedy=remedy)
    of_folder = kind in ("modes", "trade")
    if of_folder != isinstance(runs, (str, os.PathLike)):
        remedy = "give the path of a folder" if of_folder else "give a Run; microslip.load(DIR) reads one"
        raise InputError(f"kind {kind!r} does not show what was given; {remedy}", field="runs", value=str(runs), remedy=remedy)
    folder = Path(runs) if isinstance(runs, (str, os.PathLike)) else None
    all_runs = [runs] if isinstance(runs, Run) else [] if isinstance(runs, (str, os.PathLike)) else list(runs)
    if folder is None and not all_runs:
        raise InputError("there is no run to draw; give one at least", field="runs", value=0, remedy="give one at least")
    from microslip._figure import picture

    from matplotlib import rc_context  # isort: skip
    from matplotlib.ticker import EngFormatter, PercentFormatter  # isort: skip

    with rc_context({"font.size": 8.0}):
        if folder is not None:
            from microslip import _folders

            return (_folders.modes if kind == "modes" else _folders.trade)(folder, 85.0 / 25.4)
        if kind == "flux":
            return _flux(all_runs)
        figure = picture(85.0 / 25.4, 90.0 / 25.4)
        above, below = figure.subplots(2, 1, sharex=True)
        for number, run in enumerate(all_runs):
            style = {"color": _COLOURS[number % len(_COLOURS)], "linestyle": _DASHES[number % len(_DASHES)], "linewidth": 1.0}
            if kind == "backbone":
                table = run.modes[0].backbone
                damping = np.where(table.damping_ratio > 0.0, table.damping_ratio, np.nan)
                above.plot(table.response_displacement, table.frequency_first_harmonic_hz, marker="o", markersize=3, **style)
                below.plot(table.response_displacement, damping, marker="o", markersize=3, label=run.scene.name, **style)
                continue
            at, frequency, ratio = _bands(run)
            for axes, edges in ((above, frequency), (below, np.where(ratio > 0.0, ratio, np.nan))):
                axes.fill_between(at, edges[:, 0], edges[:, 2], color=style["color"], alpha=0.2, linewidth=0.0)
                axes.plot(at, edges[:, 1], label=run.scene.name, **style)
        above.set_xscale("log")
        below.set_yscale("log")
        above.set_ylabel("frequency (Hz)" if kind == "backbone" else "frequency, secant (Hz)")
        below.set_ylabel("damping ratio")
        below.set_xlabel("displacement amplitude at the response point")
        # Numbers with the unit that suits each, as the program writes them.
        below.xaxis.set_major_formatter(EngFormatter(unit="m"))
        below.yaxis.set_major_formatter(PercentFormatter(xmax=1.0))
        for axes in (above, below):
            axes.grid(visible=True, which="major", linewidth=0.5)
        if len(all_runs) > 1:
            below.legend(frameon=False)
    return figure


def _bands(run: Run) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Amplitudes, and lower edge, median and upper edge of frequency and of damping ratio."""
    uncertain = (run.summary.get("uncertainty") or {}).get("modes") or []
    rows = [band for band in (uncertain[0]["bands"] if uncertain else []) if band["modal_amplitude"] > 0.0]
    if rows:
        edges = [np.array([row[name]["quantiles"] for row in rows], dtype=np.float64) for name in ("frequency_hz", "damping_ratio")]
        return np.array([row["response_displacement"] for row in rows]), edges[0], edges[1]
    if run.ensemble is not None:
        return run.ensemble.response_displacement, run.ensemble.frequency_hz, run.ensemble.damping_ratio
    remedy = "the program makes them: microslip run SCENE --samples 100, or an ensemble"
    raise InputError(f"the run of {run.scene.name} has no bands; {remedy}", field="runs", value=run.scene.name, remedy=remedy)


def _flux(runs: list[Run]) -> Figure:
    """Dissipation at the largest amplitude whose fields are stored."""
    from microslip._pictures import interface_map

    if len(runs) != 1:
        remedy = "give one, or use the program: microslip plot DIR DIR --kind flux"
        raise InputError(f"a map shows one run, and there are {len(runs)}; {remedy}", field="runs", value=len(runs), remedy=remedy)
    (run,) = runs
    if not run.fields:
        remedy = "name the amplitude in output.fields_at of the scene, and take the run itself, not what was loaded"
        raise InputError(f"the run has no fields of any amplitude; {remedy}", field="runs", value=run.scene.name, remedy=remedy)
    mesh, flux = run.interface, run.fields[-1].flux.sum(axis=1)
    if mesh.elements.shape[1] < 3:
        remedy = "there is nothing to map; take kind='backbone'"
        raise InputError(f"the interface is of points of contact, which have no area; {remedy}", field="kind", value="flux", remedy=remedy)
    count = len(mesh.elements)
    areas = np.bincount(mesh.element_of_point, weights=mesh.weights, minlength=count)
    values = np.bincount(mesh.element_of_point, weights=mesh.weights * flux, minlength=count) / areas
    return interface_map(mesh, values, "dissipated energy per area and cycle (J/m$^2$)", width=85.0 / 25.4)
