# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
# ---

# %% [markdown]
# # A measured ring-down over theory
# A joint is struck by a hammer. The ring-down gives frequency and damping against amplitude, and theory is laid over it.

# %%
import tempfile
from pathlib import Path

import numpy as np
import sample_joint

import microslip

folder = Path(tempfile.mkdtemp())
sample_joint.write(folder)
scene = microslip.Scene.from_dict({**sample_joint.SCENE, "background_damping": 5e-4}, folder)
amplitudes = {"amplitude_from": 1e-6, "amplitude_to": 60e-6, "amplitudes": 20}
run = microslip.run(scene.replace({"analyses.backbone": amplitudes}))

# %% [markdown]
# ## The measurement
# Here it is made: two hits of a joint that is 0.4 % softer than theory and has a fifth more damping, with noise of the sensor. The files
# are columns of text; universal files, MATLAB, NumPy and WAV are read as well.

# %%
fs, samples = 20480.0, 20480
over = run.response_motion * (2 * np.pi * run.frequency_first_harmonic_hz) ** 2
softer = 0.996 * run.frequency_first_harmonic_hz
# Where friction is too small to be told, theory has no number; there is the background alone.
damped = 1.2 * np.nan_to_num(run.damping_ratio_first_harmonic, nan=5e-4)
for number, strength in ((1, 2.0), (2, 1.5)):
    signal = microslip.synthetic_ring_down(
        strength * over[-1], softer, damped, over=over, fs=fs, samples=samples, phase=0.5, noise=3.0, seed=number
    )
    table = np.column_stack([np.arange(samples) / fs, signal])
    np.savetxt(folder / f"hit{number}.csv", table, fmt="%.9f,%.3f", header="time [s],tip:+Z [m/s^2]", comments="")

# %%
import matplotlib.pyplot as plt

channel = microslip.read_record(folder / "hit1.csv").channels[0]
signal_picture, axes = plt.subplots(figsize=(6.4, 2.6), layout="constrained")
axes.plot(channel.times, channel.samples, linewidth=0.4)
axes.set_xlabel("time (s)")
axes.set_ylabel(f"{channel.name} ({channel.unit})")

# %% [markdown]
# ## The backbone of the measurement

# %%
measured = microslip.identify([folder / "hit1.csv", folder / "hit2.csv"], bandwidth=300.0, noise_margin=300.0)
print(measured, measured.warnings)
backbone_picture = measured.plot()
backbone_picture

# %% [markdown]
# ## Theory over it
# The misfit is theory minus experiment, over amplitudes equally spaced in their logarithm.

# %%
comparison = microslip.compare(run, measured)
misfit = comparison.misfits[0]
print(comparison.to_pandas().T)
figure = comparison.plot()
figure

# %%
assert abs(misfit.frequency_percent.mean - 100 * (1 / 0.996 - 1)) < 0.1
assert abs(misfit.damping_ln.mean - np.log(1 / 1.2)) < 0.1
