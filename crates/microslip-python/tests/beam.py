"""A clamped beam on two contacts, as matrices: the scene of the guide *Matrices*."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

SCENE = {
    "units": {"length": "m", "mass": "kg", "time": "s"},
    "structure": {
        "matrices": {
            "path": "beam.npz",
            "coordinates": "jump",
            "points": [{"node": 5}, {"node": 10}],
            "response": {"terms": [[10, 1, 1.0]]},
        }
    },
    "model": {"material": {"youngs_modulus": "200 GPa", "poisson_ratio": 0.3}},
    "interfaces": {
        "mu": 0.3,
        "surface": {
            "parameters": {
                "per": "point",
                "sets": [
                    {"curves": {"elastic": {"normal_stiffness": 2e5, "tangential_stiffness": [1e5, 1e5]}}, "preload": 50.0},
                    {"curves": {"elastic": {"normal_stiffness": 1e5, "tangential_stiffness": [5e4, 5e4]}}, "mu": 0.2, "preload": 20.0},
                ],
            }
        },
    },
    "analyses": {"backbone": {"amplitude_from": "1 um", "amplitude_to": "0.5 mm"}},
}


def matrices() -> dict[str, np.ndarray]:
    """Stiffness, mass and the map of their rows, of two planes of bending."""
    n, h, mass = 10, 0.06, 7800 * 2e-4
    k = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h], [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]])
    m = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h], [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]])
    k, m = k / h**3, m * mass * h / 420
    stiffness, masses, dofs = np.zeros((4 * n, 4 * n)), np.zeros((4 * n, 4 * n)), []
    for plane, (component, bending) in enumerate(zip([1, 3], [350.0, 14e3], strict=True)):
        for element in range(n):
            for a in range(4):
                for b in range(4):
                    i, j = 2 * (element - 1) + a, 2 * (element - 1) + b
                    if min(i, j) >= 0:
                        stiffness[2 * n * plane + i, 2 * n * plane + j] += bending * k[a, b]
                        masses[2 * n * plane + i, 2 * n * plane + j] += m[a, b]
        for node in range(1, n + 1):
            dofs += [[node, component], [-node, component]]
    return {"K": stiffness, "M": masses, "dofs": np.array(dofs)}


def write(folder: Path, **fields: object) -> Path:
    """Writes matrices and scene, of which ``fields`` replace some, and gives the file of the scene."""
    np.savez(folder / "beam.npz", **matrices())
    path = folder / "beam.json"
    path.write_text(json.dumps({**SCENE, **fields}))
    return path
