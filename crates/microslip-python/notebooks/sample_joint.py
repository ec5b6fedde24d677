"""Two steel bars that overlap, as a mesh for Gmsh: what the notebooks run on. One's own mesh takes its place."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np

import microslip

EDGE, THICKNESS = 3e-3, 6e-3  # of elements in the plane, and of the bars (m)
OVERLAP = (18e-3, 12e-3)  # the faces in contact, about the origin (m)
CELLS = (20, 4, 2)  # of each bar along x, y and z

SCENE = {
    "name": "lap joint",
    "units": {"length": "m", "mass": "kg", "time": "s"},
    "structure": {
        "mesh": {
            "path": "joint.msh",
            "interfaces": [{"top": "TOP", "bottom": "BOTTOM"}],
            "bolts": [{"head": "HEAD", "nut": "NUT"}],
            "response": {"node": "TIP", "direction": [0, 0, 1]},
        }
    },
    "model": {"material": {"youngs_modulus": "192.85 GPa", "poisson_ratio": 0.29, "density": "7857.8 kg/m^3"}},
    "interfaces": {"surface": {"benchmark": "brake-reuss-beam"}, "mu": 0.2},
    "bolts": {"load": "3 kN"},
    "analyses": {"backbone": {"amplitudes": 10, "amplitude_from": "3 um", "amplitude_to": "150 um"}},
}


def bar(x: float, z: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and hexahedra of a bar from x and z (m) on, in the middle of y."""
    nx, ny, nz = CELLS
    step = np.array([EDGE, EDGE, THICKNESS / nz])
    grid = np.array([(i, j, k) for k, j, i in product(range(nz + 1), range(ny + 1), range(nx + 1))])
    nodes = np.array([x, -0.5 * EDGE * ny, z]) + step * grid

    def node(i: int, j: int, k: int) -> int:
        return i + (nx + 1) * (j + (ny + 1) * k)

    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    cells = [[node(i + a, j + b, k + c) for c in (0, 1) for a, b in ring] for k, j, i in product(range(nz), range(ny), range(nx))]
    return nodes, np.array(cells)


def faces(nodes: np.ndarray, cells: np.ndarray, side: int, height: float, reach: tuple[float, float]) -> np.ndarray:
    """The bottom (0) or top (1) faces of cells at a height, within a rectangle about the origin."""
    quads = cells[:, 4 * side : 4 * side + 4]
    centre = nodes[quads].mean(axis=1)
    inside = (abs(centre[:, 0]) < reach[0]) & (abs(centre[:, 1]) < reach[1]) & (abs(centre[:, 2] - height) < 1e-9)
    return quads[inside]


def write(folder: Path) -> Path:
    """Writes ``joint.msh`` into a folder, and gives its path."""
    upper, cells = bar(-0.5 * OVERLAP[0], 0.0)
    lower, _ = bar(0.5 * OVERLAP[0] - EDGE * CELLS[0], -THICKNESS)
    nodes, both = np.vstack([upper, lower]), np.vstack([cells, cells + len(upper)])
    of_upper, of_lower = both[: len(cells)], both[len(cells) :]
    half, seat = (0.5 * OVERLAP[0], 0.5 * OVERLAP[1]), (3e-3, 3e-3)
    mesh = microslip.SolidMesh(
        nodes,
        {"hex8": both},
        volumes={"upper": np.arange(len(cells)), "lower": np.arange(len(cells), len(both))},
        surfaces={
            "TOP": faces(nodes, of_upper, 0, 0.0, half),
            "BOTTOM": faces(nodes, of_lower, 1, 0.0, half),
            "HEAD": faces(nodes, of_upper, 1, THICKNESS, seat),
            "NUT": faces(nodes, of_lower, 0, -THICKNESS, seat),
        },
        points={"TIP": np.array([len(upper) - 1])},
    )
    path = folder / "joint.msh"
    microslip.write_mesh(path, mesh)
    return path
