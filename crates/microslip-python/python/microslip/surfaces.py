"""Scans of faces, and the asperities, gaps and traction curves that follow from two of them."""

from __future__ import annotations

import json
import operator
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from microslip import _native
from microslip._arguments import count as _count
from microslip._arguments import seed as _seed
from microslip._described import values
from microslip.errors import InputError
from microslip.results import _Comparable

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

__all__ = [
    "Characterisation",
    "FaceStatistics",
    "HeightMap",
    "PlaneMesh",
    "characterise",
    "press",
    "read_scan",
    "rectangular_mesh",
    "synthetic_face",
    "write_scan",
]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_Pair = tuple[float, float]
_NativeMap = tuple[Floats, _Pair, _Pair, float | None]


@dataclass(frozen=True, eq=False)
class HeightMap(_Comparable):
    """A face: heights over a regular grid in the plane of the interface.

    The point of row ``j`` and column ``i`` lies at ``origin + (i * step[0], j * step[1])``, x along the rows. Heights point out of
    the body, towards its mate.

    Raises
    ------
    InputError
        The heights are not a table of at least 3 by 3 numbers.

    Examples
    --------
    >>> import numpy as np
    >>> import microslip
    >>> face = microslip.HeightMap(np.zeros((40, 60)), step=(10e-6, 10e-6))
    >>> face.heights.shape, face.origin
    ((40, 60), (0.0, 0.0))
    """

    heights: Floats
    """Heights (m), NaN where there is no data, shape ``(ny, nx)``."""
    step: tuple[float, float]
    """Distances of neighbours along x and y (m)."""
    origin: tuple[float, float] = (0.0, 0.0)
    """Position of the first point of the first row (m)."""
    height_step: float | None = None
    """Height resolution of the instrument (m), if it is known: what differs by less than half of it counts as level."""
    source: Mapping[str, Any] | None = None
    """What the file says: ``format``, ``lateral_unit``, ``height_unit``, ``smallest_step`` (m), ``distinct_heights`` and ``notes``."""

    def __post_init__(self) -> None:
        heights = np.array(_floats("heights", self.heights))
        if heights.ndim != 2 or min(heights.shape) < 3:
            remedy = "give rows of at least 3 by 3 heights"
            raise InputError(f"heights have the shape {heights.shape}; {remedy}", field="heights", remedy=remedy)
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "step", _pair("step", self.step))
        object.__setattr__(self, "origin", _pair("origin", self.origin))
        super().__post_init__()

    def _native(self) -> _NativeMap:
        return self.heights, self.step, self.origin, self.height_step


class _Mesh(Protocol):
    @property
    def nodes(self) -> Floats: ...

    @property
    def elements(self) -> Integers: ...


@dataclass(frozen=True, eq=False)
class PlaneMesh(_Comparable):
    """Elements in the plane of an interface. :class:`microslip.Interface` serves as well.

    Examples
    --------
    >>> import microslip
    >>> mesh = microslip.rectangular_mesh((0.02, 0.01), (4, 2))
    >>> mesh.nodes.shape, mesh.elements.shape
    ((15, 2), (8, 4))
    """

    nodes: Floats
    """Positions of the nodes (m), shape ``(nodes, 2)``."""
    elements: Integers
    """Nodes of each element from 0, the corners counter-clockwise, then the middles of the edges, then the centre; rows of smaller
    elements end with -1. Shape ``(elements, most nodes)``."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", np.array(_floats("nodes", self.nodes)))
        object.__setattr__(self, "elements", np.array(self.elements, dtype=np.int64))
        super().__post_init__()


def rectangular_mesh(size: tuple[float, float], divisions: tuple[int, int], origin: tuple[float, float] = (0.0, 0.0)) -> PlaneMesh:
    """A rectangle of equal quadrilaterals.

    Parameters
    ----------
    size : (float, float)
        Lengths along x and y (m).
    divisions : (int, int)
        Elements along x and y. They are numbered along x first.
    origin : (float, float)
        Lower left corner (m).

    Raises
    ------
    InputError
        There is no element.

    Examples
    --------
    >>> import microslip
    >>> microslip.rectangular_mesh((0.02, 0.01), (2, 1)).elements.tolist()
    [[0, 1, 4, 3], [1, 2, 5, 4]]
    """
    try:
        nx, ny = (operator.index(n) for n in divisions)
    except (TypeError, ValueError):
        nx = ny = 0
    if min(nx, ny) < 1:
        remedy = "it must have at least one element along x and along y"
        raise InputError(f"divisions = {divisions!r}; {remedy}", field="divisions", remedy=remedy)
    x, y = (origin[k] + size[k] * np.arange(n + 1) / n for k, n in enumerate((nx, ny)))
    nodes = np.column_stack([np.tile(x, ny + 1), np.repeat(y, nx + 1)])
    first = (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    return PlaneMesh(nodes, np.column_stack([first, first + 1, first + nx + 2, first + nx + 1]))


@dataclass(frozen=True, eq=False)
class FaceStatistics(_Comparable):
    """What one face shows over each element, above the element's bilinear form; areal parameters as ISO 25178-2 names them.

    Arrays have shape ``(elements,)`` unless stated. What a face does not have is NaN.

    Examples
    --------
    >>> import microslip
    >>> faces = [microslip.synthetic_face((120, 80), (20e-6, 20e-6), rms=1e-6, correlation_length=80e-6, seed=k) for k in (1, 2)]
    >>> found = microslip.characterise(*faces, (2, 1), material=(192.85e9, 0.29))
    >>> bool((abs(found.top.sq / 1e-6 - 1.0) < 0.2).all())
    True
    """

    points: Floats
    """Points with data."""
    missing: Floats
    """Points without data."""
    sa: Floats
    """Arithmetic mean of the absolute heights (m)."""
    sq: Floats
    """Root mean square height (m)."""
    sz: Floats
    """Maximum height (m), the total roughness."""
    ssk: Floats
    """Skewness."""
    sku: Floats
    """Kurtosis, 3 for Gaussian heights."""
    sdq: Floats
    """Root mean square gradient."""
    spd: Floats
    """Density of the peaks of significant hills (1/m^2)."""
    spc: Floats
    """Mean curvature of those peaks (1/m)."""
    summits: Floats
    """Points above all of their 8 neighbours."""
    count: Floats
    """Number of asperities."""
    peaks: Floats
    """Peaks of the lines along x and along y, shape ``(elements, 2)``."""
    radius: Floats
    """Radius of these peaks along x and along y (m), shape ``(elements, 2)``."""


#: What is drawn: label and size of its unit.
_QUANTITIES = {
    "gap": ("gap (\u00b5m)", 1e-6),
    "total_roughness": ("total roughness (\u00b5m)", 1e-6),
    "count": ("asperities (-)", 1.0),
    "density": ("asperities per area (1/mm$^2$)", 1e6),
    "effective_radius": ("effective radius (\u00b5m)", 1e-6),
}


@dataclass(frozen=True, eq=False)
class Characterisation(_Comparable):
    """Two faces over the elements of their interface: gap, asperities and traction curves.

    Arrays have shape ``(elements,)`` unless stated.

    Examples
    --------
    >>> import microslip
    >>> faces = [microslip.synthetic_face((120, 80), (20e-6, 20e-6), rms=1e-6, correlation_length=80e-6, seed=k) for k in (1, 2)]
    >>> found = microslip.characterise(*faces, (2, 1), material=(192.85e9, 0.29))
    >>> found.gap.shape, found.normal_traction.shape, len(found.heights)
    ((2,), (2, 64), 2)
    """

    mesh: PlaneMesh
    """The elements."""
    area: Floats
    """Area of each element (m^2)."""
    gap: Floats
    """Gap at the middle of each element (m), zero where its tallest peaks would touch."""
    gap_range: Floats
    """Least and greatest gap at the corners (m), shape ``(elements, 2)``."""
    gap_coefficients: Floats
    """Gap as factors of 1, xi, eta and xi eta (m), shape ``(elements, 4)``, with ``xi = (x - gap_centre[0]) / gap_half_width[0]``."""
    gap_centre: Floats
    """Middle of the rectangle around each element (m), shape ``(elements, 2)``."""
    gap_half_width: Floats
    """Half edges of that rectangle (m), shape ``(elements, 2)``."""
    total_roughness: Floats
    """Total roughness of the pair, the mean of both faces' (m)."""
    count: Floats
    """Number of asperities of the pair, an estimate that need not be whole."""
    density: Floats
    """Asperities per area (1/m^2)."""
    radius: Floats
    """Radii of the pair along x and y (m), shape ``(elements, 2)``."""
    effective_radius: Floats
    """Radius of the Hertzian contacts (m)."""
    contact_height: Floats
    """Height at which the interference is zero, that of the tallest peak (m)."""
    heights: tuple[Floats, ...]
    """Heights of the peaks of each element (m), the tallest first."""
    top: FaceStatistics
    """The top face."""
    bottom: FaceStatistics
    """The bottom face."""
    interference: Floats
    """Interferences of the curves (m), shape ``(samples,)``."""
    normal_traction: Floats
    """Normal traction (Pa), shape ``(elements, samples)``."""
    tangential_stiffness: Floats
    """Tangential stiffness per area along x and y (Pa/m), shape ``(elements, 2, samples)``."""
    normal_band: Floats | None
    """Lower and upper end of the 95 % band of the normal traction (Pa), shape ``(elements, 2, samples)``; None without bootstrap."""
    normal_fit: Floats
    """Parameters a, b, c, d, e of the fit to the normal traction, eq. (28) of the method paper, shape ``(elements, 5)``; tractions are
    in Pa and interferences in ``options["u_ref"]``."""
    normal_fit_rms: Floats
    """Root mean square residual of its logarithm."""
    tangential_fit: Floats
    """Parameters a, b, c, d of the fits to the tangential stiffness, eq. (29), shape ``(elements, 2, 4)``."""
    tangential_fit_rms: Floats
    """Root mean square residuals of their logarithms, shape ``(elements, 2)``."""
    fallbacks: tuple[tuple[str | None, str | None, str | None], ...]
    """For the three fits of each element the simpler form that was taken, if one was: ``"power-law"``, ``"constant"`` or
    ``"single-asperity"``."""
    summary: Mapping[str, Any]
    """Counts and medians over the elements."""
    faces: tuple[Mapping[str, Any], Mapping[str, Any]]
    """The whole top and bottom face: plane that was taken off, points, outliers, areal parameters."""
    alignments: tuple[Mapping[str, Any] | None, Mapping[str, Any] | None]
    """How the faces were moved onto the interface, if that was asked for."""
    options: Mapping[str, Any]
    """All settings and readings."""

    def to_pandas(self) -> pandas.DataFrame:
        """The elements as a table.

        Returns
        -------
        pandas.DataFrame
            One row per element; the areal parameters have the name of their face in front.

        Raises
        ------
        ImportError
            pandas is not installed.

        Examples
        --------
        >>> import microslip
        >>> faces = [microslip.synthetic_face((120, 80), (20e-6, 20e-6), rms=1e-6, correlation_length=80e-6, seed=k) for k in (1, 2)]
        >>> table = microslip.characterise(*faces, (2, 1), material=(192.85e9, 0.29)).to_pandas()
        >>> len(table), "radius_x" in table, "top_sq" in table
        (2, True, True)
        """
        try:
            import pandas
        except ImportError as error:
            raise ImportError("to_pandas needs pandas; install it by `pip install microslip[pandas]`") from error
        columns: dict[str, Any] = {}
        for name in ("area", "gap", "total_roughness", "count", "density", "effective_radius", "normal_fit_rms"):
            columns[name] = getattr(self, name)
        for axis, name in enumerate("xy"):
            columns[f"radius_{name}"] = self.radius[:, axis]
        for name, face in (("top", self.top), ("bottom", self.bottom)):
            for column in fields(face):
                values = getattr(face, column.name)
                if values.ndim == 1:
                    columns[f"{name}_{column.name}"] = values
        return pandas.DataFrame(columns)

    def plot(self, quantity: str = "gap") -> Figure:
        """Draws a quantity over the interface.

        Parameters
        ----------
        quantity : {"gap", "total_roughness", "count", "density", "effective_radius"}
            What to draw.

        Returns
        -------
        matplotlib.figure.Figure
            It is not shown.

        Raises
        ------
        ImportError
            matplotlib is not installed.
        InputError
            There is no such quantity.

        Examples
        --------
        >>> import microslip
        >>> faces = [microslip.synthetic_face((120, 80), (20e-6, 20e-6), rms=1e-6, correlation_length=80e-6, seed=k) for k in (1, 2)]
        >>> figure = microslip.characterise(*faces, (2, 1), material=(192.85e9, 0.29)).plot("density")
        >>> figure.axes[1].get_xlabel()
        'asperities per area (1/mm$^2$)'
        """
        if quantity not in _QUANTITIES:
            remedy = f"it must be one of {', '.join(_QUANTITIES)}"
            raise InputError(f"there is no quantity {quantity!r}; {remedy}", field="quantity", value=quantity, remedy=remedy)
        from microslip._pictures import interface_map

        label, unit = _QUANTITIES[quantity]
        return interface_map(self.mesh, getattr(self, quantity) / unit, label)


def _floats(name: str, values: Any) -> Floats:
    """An argument as contiguous array of numbers."""
    try:
        return np.asarray(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} cannot be read as numbers: {error}", field=name) from None


def _pair(name: str, values: Any) -> tuple[float, float]:
    """Two numbers along x and y; one alone serves for both."""
    found = _floats(name, values)
    return _two(name, np.full(2, found) if found.shape == () else found, "give two numbers, along x and y")


def _two(name: str, values: Any, remedy: str) -> tuple[float, float]:
    found = _floats(name, values)
    if found.shape != (2,):
        raise InputError(f"{name} has the shape {found.shape}; {remedy}", field=name, remedy=remedy)
    first, second = found.tolist()
    return first, second


def read_scan(
    path: str | os.PathLike[str],
    *,
    format: Literal["x3p", "sdf", "sur", "xyz", "grid", "npy", "npz"] | None = None,
    lateral_unit: str | None = None,
    height_unit: str | None = None,
    lateral_step: tuple[float, float] | None = None,
    first_row: Literal["lowest-y", "highest-y"] | None = None,
    layer: int | None = None,
    array: str | None = None,
    header_lines: int | None = None,
    accept_implausible: bool = False,
) -> HeightMap:
    """Read the scan of a face.

    Formats are X3P (ISO 25178-72), SDF (ISO 25178-71, BCR), SUR (Digital Surf), text (a grid, or x y z per line) and NumPy. The contents
    tell the format. What a file states is never guessed: what it leaves open must be given, and what it states must not be
    contradicted.

    Parameters
    ----------
    path : path-like
        The file.
    format : str, optional
        The format; needed only for text of three columns that is a grid.
    lateral_unit, height_unit : str, optional
        Units of positions and heights that the file does not state: ``"m"``, ``"mm"``, ``"um"``, ``"nm"`` and others.
    lateral_step : (float, float), optional
        Distances of neighbours along x and y, in ``lateral_unit``, that the file does not state.
    first_row : {"lowest-y", "highest-y"}, optional
        Where the first line lies, in formats that leave it open; at the lowest y by default.
    layer : int, optional
        Which of several layers of X3P, from 0.
    array : str, optional
        Which of several arrays of NumPy.
    header_lines : int, optional
        Lines of text before the numbers, where they look like numbers themselves.
    accept_implausible : bool
        Do without the check that sizes and slopes can be those of a scan.

    Raises
    ------
    FileError
        The file cannot be read, is damaged, or leaves something open.
    InputError
        An argument is not admissible.

    Examples
    --------
    >>> import microslip, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "face.x3p"
    >>> face = microslip.synthetic_face((60, 40), (20e-6, 20e-6), rms=1e-6, correlation_length=80e-6)
    >>> microslip.write_scan(path, face)
    >>> again = microslip.read_scan(path)
    >>> bool((again.heights == face.heights).all()), again.source["format"]
    (True, 'x3p')
    """
    step = None if lateral_step is None else _pair("lateral_step", lateral_step)
    (heights, steps, origin, height_step), about = _native.read_scan(
        os.fspath(path), format, lateral_unit, height_unit, step, first_row, layer, array, header_lines, accept_implausible
    )
    return HeightMap(heights, steps, origin, height_step, json.loads(about))


def write_scan(path: str | os.PathLike[str], scan: HeightMap) -> None:
    """Write the scan of a face, to the last bit, with its steps and its position.

    Parameters
    ----------
    path : path-like
        The file; ``.x3p`` (ISO 25178-72) or ``.csv`` (a line of heights per row). It is replaced.
    scan : HeightMap
        The face. Its height resolution is not written: the formats have no place for it.

    Raises
    ------
    FileError
        The file cannot be written.
    InputError
        The extension is another one, or the map is malformed.

    Examples
    --------
    >>> import microslip, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "face.csv"
    >>> microslip.write_scan(path, microslip.synthetic_face((60, 40), (20e-6, 20e-6), rms=1e-6, correlation_length=80e-6))
    >>> microslip.read_scan(path).step
    (2e-05, 2e-05)
    """
    _native.write_scan(os.fspath(path), scan._native())


def synthetic_face(
    points: tuple[int, int],
    step: tuple[float, float] | float,
    *,
    rms: float,
    correlation_length: tuple[float, float] | float,
    origin: tuple[float, float] = (0.0, 0.0),
    waviness: Sequence[tuple[float, float, float, float]] = (),
    tilt: tuple[float, float] = (0.0, 0.0),
    height_step: float | None = None,
    seed: int = 0,
) -> HeightMap:
    """A seeded Gaussian face, as a profilometer would see it.

    Parameters
    ----------
    points : (int, int)
        Points along x and y.
    step : (float, float)
        Distances of neighbours along x and y (m); one number serves for both.
    rms : float
        Root mean square roughness (m).
    correlation_length : (float, float)
        Lengths along x and y (m) over which the autocorrelation falls to 1/e; one number serves for both.
    origin : (float, float)
        Position of the first point (m).
    waviness : sequence of (float, float, float, float)
        Waves that are added: amplitude (m), inverse wavelengths along x and y (1/m), phase (rad).
    tilt : (float, float)
        Slopes along x and y.
    height_step : float, optional
        Height resolution of the instrument (m); exact heights by default.
    seed : int
        The same seed gives the same face.

    Raises
    ------
    InputError
        An argument is out of range.

    Examples
    --------
    >>> import microslip
    >>> face = microslip.synthetic_face((300, 200), 20e-6, rms=1e-6, correlation_length=100e-6, seed=3)
    >>> round(1e6 * float(face.heights.std()), 1)
    1.0
    """
    waves = _floats("waviness", waviness)
    if waves.size and (waves.ndim != 2 or waves.shape[1] != 4):
        remedy = "give amplitude, inverse wavelengths along x and y, and phase of each"
        raise InputError(f"waviness has the shape {waves.shape}; {remedy}", field="waviness", remedy=remedy)
    native = _native.synthetic_face(
        (_count(points[0]), _count(points[1])),
        _pair("step", step),
        _pair("origin", origin),
        float(rms),
        _pair("correlation_length", correlation_length),
        [(a, x, y, phase) for a, x, y, phase in waves.tolist()],
        _pair("tilt", tilt),
        height_step,
        _seed(seed),
    )
    return HeightMap(*native)


_Face = HeightMap | str | os.PathLike[str]


def press(surface: HeightMap, pressures: npt.ArrayLike) -> tuple[Floats, Floats, list[int]]:
    """Contact of a rough surface with an elastic half-space by boundary elements; the surface is mirrored at its edges.

    Of two faces it is their sum that is pressed, heights out of each body.

    Parameters
    ----------
    surface : HeightMap
        Heights, none missing.
    pressures : array_like
        Rising mean pressures over the contact modulus of both bodies, ``E/(2 (1 - nu^2))`` if they are equal [1].

    Returns
    -------
    separation : ndarray
        Mean gap at each pressure [m].
    area : ndarray
        Part of the area in contact.
    touching : list of int
        Points that touch; with fewer than 30 a pressure is not resolved.

    Raises
    ------
    InputError
        For missing heights, pressures that are not above zero, and surfaces whose contact is not found.

    Examples
    --------
    >>> import microslip
    >>> face = microslip.synthetic_face((64, 64), 20e-6, rms=1e-6, correlation_length=80e-6)
    >>> separation, area, _ = microslip.press(face, [1e-4, 1e-3])
    >>> bool(separation[1] < separation[0]), bool(area[1] > area[0])
    (True, True)
    """
    return _native.press(surface._native(), values("pressures", pressures).tolist())


def characterise(
    top: _Face,
    bottom: _Face,
    interface: _Mesh | tuple[int, int] = (1, 1),
    *,
    material: tuple[float, float],
    centred: bool = False,
    mirror_bottom: bool = False,
    align: float | None = None,
    shift: tuple[float, float] = (0.0, 0.0),
    tilt: tuple[float, float] = (0.0, 0.0),
    outliers: tuple[int, float] | None = None,
    s_filter: float | None = None,
    detrend: Literal["whole-face", "registered"] | float = 0.04,
    radius: Literal["inverse-mean-curvature", "mean"] = "inverse-mean-curvature",
    pair_radius: Literal["per-direction", "eq6-literal"] = "per-direction",
    packing_height: Literal["total-roughness", "mean-peak"] = "total-roughness",
    packing_efficiency: float = 0.5,
    count: Literal["packing", "summits"] = "packing",
    heights: Literal["pooled", "summed"] = "pooled",
    tangential: Literal["mindlin", "paper"] = "mindlin",
    interference: tuple[float, float] = (0.1e-6, 20e-6),
    samples: int = 64,
    u_ref: float = 1e-6,
    bootstrap: int = 30,
    seed: int = 0,
    tallest: Literal["fixed"] | float = "fixed",
    pruning: float = 0.05,
    least_peaks: int = 5,
) -> Characterisation:
    """Gap, asperities and traction curves of two faces, element by element of their interface.

    A plane is taken off each face, then a bilinear form off each element. What remains is roughness: its peaks give radii, heights
    and numbers of asperities, whose Hertz and Mindlin contacts add up to the traction curves.

    Parameters
    ----------
    top, bottom : HeightMap or path-like
        The faces, or files that state everything themselves (else :func:`read_scan` takes what they leave open). Heights point out
        of each body.
    interface : Interface, PlaneMesh or (int, int)
        The elements, or into how many along x and y the rectangle that both maps cover is divided.
    material : (float, float)
        Young's modulus (Pa) and Poisson ratio of both bodies.
    centred : bool
        Put the middle of each map on the middle of the interface.
    mirror_bottom : bool
        The bottom face was scanned from its own side: turn its x over.
    align : float, optional
        Move each map onto the elements by the edges and holes of its mask, by at most this (m).
    shift, tilt : (float, float)
        Motion of the bottom face against the top one after that: along x and y (m), and slopes.
    outliers : (int, float), optional
        Drop points that differ from the median of so many points to each side by more than so many robust standard deviations,
        such as ``(2, 6.0)``.
    s_filter : float, optional
        Cut-off wavelength of a Gaussian S-filter (m).
    detrend : float, "whole-face" or "registered"
        Points that carry the plane that is taken off: a strip along the free edges, as part of the shorter side, up to 0.5; all
        points; or no plane.
    radius, pair_radius, packing_height, packing_efficiency, count, heights, tangential
        Readings of the method, see the guide *Scenes*.
    interference : (float, float)
        Least and greatest interference of the curves (m).
    samples : int
        Samples of the curves, at least 8.
    u_ref : float
        Reference interference of the fits (m).
    bootstrap, seed : int
        Draws for the bands, 0 for none, and their seed.
    tallest : float or "fixed"
        What the draws do with the tallest peak: it stays where it is, or draws of m out of n heights, as exponent in (0, 1).
    pruning : float
        Rise of significant hills as part of the maximum height.
    least_peaks : int
        With fewer peaks in an element all asperities have one height.

    Raises
    ------
    InputError
        An argument is out of range, the maps do not cover the elements, or there are no peaks.
    FileError
        A scan cannot be read.

    Examples
    --------
    >>> import microslip
    >>> faces = [microslip.synthetic_face((240, 160), (20e-6, 20e-6), rms=1e-6, correlation_length=80e-6, seed=k) for k in (1, 2)]
    >>> found = microslip.characterise(*faces, (4, 2), material=(192.85e9, 0.29))
    >>> found.summary["elements"], found.fallbacks[0]
    (8, (None, None, None))
    """
    faces = [face if isinstance(face, HeightMap) else read_scan(face) for face in (top, bottom)]
    youngs_modulus, poisson_ratio = _two("material", material, "give Young's modulus (Pa) and Poisson ratio")
    mesh = _mesh(interface, faces)
    strip: str | dict[str, Any] = detrend if isinstance(detrend, str) else {"free-edges": {"width": detrend}}
    draws: str | dict[str, Any] = tallest if isinstance(tallest, str) else {"m-out-of-n": {"exponent": tallest}}
    settings = {
        "material": {"youngs_modulus": youngs_modulus, "poisson_ratio": poisson_ratio},
        "centred": centred,
        "mirror_bottom": mirror_bottom,
        "align": align,
        "registration": {"shift": _pair("shift", shift), "tilt": _pair("tilt", tilt)},
        "noise": {
            "outliers": None if outliers is None else {"reach": outliers[0], "threshold": outliers[1]},
            "s_filter": s_filter,
        },
        "detrend": strip,
        "radius": radius,
        "pair_radius": pair_radius,
        "packing_height": packing_height,
        "packing_efficiency": packing_efficiency,
        "count": count,
        "heights": heights,
        "tangential": tangential,
        "interference": _pair("interference", interference),
        "samples": samples,
        "u_ref": u_ref,
        "bootstrap": bootstrap,
        "seed": seed,
        "tallest": draws,
        "pruning": pruning,
        "least_peaks": least_peaks,
    }
    try:
        text = json.dumps(settings, allow_nan=False, default=_number)
    except (TypeError, ValueError) as error:
        raise InputError(f"an argument is no finite number: {error}", remedy="give finite numbers") from None
    columns, of_top, of_bottom, peaks, about = _native.characterise(
        faces[0]._native(), faces[1]._native(), mesh.nodes, mesh.elements, text
    )
    said = json.loads(about)
    return Characterisation(
        mesh=mesh,
        heights=tuple(_frozen(of_element) for of_element in peaks),
        top=FaceStatistics(**of_top),
        bottom=FaceStatistics(**of_bottom),
        normal_band=columns.pop("normal_band", None),
        fallbacks=tuple((normal, x, y) for normal, x, y in said["fallbacks"]),
        summary=said["summary"],
        faces=(said["faces"][0], said["faces"][1]),
        alignments=(said["alignments"][0], said["alignments"][1]),
        options=said["options"],
        **columns,
    )


def _number(value: Any) -> Any:
    """A number of NumPy as one that JSON knows."""
    if hasattr(value, "item"):
        return value.item()
    raise TypeError(f"{type(value).__name__} is no number")


def _frozen(values: Floats) -> Floats:
    values.flags.writeable = False
    return values


def _mesh(interface: _Mesh | tuple[int, int], faces: Sequence[HeightMap]) -> PlaneMesh:
    """The elements that are meant."""
    if isinstance(interface, tuple):
        ends = [[face.origin[k] + face.step[k] * (face.heights.shape[1 - k] - 1) for face in faces] for k in (0, 1)]
        low = [max(face.origin[k] for face in faces) for k in (0, 1)]
        size = (min(ends[0]) - low[0], min(ends[1]) - low[1])
        if min(size) <= 0.0:
            remedy = "state their origins, or give the elements with centred=True"
            raise InputError(f"the two maps do not cover a common rectangle; {remedy}", field="interface", remedy=remedy)
        return rectangular_mesh(size, interface, (low[0], low[1]))
    if not (hasattr(interface, "nodes") and hasattr(interface, "elements")):
        remedy = "give a PlaneMesh, the interface of a run, or numbers of elements along x and y"
        raise InputError(f"the interface is a {type(interface).__name__}; {remedy}", field="interface", remedy=remedy)
    mesh = PlaneMesh(interface.nodes, interface.elements)
    if mesh.nodes.ndim != 2 or mesh.nodes.shape[1] != 2 or mesh.elements.ndim != 2:
        remedy = "nodes must have the shape (n, 2), elements (m, nodes)"
        raise InputError(f"shapes {mesh.nodes.shape} and {mesh.elements.shape} are no plane mesh; {remedy}", field="interface", remedy=remedy)
    return mesh
