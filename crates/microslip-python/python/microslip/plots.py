"""Pictures of results, by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from microslip.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from microslip.results import Backbone, MethodBackbone, Run

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
