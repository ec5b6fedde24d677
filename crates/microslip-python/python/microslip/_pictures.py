"""Pictures of faces, ring-downs and comparisons, by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from microslip.records import Comparison, Identification
    from microslip.results import InterfaceMesh
    from microslip.surfaces import PlaneMesh

_Floats = npt.NDArray[np.float64]

_UNITS = {"acceleration": "m/s$^2$", "velocity": "m/s", "displacement": "m"}
_MARKERS = "osD^v<>"


def _backbone_axes(quantity: str) -> tuple[Figure, Axes, Axes]:
    """Frequency above damping, against amplitude."""
    from microslip._figure import picture

    figure = picture(6.4, 6.4)
    above, below = figure.subplots(2, 1, sharex=True)
    above.set_xscale("log")
    above.set_ylabel("frequency (Hz)")
    below.set_ylabel("damping ratio (-)")
    below.set_xlabel(f"{quantity} amplitude ({_UNITS[quantity]})")
    for axes in (above, below):
        axes.grid(visible=True, which="major", linewidth=0.5)
        axes.grid(visible=True, which="minor", linewidth=0.25, alpha=0.5)
    return figure, above, below


def identification(found: Identification) -> Figure:
    """Each hit, the mean, and its spread, see :meth:`microslip.Identification.plot`."""
    figure, above, below = _backbone_axes(found.quantity)
    several = len(found.hits) > 1
    curves = (
        (above, "frequency_hz", found.frequency_hz, found.frequency_spread_hz),
        (below, "damping_ratio", found.damping_ratio, found.damping_ratio_spread),
    )
    for axes, column, mean, spread in curves:
        for number, hit in enumerate(found.hits if several else ()):
            axes.plot(hit.amplitude, getattr(hit, column), color="0.6", linewidth=0.8, label="hits" if number == 0 else None)
        axes.plot(found.amplitude, mean, linewidth=1.4, label="mean")
        if several:
            axes.fill_between(found.amplitude, mean - spread, mean + spread, alpha=0.25, label="standard deviation")
    if several:
        above.legend(frameon=False)
    _at_least(above, 1e-3)
    below.set_ylim(bottom=min(0.0, float(np.nanmin(found.damping_ratio))))
    return figure


def _at_least(axes: Axes, part: float) -> None:
    """Widens the range of y to this part of its values, so that rounding does not fill the picture."""
    low, high = axes.get_ylim()
    middle, half = 0.5 * (low + high), 0.5 * max(high - low, part * max(abs(low), abs(high)))
    axes.set_ylim(middle - half, middle + half)
    axes.ticklabel_format(axis="y", useOffset=False)


def comparison(of: Comparison) -> Figure:
    """Theory and experiments, see :meth:`microslip.Comparison.plot`."""
    figure, above, below = _backbone_axes(of.quantity)
    below.set_yscale("log")
    curves: list[tuple[str, _Floats]] = [(of.name, of.theory), *((misfit.name, misfit.experiment) for misfit in of.misfits)]
    for number, (name, table) in enumerate(curves):
        # A backbone of a few amplitudes shows them; a measured one has hundreds.
        marker = _MARKERS[number % len(_MARKERS)] if len(table) <= 40 else ""
        line = f"{marker}-" if number == 0 else f"{marker}--"
        above.plot(table[:, 0], table[:, 1], line, linewidth=1.2, markersize=4, label=name)
        below.plot(table[:, 0], np.where(table[:, 2] > 0.0, table[:, 2], np.nan), line, linewidth=1.2, markersize=4)
    above.legend(frameon=False)
    _at_least(above, 1e-3)
    return figure


def interface_map(mesh: PlaneMesh | InterfaceMesh, values: _Floats, label: str, width: float = 6.4) -> Figure:
    """Values of elements in the plane of the interface, see :meth:`microslip.Characterisation.plot`; the width is in inches."""
    # First the one that says what is missing.
    from microslip._figure import picture

    from matplotlib.collections import PolyCollection  # isort: skip

    extent = np.ptp(mesh.nodes, axis=0)
    upright = bool(extent[1] > extent[0])
    ratio = float(min(extent) / max(extent))
    figure = picture(0.625 * width, width) if upright else picture(width, max(2.0, 0.8125 * width * ratio + 1.0))
    axes = figure.subplots()
    nodes = 1e3 * mesh.nodes
    # Elements have 3 or 6 nodes, or 4, 8 or 9; the corners come first.
    corners = [3 if np.count_nonzero(element >= 0) in (3, 6) else 4 for element in mesh.elements]
    polygons = [nodes[element[:n]] for element, n in zip(mesh.elements, corners, strict=True)]
    cells = PolyCollection(polygons, array=values, cmap="viridis", edgecolor="face", linewidth=0.2)
    axes.add_collection(cells)
    axes.autoscale_view()
    axes.margins(0.0)
    axes.set_aspect("equal")
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")
    figure.colorbar(cells, ax=axes, location="right" if upright else "bottom", label=label, shrink=0.9)
    return figure
