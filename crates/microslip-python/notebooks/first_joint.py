# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # A first joint
# Two bars of steel overlap and are pulled together by one bolt. The mesh is a file of Gmsh with names for the faces that touch, for the
# faces below head and nut, and for the point where amplitudes are measured. The traction law follows from the measured faces of a
# benchmark; two scans of one's own take their place in the notebook `scans_to_bands`.

# %%
import tempfile
from pathlib import Path

import sample_joint

folder = Path(tempfile.mkdtemp())
sample_joint.write(folder)

# %% [markdown]
# ## Fifteen lines
# From the mesh to frequency and damping against amplitude.

# %%
import microslip

scene = microslip.Scene.from_dict({
    "name": "lap joint",
    "units": {"length": "m", "mass": "kg", "time": "s"},
    "structure": {"mesh": {
        "path": "joint.msh",
        "interfaces": [{"top": "TOP", "bottom": "BOTTOM"}],
        "bolts": [{"head": "HEAD", "nut": "NUT"}],
        "response": {"node": "TIP", "direction": [0, 0, 1]}}},
    "model": {"material": {"youngs_modulus": "192.85 GPa", "poisson_ratio": 0.29, "density": "7857.8 kg/m^3"}},
    "interfaces": {"surface": {"benchmark": "brake-reuss-beam"}, "mu": 0.2},
    "bolts": {"load": "3 kN"},
    "analyses": {"backbone": {"amplitudes": 12, "amplitude_from": "3 um", "amplitude_to": "150 um"}}}, folder)
run = microslip.run(scene)
figure = run.plot()

# %%
figure

# %% [markdown]
# ## What the numbers say
# At small amplitudes nothing slips. Then more and more of the area does: the frequency falls, the damping rises.

# %%
table = run.to_pandas()[["response_displacement", "frequency_hz", "damping_ratio", "slip_fraction"]]
print(table.to_string(index=False, float_format="{:.4g}".format))
assert run.converged.all() and run.frequency_hz[-1] < run.frequency_hz[0] and run.slip_fraction[-1] > 0.01
