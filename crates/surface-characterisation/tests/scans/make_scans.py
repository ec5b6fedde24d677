"""Writes the SUR and NumPy files beside it (made with surfalize 0.19.2, RosettaSciIO 0.15.0, NumPy 2.4.6).

All hold the surface z = cos(2 pi x / 40) cos(2 pi y / 36) + 0.3 sin(2 pi x / 14) in um, 24 points along x with steps of
2 um, 20 along y with steps of 3 um; where a format has missing points, rows 10 to 13 of columns 5 to 9 are missing.
"""
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
x = np.arange(24) * 2.0
y = (np.arange(20) * 3.0)[:, np.newaxis]
z = np.cos(2 * np.pi * x / 40) * np.cos(2 * np.pi * y / 36) + 0.3 * np.sin(2 * np.pi * x / 14)
holes = z.copy()
holes[10:14, 5:10] = np.nan


def sur():
    from surfalize import Surface

    surface = Surface(holes, 2.0, 3.0)
    surface.save(HERE / "surfalize.sur")
    surface.save(HERE / "surfalize_compressed.sur", compressed=True)

    from rsciio.digitalsurf import file_writer

    axes = [
        {"name": "Y", "size": 20, "offset": 0.0, "scale": 3.0, "units": "um", "index_in_array": 0, "navigate": False},
        {"name": "X", "size": 24, "offset": 0.0, "scale": 2.0, "units": "um", "index_in_array": 1, "navigate": False},
    ]
    heights = np.round(z * 1000).astype(np.int16)
    signal = {
        "data": heights,
        "axes": axes,
        "metadata": {"Signal": {"quantity": "Height (nm)"}, "General": {}},
        "original_metadata": {},
    }
    file_writer(HERE / "rosettasciio_16.sur", signal, compressed=True)


def numpy():
    np.save(HERE / "f8.npy", holes)
    np.save(HERE / "columns.npy", np.asfortranarray(holes.astype(">f4")))
    np.savez_compressed(HERE / "maps.npz", height=np.round(z * 1000).astype(np.int16), mask=np.isnan(holes), pitch=2.0)


numpy()
sur()
