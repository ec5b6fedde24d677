# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # From two scans to a backbone with bands
# Each face of the joint was scanned by a profilometer. The scans give gap, asperities and traction laws of every interface element. How
# sure they are follows from drawing the heights anew.

# %%
import tempfile
from pathlib import Path

import numpy as np
import sample_joint

import microslip

folder = Path(tempfile.mkdtemp())
sample_joint.write(folder)

# %% [markdown]
# Synthetic scans stand for measured ones: Gaussian roughness of 2 um, slightly tilted, in height steps of 0.1 um.

# %%
length, width = sample_joint.OVERLAP
for name, seed in (("top", 1), ("bottom", 2)):
    face = microslip.synthetic_face(
        (301, 121),
        (length / 300, width / 120),
        origin=(-0.5 * length, -0.5 * width),
        rms=2e-6,
        correlation_length=(200e-6, 300e-6),
        tilt=(1e-4, 0.0),
        height_step=0.1e-6,
        seed=seed,
    )
    microslip.write_scan(folder / f"{name}.x3p", face)
top, bottom = (microslip.read_scan(folder / f"{name}.x3p") for name in ("top", "bottom"))

# %% [markdown]
# ## What is on the faces

# %%
mesh = microslip.rectangular_mesh((length, width), (6, 4), origin=(-0.5 * length, -0.5 * width))
found = microslip.characterise(top, bottom, mesh, material=(192.85e9, 0.29))
gap_map = found.plot("gap")
gap_map

# %%
print(found.to_pandas()[["gap", "total_roughness", "count", "effective_radius", "top_sq"]].describe().loc[["min", "50%", "max"]])
assert abs(np.median(found.top.sq) / 2e-6 - 1.0) < 0.1

# %% [markdown]
# The normal traction of one element, with its fit and the 95 % band of the bootstrap.

# %%
import matplotlib.pyplot as plt

element = int(np.argsort(found.total_roughness)[len(found.area) // 2])
curve, band = found.normal_traction[element], found.normal_band[element]
traction, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
axes.fill_between(1e6 * found.interference, 1e-6 * band[0], 1e-6 * band[1], alpha=0.25, label="95 % band")
axes.loglog(1e6 * found.interference, 1e-6 * curve, label=f"element {element}")
axes.set_xlabel("interference (um)")
axes.set_ylabel("normal traction (MPa)")
axes.grid(visible=True, which="both", linewidth=0.3)
axes.set_ylim(bottom=0.1e-6 * curve[0])
axes.legend(frameon=False)

# %% [markdown]
# ## The joint with these faces
# The scene names the two files. Each of twenty realisations of the laws runs on the same reduced structure.

# %%
scene = microslip.Scene.from_dict(
    {**sample_joint.SCENE, "interfaces": {"surface": {"scans": ["top.x3p", "bottom.x3p"]}, "gap": "scan", "mu": 0.2}},
    folder,
)
run = microslip.run(scene, ensemble=20)
bands = run.ensemble

# %%
figure = run.plot()
above, below = figure.axes
for axes, values in ((above, bands.frequency_hz), (below, bands.damping_ratio)):
    axes.fill_between(bands.response_displacement, values[:, 0], values[:, 2], alpha=0.25, label="5 to 95 %")
    axes.legend(frameon=False)
figure

# %%
assert bands.realisations == 20 and np.all(bands.frequency_hz[:, 0] <= bands.frequency_hz[:, 2])
print(f"{bands.realisations} realisations, {bands.failed} without a backbone")
