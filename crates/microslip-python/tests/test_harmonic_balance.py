"""The independent harmonic balance of the examples against `microslip.epmc`."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

import microslip

pytest.importorskip("scipy")

EXAMPLE = Path(__file__).parents[1] / "examples" / "harmonic_balance.py"


def example():
    spec = importlib.util.spec_from_file_location("harmonic_balance", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("harmonics", "samples"), [(1, 64), (3, 64), (5, 96)])
def test_an_independent_harmonic_balance_finds_the_same_motions(harmonics, samples):
    own = example()
    structure = own.two_masses()
    amplitudes = np.geomspace(1e-7, 5e-6, 8)
    balance = own.HarmonicBalance(structure, harmonics, samples)
    frequency, damping = balance.backbone(amplitudes)
    found = microslip.epmc(
        structure.stiffness,
        structure.mass,
        microslip.Interface(structure.jump, structure.areas, structure.law),
        amplitudes,
        load=structure.load,
        # The sign of the mode tells where a period begins.
        response=[1.0, 0.0, 0.0, 0.0],
        harmonics=harmonics,
        samples=samples,
        tolerance=1e-11,
        static_tolerance=1e-11,
    )
    assert found.converged.all()
    assert found.modes.frequency_hz == pytest.approx(np.sqrt(balance.eigenvalues) / (2 * np.pi), rel=1e-10)
    # The friction matters: the frequency falls by eight per cent.
    assert frequency[-1] < 0.93 * frequency[0] and damping.max() > 0.02
    # The same equations with the same samples, so the same numbers but for round-off.
    assert frequency == pytest.approx(found.frequency_hz, rel=1e-9)
    assert damping == pytest.approx(found.damping_ratio, rel=1e-7, abs=1e-12)


def test_the_jacobian_of_the_example_is_the_derivative_of_its_residual():
    own = example()
    balance = own.HarmonicBalance(own.two_masses(), 2, 32)
    rng = np.random.default_rng(4)
    unknown = np.zeros((4, 5))
    unknown[:, 1] = balance.shapes[:, 0]
    unknown = np.concatenate([(unknown + 0.01 * rng.normal(size=unknown.shape)).ravel(), [0.95, 0.02]])
    matrix = balance.jacobian(unknown, 1e-6, 0)
    along = rng.normal(size=unknown.size)
    step = 1e-8
    slope = (balance.residual(unknown + step * along, 1e-6, 0) - balance.residual(unknown - step * along, 1e-6, 0)) / (2 * step)
    assert matrix @ along == pytest.approx(slope, abs=1e-5 * np.abs(slope).max())
