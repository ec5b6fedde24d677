"""Analyses of matrices against closed forms, other codes and one another."""

from __future__ import annotations

import pickle
import signal
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest

import microslip
from microslip import laws

pytest.importorskip("scipy")

import scipy.linalg  # noqa: E402
import scipy.sparse  # noqa: E402

TAU = 2 * np.pi


def jenkins(elements, n, *, exact=False):
    """Sliders (coordinate, stiffness in N/m, limit in N) to the ground along x, at constant pressure."""
    coordinates, stiffness, limit = (np.array(column) for column in zip(*elements, strict=True))
    points = len(coordinates)
    jump = np.zeros((3 * points, n))
    jump[3 * np.arange(points), coordinates.astype(int)] = 1.0
    if exact:
        zero = np.zeros((3, points))
        law = laws.LinearisedContact(
            jump=zero, traction=zero, stiffness=[stiffness, stiffness, 0 * stiffness], slip_limit=limit
        )
        return microslip.Interface(jump, areas=1.0, law=law)
    # t_n = k_n * interference and mu = 1: the limit is k_n times 1 um.
    curves = laws.ElasticCurves(k_n=limit / 1e-6, k_x=stiffness)
    law = laws.FrictionalLaw(curves, 1.0, n_points=points)
    return microslip.Interface(jump, areas=1.0, law=law, interference=1e-6)


def chain(n, spring=2000.0):
    """Masses of 1 kg in a chain, the last one held."""
    stiffness = spring * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    stiffness[-1, -1] = spring
    return stiffness, np.eye(n)


@pytest.mark.parametrize("exact", [False, True])
def test_cqsma_of_one_jenkins_element_follows_its_closed_form(exact):
    spring, k, limit, m = 1000.0, 500.0, 2.0, 3.0
    peaks = np.array([1.0, 5.9, 6.1, 12.0, 100.0, 1e4])
    stuck = np.sqrt((spring + k) / m)
    found = microslip.cqsma(
        [[spring]], [[m]], jenkins([(0, k, limit)], 1, exact=exact), peaks / np.sqrt(m) / stuck**2, response=[1.0]
    )
    assert found.converged.all() and found.static.converged and found.modes.frequency_hz == pytest.approx([stuck / TAU])
    for i, peak in enumerate(peaks):
        stick = peak <= limit * (spring + k) / k
        x = peak / (spring + k) if stick else (peak - limit) / spring
        area = 0.0 if stick else 4 * limit * (x - limit / k)
        assert found.modal_force[i] == pytest.approx(peak / np.sqrt(m), rel=1e-12)
        assert found.modal_amplitude[i] == pytest.approx(x * np.sqrt(m), rel=1e-8)
        assert found.response_amplitude[i] == pytest.approx(x, rel=1e-8)
        assert found.frequency_hz[i] == pytest.approx(np.sqrt(peak / (m * x)) / TAU, rel=1e-8)
        # The corner of the loop falls between vertices.
        assert abs(found.dissipation[i] - area) <= 0.5 * (peak / 4) ** 2 / spring + 1e-9 * peak * x
        assert found.damping_ratio[i] == pytest.approx(found.dissipation[i] / (TAU * peak * x), abs=1e-9)
        q, force = found.loops[i]
        assert q.max() - q.min() == pytest.approx(2 * found.modal_amplitude[i]) and force.max() == found.modal_force[i]
    assert np.array_equal(found.n_slip > 0, peaks > limit * (spring + k) / k)


def describing_function(k, u_y, amplitude):
    """First harmonic of a Jenkins element over an amplitude: in phase, and lagging [N/m]."""
    if amplitude <= u_y:
        return k, 0.0
    theta = np.arccos(1 - 2 * u_y / amplitude)
    return k / np.pi * (theta - 0.5 * np.sin(2 * theta)), 4 * k * u_y * (amplitude - u_y) / (np.pi * amplitude**2)


def test_epmc_with_one_harmonic_of_a_jenkins_element_is_its_describing_function():
    k, k_t, u_y, m = 1e4, 4e3, 1e-3, 2.0
    displacement = np.array([0.5e-3, 0.999e-3, 1.5e-3, 3e-3, 1e-2, 0.1])
    found = microslip.epmc(
        [[k]],
        [[m]],
        jenkins([(0, k_t, k_t * u_y)], 1),
        displacement * np.sqrt(m),
        response=[1.0],
        harmonics=1,
        samples=1 << 14,
        tolerance=1e-11,
    )
    assert found.converged.all()
    assert found.response_amplitude == pytest.approx(displacement, rel=1e-9)
    for i, u in enumerate(displacement):
        in_phase, loss = describing_function(k_t, u_y, u)
        square = (k + in_phase) / m
        assert found.frequency_hz[i] == pytest.approx(np.sqrt(square) / TAU, rel=1e-6)
        assert abs(found.damping_ratio[i] - 0.5 * loss / (m * square)) < 1e-6 * max(0.5 * loss / (m * square), 1e-3)
        assert found.dissipation[i] == pytest.approx(4 * k_t * u_y * max(u - u_y, 0.0), rel=1e-6, abs=1e-15)
    assert found.jump.shape == (6, 3, 1, 3) and found.response.shape == (6, 3)
    assert np.array_equal(found.jump[:, 0, 0], found.response)
    assert (found.energy_error < 1e-10).all() and (found.drift < 1e-9).all() and (found.residual < 1e-9).all()


def test_small_amplitudes_are_those_of_the_linear_structure():
    stiffness, mass = chain(12)
    sliders = [(i, 400.0, 1.0) for i in range(0, 12, 2)]
    stuck = stiffness.copy()
    stuck[range(0, 12, 2), range(0, 12, 2)] += 400.0
    squares, shapes = scipy.linalg.eigh(stuck, mass)
    interface = jenkins(sliders, 12)
    response = np.eye(12)[3]
    for mode in (0, 2):
        small = 1e-4 / np.sqrt(squares[mode])
        loops = microslip.cqsma(stiffness, mass, interface, small, mode=mode, response=response, n_linear_modes=12)
        periodic = microslip.epmc(stiffness, mass, interface, small, mode=mode, response=response)
        assert loops.modes.frequency_hz == pytest.approx(np.sqrt(squares) / TAU, rel=1e-10)
        assert loops.modes.shapes[0] == pytest.approx(np.abs(shapes[3]), rel=1e-7)
        for found in (loops, periodic):
            assert found.frequency_hz == pytest.approx(np.sqrt(squares[[mode]]) / TAU, rel=1e-9)
            assert abs(found.damping_ratio[0]) < 1e-8
            assert found.response_amplitude == pytest.approx(small * np.abs(shapes[3, [mode]]), rel=1e-6)


def test_a_static_load_is_carried_before_the_structure_vibrates():
    stiffness, mass = chain(12)
    load = np.zeros(12)
    load[11] = 2.0
    found = microslip.cqsma(stiffness, mass, jenkins([(i, 400.0, 1.0) for i in range(12)], 12), 1e-5, load=load)
    u = np.linalg.solve(stiffness + 400.0 * np.eye(12), load)
    assert np.abs(400.0 * u).max() < 1.0
    assert found.static.jump[0] == pytest.approx(u, rel=1e-7)
    assert found.static.traction[0] == pytest.approx(400.0 * u, rel=1e-7)
    assert (found.static.regime == 0).all() and found.static.residual < 1e-9


def two_bars(n=30):
    """Two bars side by side, along x and n, that touch at four points; pairs of coordinates and their jump."""
    one = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    axial, lateral = 1e7 * one, 4e6 * one
    body = scipy.sparse.block_diag([axial, lateral])
    stiffness = scipy.sparse.block_diag([body, 1.3 * body]).tocsr()
    mass = scipy.sparse.diags(np.repeat([0.05, 0.04], 2 * n)).tocsr()
    rows, columns, signs = [], [], []
    for point, node in enumerate(np.linspace(2, n - 2, 4).astype(int)):
        for component, place in ((0, node), (2, n + node)):
            rows += [3 * point + component] * 2
            columns += [place, 2 * n + place]
            signs += [1.0, -1.0]
    jump = scipy.sparse.csr_array((signs, (rows, columns)), shape=(12, 4 * n))
    return stiffness, mass, jump


def rough(n_points):
    curves = laws.AsperitySumCurves(
        gaps=[0.0, 2e-6, 5e-6, 9e-6],
        probabilities=[0.0, 0.2, 0.7, 1.0],
        asperity_density=4e6,
        beta_x=2e-4,
        youngs_modulus=200e9,
        poisson_ratio=0.3,
    )
    return laws.FrictionalLaw(curves, 0.3, n_points=n_points)


def pressed(jump, force):
    """Load that presses the bodies together at every point, with equal and opposite forces."""
    along = np.zeros(jump.shape[0])
    along[2::3] = force
    return jump.T @ along


def test_reduction_keeps_the_lowest_modes():
    stiffness, mass, jump = two_bars()
    springs = np.tile([3e7, 0.0, 5e7], 4)
    full = (stiffness + jump.T @ scipy.sparse.diags(springs) @ jump).toarray()
    expected = np.sqrt(scipy.linalg.eigh(full, mass.toarray(), eigvals_only=True)) / TAU
    interface = microslip.Interface(jump, areas=1e-4, law=rough(4))
    for n_modes, tolerance in ((20, 1e-3), (60, 1e-6), (112, 1e-9)):
        model = microslip.reduce(stiffness, mass, interface, n_modes=n_modes, loads=pressed(jump, 100.0))
        own = model.interface.jump
        assert model.stiffness.shape == (8 + n_modes,) * 2 and own.shape == (12, 8 + n_modes)
        reduced = model.stiffness + own.T @ np.diag(springs) @ own
        found = np.sqrt(scipy.linalg.eigh(reduced, model.mass, eigvals_only=True)) / TAU
        assert found[:6] == pytest.approx(expected[:6], rel=tolerance)
        # A reduced structure is never softer.
        assert (found[:6] >= expected[:6] * (1 - 1e-9)).all()
        assert model.n_modes == n_modes and model.zero_energy_modes == 0 and model.asymmetry < 1e-6
    # Forces on the jump act on the leading coordinates alone.
    assert model.loads[0][[1, 3, 5, 7]] == pytest.approx(np.full(4, 100.0))


def test_a_reduced_structure_has_the_backbone_of_the_whole():
    stiffness, mass, jump = two_bars()
    interface = microslip.Interface(jump, areas=1e-4, law=rough(4))
    load, response = pressed(jump, 150.0), np.eye(120)[14]
    amplitudes = np.geomspace(1e-6, 1e-3, 6)
    whole = microslip.cqsma(stiffness, mass, interface, amplitudes, load=load, response=response, mode=1)
    model = microslip.reduce(stiffness, mass, interface, n_modes=60, loads=load, recover=response)
    small = microslip.cqsma(
        model.stiffness,
        model.mass,
        model.interface,
        amplitudes,
        load=model.loads[0],
        response=model.recovery[0],
        mode=1,
    )
    assert whole.converged.all() and small.converged.all()
    assert whole.frequency_hz[-1] < 0.99 * whole.frequency_hz[0] and whole.n_slip[-1] == 4
    assert small.frequency_hz == pytest.approx(whole.frequency_hz, rel=1e-5)
    assert small.damping_ratio[-1] == pytest.approx(whole.damping_ratio[-1], rel=1e-3)
    assert small.response_amplitude == pytest.approx(whole.response_amplitude, rel=1e-3)
    assert small.static.traction[2] == pytest.approx(whole.static.traction[2], rel=1e-6)


def test_matrices_of_all_kinds_give_the_same_bits():
    stiffness, mass, jump = two_bars()
    load = pressed(jump, 150.0)

    def run(kind, threads):
        interface = microslip.Interface(kind(jump), areas=1e-4, law=rough(4))
        return microslip.cqsma(kind(stiffness), kind(mass), interface, [1e-7, 1e-6], load=load, threads=threads)

    first = run(scipy.sparse.csr_matrix, 1)
    for kind in (scipy.sparse.csc_array, scipy.sparse.coo_matrix, lambda a: a.toarray()):
        again = run(kind, 2)
        assert np.array_equal(again.frequency_hz, first.frequency_hz)
        assert np.array_equal(again.damping_ratio, first.damping_ratio)


def test_a_jump_by_combinations_is_that_by_pairs():
    n = 8
    stiffness, mass, _ = two_bars(n)
    rows, columns, signs = [], [], []
    for row, place in enumerate((2, 4, n + 2)):
        rows += [row] * 2
        columns += [place, 2 * n + place]
        signs += [1.0, -1.0]
    jump = scipy.sparse.csr_array((signs, (rows, columns)), shape=(3, 4 * n))
    law, load = rough(1), pressed(jump, 200.0)
    pairs = microslip.cqsma(stiffness, mass, microslip.Interface(jump, 1e-4, law), 1e-7, load=load)
    # The same coordinates, turned: rows are combinations now.
    turn = scipy.linalg.qr(np.random.default_rng(2).normal(size=(4 * n, 4 * n)))[0]
    turned = microslip.cqsma(
        turn.T @ stiffness @ turn,
        turn.T @ mass @ turn,
        microslip.Interface(jump @ turn, 1e-4, law),
        1e-7,
        load=turn.T @ load,
    )
    assert turned.frequency_hz == pytest.approx(pairs.frequency_hz, rel=1e-8)
    assert turned.static.traction == pytest.approx(pairs.static.traction, rel=1e-6, abs=1e-3)


def test_one_coordinate_may_face_several():
    # Two masses over the same support, once by pairs and once by the displacements relative to it.
    stiffness = np.diag([2e6, 1e6, 3e6, 2e6, 5e6, 4e6]) - 1e5 * (np.eye(6, k=2) + np.eye(6, k=-2))
    mass = np.diag([1.0, 1.0, 2.0, 2.0, 3.0, 3.0])
    jump = np.zeros((6, 6))
    for point in (0, 1):
        jump[3 * point, 2 * point], jump[3 * point, 4] = 1.0, -1.0
        jump[3 * point + 2, 2 * point + 1], jump[3 * point + 2, 5] = 1.0, -1.0
    change = np.eye(6)
    change[[0, 2], 4] = change[[1, 3], 5] = 1.0
    law, load, response = rough(2), pressed(jump, 100.0), np.eye(6)[2]
    amplitudes = [1e-7, 1e-5]
    pairs = microslip.cqsma(
        stiffness, mass, microslip.Interface(jump, 1e-4, law), amplitudes, load=load, response=response
    )
    relative = microslip.cqsma(
        change.T @ stiffness @ change,
        change.T @ mass @ change,
        microslip.Interface(jump @ change, 1e-4, law),
        amplitudes,
        load=change.T @ load,
        response=change.T @ response,
    )
    assert pairs.converged.all()
    assert relative.frequency_hz == pytest.approx(pairs.frequency_hz, rel=1e-9)
    assert relative.response_amplitude == pytest.approx(pairs.response_amplitude, rel=1e-9)
    assert relative.static.traction == pytest.approx(pairs.static.traction, rel=1e-7, abs=1e-2)


def test_free_bodies_need_their_rigid_motions():
    stiffness = 1e6 * np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    free = scipy.linalg.block_diag(stiffness, stiffness)
    jump = np.zeros((3, 6))
    jump[2, 0], jump[2, 3] = 1.0, -1.0
    interface = microslip.Interface(jump, 1e-4, rough(1))
    with pytest.raises(microslip.InputError, match=r"zero_energy_modes.*1 zero-energy modes, but 0 were expected"):
        microslip.cqsma(free, np.eye(6), interface, 1e-7, load=pressed(jump, 50.0))
    found = microslip.cqsma(free, np.eye(6), interface, 1e-7, load=pressed(jump, 50.0), zero_energy_modes=1)
    assert found.converged.all() and found.static.traction[2] * 1e-4 == pytest.approx([50.0])


def test_cqsma_and_epmc_agree_roughly():
    stiffness, mass = chain(6)
    interface = jenkins([(i, 400.0, 1.0) for i in range(6)], 6)
    loops = microslip.cqsma(stiffness, mass, interface, np.geomspace(1e-4, 0.05, 6), vertices_per_quarter=64)
    periodic = microslip.epmc(stiffness, mass, interface, loops.modal_amplitude, accuracy=(1e-5, 2e-2))
    assert loops.converged.all() and periodic.converged.all()
    assert loops.frequency_hz[-1] < 0.6 * loops.frequency_hz[0]
    assert periodic.frequency_hz == pytest.approx(loops.harmonic_frequency_hz, rel=1e-2)
    damping = loops.damping_ratio * (loops.frequency_hz / loops.harmonic_frequency_hz) ** 2
    assert periodic.damping_ratio == pytest.approx(damping, rel=0.05, abs=1e-9)
    # Sampling is refined where points slip.
    assert periodic.samples[0] == 128 and periodic.samples[-1] > 128
    assert periodic.harmonics[0] == 3 and periodic.harmonics[-1] > 3
    assert np.all(periodic.jump[0, ..., 7:] == 0.0)


def test_a_linear_ring_down_keeps_its_energy():
    spring, k, m = 1e4, 4e3, 2.0
    interface = jenkins([(0, k, 1e9)], 1, exact=True)
    found = microslip.transient(
        [[spring]], [[m]], interface, microslip.Release(1e-3), response=[1.0], periods=20, spectral_radius=1.0
    )
    assert found.converged and found.reason is None and found.time.size == 20 * 100 + 1
    assert found.energy_error < 1e-9
    omega = np.sqrt((spring + k) / m) * found.algorithmic_frequency_ratio
    assert found.displacement == pytest.approx(1e-3 / np.sqrt(m) * np.cos(omega * found.time), abs=1e-8)
    assert found.step == pytest.approx(TAU / np.sqrt((spring + k) / m) / 100)


def test_a_slider_decays_linearly_in_gross_slip():
    # With a stiff slider nearly Coulomb friction alone: the amplitude falls by 4 limit / k per period.
    spring, limit = 1e4, 0.05
    interface = jenkins([(0, 1e7, limit)], 1, exact=True)
    start = microslip.Pulse(impulse=1.0, duration=4e-3)
    found = microslip.transient(
        [[spring]], [[1.0]], interface, start, response=[1.0], periods=400, steps_per_period=20, spectral_radius=1.0
    )
    peaks = found.displacement[1:-1][
        (found.displacement[1:-1] > found.displacement[:-2]) & (found.displacement[1:-1] >= found.displacement[2:])
    ]
    peaks = peaks[peaks > 1e-4]
    assert len(peaks) > 10
    assert np.diff(peaks[:10]) == pytest.approx(np.full(9, -4 * limit / spring), rel=0.05)
    balance = found.kinetic_energy + found.elastic_energy + found.contact_work + found.viscous_work
    assert np.all(found.external_work[-1] > 0.4) and balance[-1] < found.external_work[-1] * (1 + 1e-6)


def test_few_modes_and_no_amplitudes_are_taken():
    stiffness, mass, jump = two_bars(12)
    interface = microslip.Interface(jump, 1e-4, rough(4))
    assert microslip.reduce(stiffness, mass, interface, n_modes=0).stiffness.shape == (8, 8)
    assert microslip.reduce(stiffness, mass, interface, n_modes=10_000).stiffness.shape == (48, 48)
    for analyse in (microslip.cqsma, microslip.epmc):
        none = analyse(stiffness, mass, interface, [], load=pressed(jump, 100.0))
        assert none.converged.shape == none.frequency_hz.shape == (0,) and none.modes.frequency_hz.size == 10


def test_what_does_not_converge_is_a_status():
    stiffness, mass, jump = two_bars(8)
    interface = microslip.Interface(jump[:3], 1e-4, rough(1))
    load = pressed(jump[:3], 300.0)
    no_static = microslip.cqsma(stiffness, mass, interface, [1e-8, 1e-7], load=load, response=np.eye(32)[0], max_iterations=0)
    assert not no_static.static.converged and no_static.static.reason
    assert np.isnan(no_static.static.traction).all() and np.isnan(no_static.frequency_hz).all()
    assert not no_static.converged.any() and no_static.reason == (no_static.static.reason,) * 2
    assert no_static.modes.frequency_hz.size == 0 and no_static.response_amplitude.shape == (2,)
    lost = microslip.epmc(stiffness, mass, interface, [1e-8, 1e-5], load=load, max_iterations=0)
    assert lost.static.converged and not lost.converged.any()
    assert np.isnan(lost.frequency_hz).all() and all(lost.reason) and np.isnan(lost.jump).all()


def test_results_and_interfaces_are_pickled():
    interface = microslip.Interface(two_bars(8)[2], 1e-4, rough(4))
    assert pickle.loads(pickle.dumps(interface)) == interface
    found = microslip.cqsma([[1e3]], [[1.0]], jenkins([(0, 500.0, 2.0)], 1), [1e-3, 1e-2])
    copy = pickle.loads(pickle.dumps(found))
    assert np.array_equal(copy.frequency_hz, found.frequency_hz) and copy.reason == found.reason
    with pytest.raises(AttributeError):
        found.mode = 3
    shown = repr(microslip.transient([[1e3]], [[1.0]], jenkins([(0, 500.0, 2.0)], 1), microslip.Release(1e-3), response=[1.0]))
    assert len(shown) < 1500 and "displacement=<array of shape (10001,)>" in shown and "converged=True" in shown


ONE = jenkins([(0, 500.0, 2.0)], 1)
K, M = chain(4)
FOUR = jenkins([(0, 500.0, 2.0)], 4)


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda: microslip.cqsma(K[:, :3], M, FOUR, 1e-3), ["stiffness", "(4, 3)", "square"]),
        (lambda: microslip.cqsma(K[0], M, FOUR, 1e-3), ["stiffness", "(4,)"]),
        (lambda: microslip.cqsma(K, M[:3, :3], FOUR, 1e-3), ["mass", "(3, 3)", "(4, 4)"]),
        (lambda: microslip.cqsma(K + np.eye(4, k=1), M, FOUR, 1e-3), ["stiffness", "not symmetric", "[0, 1]"]),
        (lambda: microslip.cqsma(K, M + 1e-3 * np.eye(4, k=1), FOUR, 1e-3), ["mass", "not symmetric"]),
        (lambda: microslip.cqsma(K - 4000 * np.eye(4), M, FOUR, 1e-3), ["stiffness", "indefinite"]),
        (lambda: microslip.cqsma(K, np.diag([1.0, 1.0, -1.0, 1.0]), FOUR, 1e-3), ["mass", "indefinite"]),
        (lambda: microslip.cqsma(K, 0 * M, FOUR, 1e-3), ["mass", "zero"]),
        (lambda: microslip.cqsma(np.where(K == -2000, np.nan, K), M, FOUR, 1e-3), ["stiffness[0, 1]", "finite"]),
        (lambda: microslip.cqsma(scipy.sparse.csr_array(np.where(K == 0, 0, np.inf)), M, FOUR, 1e-3), ["stiffness", "finite"]),
        (lambda: microslip.cqsma(K, M, ONE, 1e-3), ["jump", "(3, 1)", "(3, 4)"]),
        (lambda: microslip.cqsma(K, M, "interface", 1e-3), ["interface"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, load=[1.0]), ["load", "(1,)", "(4,)"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, load=[np.nan] * 4), ["load", "finite"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, response=np.eye(4)), ["response", "(4, 4)", "(4,)"]),
        (lambda: microslip.cqsma(K, M, FOUR, [-1e-3]), ["modal_amplitudes", "-0.001"]),
        (lambda: microslip.cqsma(K, M, FOUR, np.nan), ["modal_amplitudes", "NaN"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, mode=7), ["mode", "7", "4 modes"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, mode=-1), ["mode", "-1"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, vertices_per_quarter=0), ["vertices_per_quarter"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, commit="never"), ["commit", "never"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, threads=0), ["threads"]),
        (lambda: microslip.epmc(K, M, FOUR, [1e-3, 1e-4]), ["modal_amplitude", "larger"]),
        (lambda: microslip.epmc(K, M, FOUR, 1e-3, samples=4), ["samples"]),
        (lambda: microslip.epmc(K, M, FOUR, 1e-3, harmonics=2.5), ["harmonics", "2.5"]),
        (lambda: microslip.transient(K, M, FOUR, 1.0, response=M[0]), ["start"]),
        (lambda: microslip.transient(K, M, FOUR, microslip.Release(-1.0), response=M[0]), ["modal_force"]),
        (lambda: microslip.transient(K, M, FOUR, microslip.Release(1.0), response=M[0], steps_per_period=4), ["steps_per_period"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, vertices_per_quarter=10**9), ["vertices_per_quarter", "at most"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, cycles=1 << 70), ["cycles"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, tolerance=np.nan), ["tolerance", "NaN"]),
        (lambda: microslip.epmc(K, M, FOUR, 1e-3, static_tolerance=0.0), ["static_tolerance"]),
        (lambda: microslip.epmc(K, M, FOUR, 1e-3, accuracy=(np.nan, 1e-2)), ["accuracy", "NaN"]),
        (lambda: microslip.cqsma(K.astype(complex), M, FOUR, 1e-3), ["stiffness", "complex"]),
        (lambda: microslip.cqsma(scipy.sparse.csr_array(K.astype(complex)), M, FOUR, 1e-3), ["stiffness", "complex"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, closure=np.nan, load=np.ones(4)), ["closure"]),
        (lambda: microslip.cqsma(K, M, FOUR, 1e-3, until_closed=0.0), ["cycles.tolerance"]),
        (lambda: microslip.epmc(K, M, FOUR, 1e-3, max_samples=1 << 30), ["max_samples"]),
        (lambda: microslip.epmc(K, M, FOUR, 1e-3, accuracy=(1e-3,)), ["accuracy", "1 values"]),
        (
            lambda: microslip.transient(K, M, FOUR, microslip.Release(1.0), response=M[0], periods=1 << 31),
            ["periods", "at most"],
        ),
        (lambda: microslip.reduce(K, M, FOUR, loads=np.ones((2, 3))), ["loads", "(2, 3)"]),
        (lambda: microslip.Interface(np.eye(3), 1e-4, rough(2)), ["jump", "(3, 3)", "6 rows"]),
        (lambda: microslip.Interface(np.eye(3), 1e-4, "law"), ["law"]),
        (lambda: microslip.cqsma(K, M, microslip.Interface(np.zeros((3, 4)), 1.0, rough(1)), 1e-3), ["jump", "zero"]),
        (
            lambda: microslip.cqsma(K, M, microslip.Interface(np.eye(4)[[0, 0, 1]], 1.0, rough(1)), 1e-3),
            ["jump", "depend on one another"],
        ),
        (
            lambda: microslip.cqsma(K, M, microslip.Interface(np.ones((3, 4)), 1.0, rough(1)), 1e-3),
            ["jump", "depend on one another"],
        ),
        (lambda: microslip.cqsma(K, M, microslip.Interface(FOUR.jump, -1.0, rough(1)), 1e-3), ["area", "-1"]),
        (lambda: microslip.cqsma(K, M, microslip.Interface(FOUR.jump, 1.0, rough(1), gap=-1e-6), 1e-3), ["gap"]),
        (lambda: microslip.cqsma(K, M, microslip.Interface(FOUR.jump, [1.0, 2.0], rough(1)), 1e-3), ["areas", "(2,)"]),
    ],
)
def test_refusals_name_the_argument(act, words):
    with pytest.raises(microslip.InputError) as refused:
        act()
    assert all(word in str(refused.value) for word in words), str(refused.value)


def test_a_loose_structure_is_refused():
    stiffness = np.array([[1.0, -1.0], [-1.0, 1.0]]) * 1e3
    with pytest.raises(microslip.Error, match="zero-energy modes|move freely|not positive definite"):
        microslip.cqsma(stiffness, np.eye(2), jenkins([(0, 0.0, 2.0)], 2, exact=True), 1e-3)


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_ctrl_c_stops_an_analysis():
    code = textwrap.dedent(
        """
        import numpy as np, microslip, signal, sys
        sys.path.insert(0, {tests!r})
        import test_analyses as own
        # Of a process in the background, which ignores it.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        stiffness, mass, jump = own.two_bars(40)
        interface = microslip.Interface(jump, 1e-4, own.rough(4))
        print("begin", flush=True)
        try:
            microslip.transient(stiffness, mass, interface, microslip.Release(1e-6), response=np.eye(160)[0],
                                load=own.pressed(jump, 100.0), periods=100_000)
        except KeyboardInterrupt:
            print("stopped", flush=True)
        """
    ).format(tests=str(__import__("pathlib").Path(__file__).parent))
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begin\n"
    time.sleep(2.0)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert out == "stopped\n" and process.returncode == 0
