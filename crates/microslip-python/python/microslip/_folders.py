"""Pictures of what folders of the program hold and no type has: mode shapes, and settings with their errors and times."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
import numpy.typing as npt

from microslip.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_Floats = npt.NDArray[np.float64]
_Numbers = npt.NDArray[np.int64]

_HEXAHEDRON = ((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7))
_TETRAHEDRON = ((0, 1, 3), (1, 2, 3), (2, 0, 3), (0, 2, 1))
_WEDGE = ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0))
#: Corners of the faces of cells, by the numbers that VTK has for their types.
_FACES = {10: _TETRAHEDRON, 24: _TETRAHEDRON, 12: _HEXAHEDRON, 25: _HEXAHEDRON, 29: _HEXAHEDRON, 13: _WEDGE, 26: _WEDGE}
_TYPES = {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1", "UInt16": "<u2", "Int32": "<i4", "UInt32": "<u4", "UInt64": "<u8"}

#: Part of the model's size by which shapes are drawn deformed, and angles from which they are seen (degrees).
_DEFORMED = 0.12
_SEEN_FROM = (-35.0, 25.0)


def _refused(path: Path, reason: str, remedy: str) -> InputError:
    return InputError(f"{path}: {reason}; {remedy}", field="runs", value=str(path), remedy=remedy)


def _json(path: Path, remedy: str) -> dict[str, Any]:
    try:
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise _refused(path, f"it cannot be read ({error})", remedy) from error
    return found


def _arrays(path: Path, remedy: str) -> dict[str, npt.NDArray[Any]]:
    """The arrays of a VTK file by their names, as the program writes it; those of vectors with three columns."""
    found: dict[str, npt.NDArray[Any]] = {}
    try:
        for array in ElementTree.parse(path).iter("DataArray"):
            raw = base64.b64decode(array.text or "")
            values = np.frombuffer(raw[8:], dtype=_TYPES[array.attrib["type"]])
            columns = int(array.get("NumberOfComponents", "1"))
            # The name of the positions is empty in some files.
            found[array.get("Name", "Points")] = values.reshape(-1, columns) if columns > 1 else values
    except (OSError, ElementTree.ParseError, KeyError, ValueError) as error:
        raise _refused(path, f"it cannot be read ({error})", remedy) from error
    return found


def _outer_faces(arrays: dict[str, npt.NDArray[Any]], path: Path) -> list[_Numbers]:
    """Faces of one cell only, by their number of corners."""
    ends, kinds, nodes = arrays["offsets"], arrays["types"], arrays["connectivity"]
    unknown = sorted(set(np.unique(kinds).tolist()) - set(_FACES))
    if unknown:
        raise _refused(path, f"it has cells of the VTK types {unknown}, whose faces are not known here", "draw it by the program")
    all_faces: dict[int, list[_Numbers]] = {3: [], 4: []}
    for kind, faces in _FACES.items():
        first = np.concatenate([[0], ends[:-1]])[kinds == kind].astype(np.int64)
        for corners in faces:
            all_faces[len(corners)].append(nodes[first[:, None] + np.array(corners)].astype(np.int64))
    outer = []
    for groups in all_faces.values():
        together = np.concatenate(groups)
        if len(together) > 0:
            _, first, counts = np.unique(np.sort(together, axis=1), axis=0, return_index=True, return_counts=True)
            outer.append(together[first[counts == 1]])
    return outer


def modes(folder: Path, width: float) -> Figure:
    """The shapes of a folder of ``microslip model SCENE --modes N --out DIR``; the width is in inches."""
    from microslip._figure import picture

    from matplotlib.collections import PolyCollection  # isort: skip

    remedy = "microslip model SCENE --modes 6 --out DIR writes mode shapes"
    model = _json(folder / "summary.json", remedy).get("modes")
    if not isinstance(model, dict) or not model.get("contacts"):
        raise _refused(folder / "summary.json", "there are no mode shapes", remedy)
    # The last contact is the nearest to what a run linearises.
    contact = model["contacts"][-1]
    arrays = _arrays(folder / "modes.vtu", remedy)
    axes = np.array(model["axes"])
    nodes: _Floats = arrays["Points"] @ axes.T
    around, above = np.radians(_SEEN_FROM)
    turned = np.array([[np.cos(around), -np.sin(around), 0.0], [np.sin(around), np.cos(around), 0.0], [0.0, 0.0, 1.0]])
    tilted = np.array([[1.0, 0.0, 0.0], [0.0, np.sin(above), np.cos(above)], [0.0, -np.cos(above), np.sin(above)]])
    view = tilted @ turned
    faces = _outer_faces(arrays, folder / "modes.vtu")
    shapes = contact["modes"]
    columns = min(2, len(shapes))
    rows = -(-len(shapes) // columns)
    figure = picture(width, max(0.45 * width * rows, 1.2))
    for place, mode in zip(figure.subplots(rows, columns, squeeze=False).flat, shapes, strict=False):
        displacement: _Floats = arrays[f"{contact['contact']} {mode['number']:02} [1/sqrt(kg)]"] @ axes.T
        size = np.linalg.norm(displacement, axis=1)
        scale = _DEFORMED * float(np.max(np.ptp(nodes, axis=0))) / max(float(size.max()), np.finfo(float).tiny)
        seen = (nodes + scale * displacement) @ view.T
        polygons = [seen[face] for group in faces for face in group]
        colours = np.array([size[face].mean() for group in faces for face in group])
        order = np.argsort([polygon[:, 2].mean() for polygon in polygons])
        cells = PolyCollection([polygons[i][:, :2] for i in order], array=colours[order], cmap="viridis", edgecolor="face", linewidth=0.1)
        place.add_collection(cells)
        place.autoscale_view()
        place.set_aspect("equal")
        place.set_title(f"{mode['number']}. {mode['frequency_hz']:.1f} Hz", fontsize="medium")
    for place in figure.axes:
        place.set_axis_off()
    return figure


def trade(path: Path, width: float) -> Figure:
    """Errors of settings against their times, from ``trade.json`` or its folder; the width is in inches."""
    from microslip._figure import picture

    file = path / "trade.json" if path.is_dir() else path
    rungs = _json(file, "cargo xtask trade SCENE writes it").get("rungs", [])
    dials: dict[str, list[tuple[float, float, float]]] = {}
    for rung in rungs:
        errors, seconds = rung.get("errors"), rung.get("seconds")
        if errors is None or seconds is None:
            continue
        linear = errors["linear_frequency"]
        frequency = max([abs(linear), *(abs(linear + shift) for shift in errors["frequency_shift"] if shift is not None)])
        damping = max((abs(error) for error in errors["damping_ln"] if error is not None), default=np.nan)
        dials.setdefault(rung["dial"], []).append((seconds, frequency, damping))
    if not dials:
        raise _refused(file, "no setting of it was measured", "cargo xtask trade SCENE writes it")
    figure = picture(width, 1.06 * width)
    above, below = figure.subplots(2, 1, sharex=True)
    for name, settings in dials.items():
        seconds, frequency, damping = np.array(settings).T
        for axes, values in ((above, frequency), (below, damping)):
            axes.plot(seconds, np.where(values > 0.0, values, np.nan), marker="o", markersize=3, linewidth=1.0, label=name)
    for axes, name in ((above, "error of frequency"), (below, "error of ln(damping)")):
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_ylabel(name)
        axes.grid(visible=True, which="major", linewidth=0.5)
    below.set_xlabel("time (s)")
    above.legend(frameon=False)
    return figure
