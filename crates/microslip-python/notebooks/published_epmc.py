# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # Backbones that were published
# J. H. Porter and M. R. W. Brake followed the Brake-Reuss beam with friction resolved over asperities by the extended periodic motion
# concept (EPMC; Mech. Syst. Signal Process. 192 (2023) 110210, and its public code). The same surface is run here by quasi-static modal
# analysis (CQSMA), on the quick mesh and with few amplitudes, so that the page takes a minute; `fixtures/scenes/published-epmc-*.json`
# have the fine mesh.
#
# The published numbers are in a file `published.json`, in the folder that the environment variable `BRB_REFERENCE` names.

# %%
import json
import os
from pathlib import Path

import numpy as np

import microslip

file = Path(os.environ.get("BRB_REFERENCE", ".")) / "published.json"
published = json.loads(file.read_text()) if file.exists() else None
if published is None:
    print("skipped the published backbones: BRB_REFERENCE names no folder with published.json")

# %%
scene = microslip.Scene.from_dict({
    "units": {"length": "m", "mass": "kg", "time": "s"},
    "structure": {"benchmark": "brake-reuss-beam"},
    "model": {
        "refinement": "quick",
        "formulation": "reduced",
        "material": {"youngs_modulus": "192.31 GPa", "poisson_ratio": 0.3, "density": 7784.3}},
    "interfaces": {
        "surface": "measured",
        "gap": "flat",
        "mu": 0.03,
        "points_per_direction": 1,
        "law": {
            "friction": "resolved",
            "history": "end-point",
            "cone": "box",
            "bins": {"equally-spaced": 101},
            "yield": {"strength": "331.7 MPa", "tangent_modulus": "620 MPa"}}},
    "bolts": {"load": 12249, "assembly": "frictionless"},
    "background_damping": 0.00087,
    "analyses": {"backbone": {"amplitudes": 9, "amplitude_from": 1e-7, "amplitude_to": 6.8e-5}}})
runs = {"flat": microslip.run(scene), "topography": microslip.run(scene.replace({"interfaces.gap": "measured"}))}

# %%
import matplotlib.pyplot as plt

figure, (above, below) = plt.subplots(2, 1, figsize=(6.4, 6.4), sharex=True, layout="constrained")
for colour, (name, run) in zip(("C0", "C1"), runs.items()):
    style = {"color": colour, "marker": "o", "markersize": 4, "linewidth": 1.2, "label": f"{name}, CQSMA here"}
    above.semilogx(run.modal_amplitude, run.frequency_hz, **style)
    below.loglog(run.modal_amplitude, run.damping_ratio, **style)
    if published is not None:
        theirs = published[f"epmc_rough_contact_{name}"]
        style = {"color": colour, "linestyle": "--", "linewidth": 1.2, "label": f"{name}, published EPMC"}
        above.semilogx(theirs["modal_amplitude"], theirs["frequency_hz"], **style)
        below.loglog(theirs["modal_amplitude"], theirs["damping_ratio"], **style)
above.set_ylabel("frequency (Hz)")
below.set_ylabel("damping ratio (-)")
below.set_xlabel("modal amplitude (kg$^{1/2}$ m)")
above.legend(frameon=False, fontsize="small")
for axes in (above, below):
    axes.grid(visible=True, linewidth=0.4)

# %% [markdown]
# ## How far apart they are
# Both over modal amplitude. The mesh here is coarse: it shifts the frequency, hardly the damping.

# %%
for name, run in runs.items():
    if published is None:
        break
    theirs = published[f"epmc_rough_contact_{name}"]
    here = microslip.MeasuredBackbone(run.modal_amplitude, run.frequency_hz, run.damping_ratio, "displacement", f"{name}, here")
    there = microslip.MeasuredBackbone(
        theirs["modal_amplitude"], theirs["frequency_hz"], theirs["damping_ratio"], "displacement", f"{name}, published"
    )
    misfit = microslip.compare(here, there).misfits[0]
    print(f"{name}: frequency {misfit.frequency_percent.mean:+.2f} %, damping {100 * np.expm1(misfit.damping_ln.mean):+.1f} % in the mean")
    assert misfit.frequency_percent.rms < 6.0 and misfit.damping_ln.rms < 0.35
assert all(run.converged.all() for run in runs.values())
