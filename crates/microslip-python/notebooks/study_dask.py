# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # A study on a cluster
# Friction coefficient and bolt load are hardly known. Their influence is computed in parallel by Dask: scenes and runs can be pickled, so
# that they go to workers as they are.

# %%
import itertools

import numpy as np
from dask.distributed import Client, LocalCluster

import microslip

base = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace(
    {"analyses.backbone": {"amplitudes": 10, "amplitude_from": 2e-5, "amplitude_to": 1e-3, "vertices_per_quarter": 4}}
)
mus, loads = (0.1, 0.2, 0.4), (6e3, 12e3, 18e3)
scenes = [
    base.replace({"interfaces.mu": mu, "bolts.load": load}, name=f"mu {mu}, {load / 1e3:g} kN")
    for mu, load in itertools.product(mus, loads)
]

# %% [markdown]
# One process per worker, one thread each: a study has more scenes than processors. In a script this belongs below
# `if __name__ == "__main__":`, since workers import the script.

# %%
cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
# On Slurm, only the line above changes (package dask-jobqueue); the folder of the cache must be one that all nodes see:
# cluster = SLURMCluster(queue="compute", cores=1, memory="4GB", walltime="01:00:00"); cluster.scale(jobs=40)
client = Client(cluster)

# %%
futures = client.map(microslip.run, scenes, threads=1, pure=False)
runs = client.gather(futures)
client.close()
cluster.close()

# %% [markdown]
# ## Frequency and damping over the plane

# %%
import pandas

at = 100e-6  # response displacement (m)
table = pandas.DataFrame(
    {
        "mu": scene.to_dict()["interfaces"]["mu"],
        "load (kN)": scene.to_dict()["bolts"]["load"] / 1e3,
        "frequency (Hz)": np.interp(np.log(at), np.log(run.response_displacement), run.frequency_hz),
        "damping ratio": np.interp(np.log(at), np.log(run.response_displacement), run.damping_ratio),
    }
    for scene, run in zip(scenes, runs)
)
print(table.to_string(index=False, float_format="{:.5g}".format))

# %%
import matplotlib.pyplot as plt

figure, (above, below) = plt.subplots(2, 1, figsize=(6.4, 6.4), sharex=True, layout="constrained")
for index, (scene, run) in enumerate(zip(scenes, runs)):
    mu, load = divmod(index, len(loads))
    style = {"color": f"C{mu}", "linestyle": ("-", "--", ":")[load], "linewidth": 1.3, "label": scene.name}
    above.semilogx(run.response_displacement, run.frequency_hz, **style)
    below.loglog(run.response_displacement, np.where(run.damping_ratio > 1e-6, run.damping_ratio, np.nan), **style)
above.set_ylabel("frequency (Hz)")
below.set_ylabel("damping ratio (-)")
below.set_xlabel("displacement amplitude (m)")
above.legend(frameon=False, fontsize="small", ncols=3, loc="upper center", bbox_to_anchor=(0.5, 1.32))
for axes in (above, below):
    axes.grid(visible=True, linewidth=0.4)

# %%
frequency = table["frequency (Hz)"].to_numpy().reshape(len(mus), len(loads))
assert (np.diff(frequency, axis=1) > 0).all(), "more preload is stiffer"
assert (np.diff(frequency, axis=0) > 0).all(), "more friction is stiffer at this amplitude"
