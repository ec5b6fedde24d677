"""Files of matrices and meshes."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from microslip import _native
from microslip.errors import InputError
from microslip.results import _Comparable
from microslip.scene import Scene

__all__ = ["SolidMesh", "read_matrices", "read_mesh", "reduced_model", "write_matrices", "write_mesh"]

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def read_matrices(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read the arrays in a file.

    ============  =========================================================================================
    ``.npz``      NumPy, with sparse matrices as ``scipy.sparse.save_npz`` writes them
    ``.mat``      MATLAB and Octave (``-v6``, ``-v7``, ``-v7.3``)
    ``.mtx``      Matrix Market; ``*SUBSTRUCTURE MATRIX OUTPUT`` and ``*MATRIX OUTPUT`` of Abaqus
    ``.sti``      CalculiX, with ``.mas`` and ``.dof`` beside it
    ``.full``     assembled matrices of Ansys
    ``.op4``      ``OUTPUT4`` of Nastran
    ``.op2``      ``OUTPUT2`` of Nastran: matrices, and tables ``DMIG`` by their own names
    ``.pch``      entries ``DMIG`` of Nastran, also in ``.bdf`` and ``.dat``
    ============  =========================================================================================

    Returns
    -------
    dict
        By name: arrays of two dimensions (vectors are columns) of float64 or int64, texts, and sparse matrices as
        ``scipy.sparse.csr_matrix``. An array without a name is called ``"matrix"``. Files with a list of degrees of freedom have it
        as ``"dofs"``, a row of label and component for each row of the matrices.

    Raises
    ------
    FileError
        The file cannot be read, is damaged, or holds numbers that are not finite.
    InputError
        The extension is another one.
    ImportError
        There are sparse matrices, and SciPy is not installed.

    Examples
    --------
    >>> import microslip, numpy as np, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "model.npz"
    >>> np.savez(path, K=np.eye(3), dofs=np.array([[1, 1], [1, 2], [1, 3]]))
    >>> {name: array.shape for name, array in microslip.read_matrices(path).items()}
    {'K': (3, 3), 'dofs': (3, 2)}
    """
    found, _ = _native.read_matrices(os.fspath(path))
    return {name: _array(value) for name, value in found}


def _array(value: Any) -> Any:
    if not isinstance(value, tuple):
        return value
    try:
        from scipy.sparse import csr_matrix
    except ImportError as error:
        raise ImportError("sparse matrices need SciPy; install it by `pip install microslip[sparse]`") from error
    shape, starts, columns, entries = value
    return csr_matrix((entries, columns, starts), shape=shape)


def write_matrices(path: str | os.PathLike[str], arrays: Mapping[str, Any]) -> None:
    """Write arrays into a file.

    Parameters
    ----------
    path : path-like
        The file; ``.npz``, ``.mat`` (level 5), ``.op4`` (no texts), or ``.mtx`` (Matrix Market, one array). It is replaced.
    arrays : mapping
        By name: arrays of at most two dimensions (vectors become columns), sparse matrices of SciPy, and texts. Whole numbers
        stay whole.

    Raises
    ------
    FileError
        The file cannot be written.
    InputError
        The extension is another one, a name or a number is nothing that the format can hold.

    Examples
    --------
    >>> import microslip, numpy as np, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "model.mat"
    >>> microslip.write_matrices(path, {"K": np.diag([2.0, 3.0]), "about": "two springs"})
    >>> microslip.read_matrices(path)["about"]
    'two springs'
    """
    _native.write_matrices(os.fspath(path), [(str(name), _plain(name, value)) for name, value in arrays.items()])


def _plain(name: str, value: Any) -> Any:
    """An array as the native module takes it."""
    if isinstance(value, str):
        return value
    if hasattr(value, "tocsr"):
        matrix = value.tocsr(copy=True)
        # Sorts the columns of each row as well.
        matrix.sum_duplicates()
        return (
            matrix.shape,
            np.asarray(matrix.indptr, dtype=np.int64),
            np.asarray(matrix.indices, dtype=np.int64),
            np.asarray(matrix.data, dtype=np.float64),
        )
    try:
        array = np.asarray(value)
        whole = array.dtype.kind in "iub"
        array = array.astype(np.int64 if whole else np.float64, order="C", casting="same_kind" if whole else "safe")
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} cannot be written as numbers: {error}", field="arrays") from None
    if array.ndim > 2:
        remedy = "give at most two dimensions"
        raise InputError(f"{name} has the shape {array.shape}; {remedy}", field="arrays", remedy=remedy)
    return array.reshape(-1, 1) if array.ndim < 2 else array


def reduced_model(
    scene: Scene,
    *,
    progress: Callable[[str, float], object] | None = None,
    threads: int | None = None,
    cache: str | os.PathLike[str] | Literal[False] | None = None,
) -> dict[str, Any]:
    """The reduced model of a scene without its contact, for other programs.

    Parameters
    ----------
    scene : Scene
        A scene with one plane interface.
    progress, threads, cache
        As of :func:`microslip.run`.

    Returns
    -------
    dict
        As :func:`read_matrices` gives it, in SI: mass ``M`` and stiffness ``K``, a column ``Fv`` per bolt (its unit tension), a row
        ``R`` per response, ``dofs``, ``frame``, ``interface_nodes``, ``interface_elements`` (node numbers from 1) and ``about``, which
        explains them. Coordinates are the jumps at the nodes of the interface, then modes with the interface stuck.

    Raises
    ------
    SceneError
        The scene does not fit the files that it names.
    InputError
        The interface is curved, or faced in part.

    Examples
    --------
    >>> import microslip
    >>> model = microslip.reduced_model(microslip.Scene.benchmark("brake-reuss-beam/brb-quick"))
    >>> model["K"].shape == model["M"].shape, model["Fv"].shape[1]
    (True, 3)
    """
    if not isinstance(scene, Scene):
        raise InputError(f"the scene is a {type(scene).__name__}; give a Scene", field="scene", remedy="give a Scene")
    kept = True if cache is None else cache if cache is False else os.fspath(cache)
    return {name: _array(value) for name, value in _native.reduced_model(scene._handle, progress, threads, kept)}


@dataclass(frozen=True, eq=False)
class SolidMesh(_Comparable):
    """A mesh of solids with named groups, in the length unit of its file.

    Node and cell numbers count from 0. Cells are numbered over all types together. Nodes of a cell are in the order of Abaqus: the
    corners of one face, counter-clockwise seen from within, then the opposite ones, the middles of edges, those of faces, the centre.

    Examples
    --------
    >>> import numpy as np
    >>> import microslip
    >>> nodes = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    >>> microslip.SolidMesh(nodes, {"tet4": np.array([[0, 1, 2, 3]])}).n_cells
    1
    """

    nodes: Floats
    """Positions of the nodes, shape ``(nodes, 3)``."""
    cells: Mapping[str, Integers]
    """By type (``"hex8"``, ``"hex20"``, ``"hex27"``, ``"tet4"``, ``"tet10"``, ``"wedge6"``, ``"wedge15"``) the nodes of each cell."""
    volumes: Mapping[str, Integers] = field(default_factory=dict)
    """Groups of cells by name: their numbers."""
    surfaces: Mapping[str, Integers] = field(default_factory=dict)
    """Groups of faces by name: nodes of each face, counter-clockwise seen from outside; rows of smaller faces end with -1."""
    points: Mapping[str, Integers] = field(default_factory=dict)
    """Groups of nodes by name: their numbers."""
    cell_numbers: Mapping[str, Integers] = field(default_factory=dict)
    """By type the number of each cell; by default they count on from type to type."""
    labels: Integers | None = None
    """The file's own number of each node."""
    bodies: Integers | None = None
    """Number of the body that each cell belongs to: cells that share nodes; shape ``(cells,)``."""
    notes: tuple[str, ...] = ()
    """What was skipped."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", _table("nodes", self.nodes, np.float64, 3))
        for name in ("cells", "surfaces"):
            tables: dict[str, Integers] = {key: _table(f"{name}, {key}", value, np.int64) for key, value in getattr(self, name).items()}
            object.__setattr__(self, name, tables)
        numbers = dict(self.cell_numbers)
        if not numbers:
            first = 0
            for key, value in self.cells.items():
                numbers[key] = np.arange(first, first + len(value))
                first += len(value)
        object.__setattr__(self, "cell_numbers", numbers)
        for name in ("volumes", "points", "cell_numbers"):
            lists = {key: _list(f"{name}, {key}", value) for key, value in getattr(self, name).items()}
            object.__setattr__(self, name, lists)
        super().__post_init__()

    @property
    def n_cells(self) -> int:
        """Number of cells.

        Examples
        --------
        >>> import numpy as np
        >>> import microslip
        >>> microslip.SolidMesh(np.zeros((4, 3)), {}).n_cells
        0
        """
        return sum(len(nodes) for nodes in self.cells.values())


def _table(name: str, values: Any, kind: type, columns: int | None = None) -> Any:
    try:
        table: Any = np.array(values, dtype=kind, order="C")
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} cannot be read as numbers: {error}", field=name) from None
    if table.ndim != 2 or (columns is not None and table.shape[1] != columns):
        remedy = f"give a table of {columns} columns" if columns else "give a table with a row for each"
        raise InputError(f"{name} has the shape {table.shape}; {remedy}", field=name, remedy=remedy)
    table.flags.writeable = False
    return table


def _list(name: str, values: Any) -> Integers:
    return _table(name, np.reshape(values, (-1, 1)), np.int64)[:, 0]  # type: ignore[no-any-return]


def read_mesh(path: str | os.PathLike[str]) -> SolidMesh:
    """Read a mesh of solids.

    Parameters
    ----------
    path : path-like
        Gmsh (``.msh``, versions 4.1 and 2), Abaqus, CalculiX or PrePoMax (``.inp``), Nastran or Optistruct (``.bdf``, ``.nas``,
        ``.fem``), Ansys (``.cdb``), I-DEAS (``.unv``), Exodus II (``.exo``, ``.e``, ``.g``), Salome (``.med``) or VTK (``.vtu``). Of decks the mesh alone
        is read. In VTK files the values of integer arrays of cells are the names of groups.

    Raises
    ------
    FileError
        The file cannot be read, is damaged, or has cells that are inverted or listed twice.

    Examples
    --------
    >>> import microslip, pathlib, tempfile, numpy as np
    >>> nodes = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "corner.msh"
    >>> microslip.write_mesh(path, microslip.SolidMesh(nodes, {"tet4": [[0, 1, 2, 3]]}, points={"tip": [3]}))
    >>> microslip.read_mesh(path).points["tip"].tolist()
    [3]
    """
    nodes, labels, cells, volumes, surfaces, points, bodies, notes = _native.read_mesh(os.fspath(path))
    return SolidMesh(
        nodes,
        {name: of_type for name, _, of_type in cells},
        dict(volumes),
        dict(surfaces),
        dict(points),
        {name: numbers for name, numbers, _ in cells},
        labels,
        bodies,
        tuple(notes),
    )


def write_mesh(
    path: str | os.PathLike[str],
    mesh: SolidMesh,
    *,
    point_fields: Mapping[str, npt.ArrayLike] | None = None,
    cell_fields: Mapping[str, npt.ArrayLike] | None = None,
) -> None:
    """Write a mesh of solids for Gmsh or ParaView.

    Parameters
    ----------
    path : path-like
        The file; ``.msh`` (version 4.1) with all groups, or ``.vtu`` with fields. It is replaced. VTK files have no names: the volume of
        a cell is a number in the array ``material``, and surfaces and groups of nodes are left out.
    mesh : SolidMesh
        The mesh. Its volumes may not overlap; cells in none of them are in a volume ``rest``.
    point_fields, cell_fields : mapping, optional
        For VTK: by name values at the nodes and in the cells, shape ``(n,)`` or ``(n, components)``; cells in the order of their numbers.

    Raises
    ------
    FileError
        The file cannot be written.
    InputError
        Nodes or cells do not exist, a type of cells is not known, or fields have another length.

    Examples
    --------
    >>> import microslip, pathlib, tempfile, numpy as np
    >>> nodes = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    >>> mesh = microslip.SolidMesh(nodes, {"tet4": [[0, 1, 2, 3]]})
    >>> microslip.write_mesh(pathlib.Path(tempfile.mkdtemp()) / "corner.vtu", mesh, point_fields={"height": nodes[:, 2]})
    """
    _native.write_mesh(
        os.fspath(path),
        mesh.nodes,
        [(name, mesh.cell_numbers[name], nodes) for name, nodes in mesh.cells.items() if name in mesh.cell_numbers],
        list(mesh.volumes.items()),
        list(mesh.surfaces.items()),
        list(mesh.points.items()),
        _fields("point_fields", point_fields),
        _fields("cell_fields", cell_fields),
    )


def _fields(name: str, given: Mapping[str, npt.ArrayLike] | None) -> list[tuple[str, Floats]]:
    found = []
    for key, values in (given or {}).items():
        try:
            array = np.asarray(values, dtype=np.float64, order="C")
        except (TypeError, ValueError) as error:
            raise InputError(f"{name}, {key} cannot be read as numbers: {error}", field=name) from None
        if array.ndim not in (1, 2):
            remedy = "give one or more numbers per place"
            raise InputError(f"{name}, {key} has the shape {array.shape}; {remedy}", field=name, remedy=remedy)
        found.append((str(key), array.reshape(len(array), -1)))
    return found
