"""Laws against closed forms, and what arrays go in and out."""

from __future__ import annotations

import math
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import microslip
from microslip import laws

E, NU = 200e9, 0.3
COMPOSITE = E / (2 * (1 - NU**2))
MINDLIN = 2 * E / ((2 - NU) * (1 + NU))


def asperities(**changes):
    given = dict(
        gaps=[0.0, 8e-6, 14e-6, 28e-6],
        probabilities=[0.0, 0.1, 0.5, 1.0],
        asperity_density=1.4e6,
        beta_x=1.4e-3,
        youngs_modulus=E,
        poisson_ratio=NU,
    )
    return laws.AsperitySumCurves(**(given | changes))


def greenwood(heights="exponential", **changes):
    given = dict(
        scale=1e-6, reference_height=5e-6, asperity_density=1e8, beta_x=1e-4, youngs_modulus=E, poisson_ratio=NU
    )
    return laws.GreenwoodWilliamsonCurves(heights=heights, **(given | changes))


def fitted():
    return laws.FittedCurves(
        normal=(13.0, 2.2, 0.4, 0.5, 1.2), tangential_x=(28.0, 1.5, 0.3, 0.6), u_ref=1e-6, ranges=(1e-7, 1e-5)
    )


def resolved(**changes):
    given = dict(
        gaps=np.linspace(0, 4e-6, 9),
        densities=np.full(9, 2e6),
        radius=1e-3,
        youngs_modulus=E,
        poisson_ratio=NU,
        mu=0.2,
        n_points=5,
    )
    return laws.ResolvedLaw(**(given | changes))


def every_law():
    elastic = laws.ElasticCurves(k_n=2e12, k_x=1.5e12, k_y=1.2e12)
    table = laws.TabulatedCurves(asperities(), range=(1e-8, 1e-4))
    curves = [elastic, fitted(), asperities(), greenwood(), greenwood("gaussian"), table]
    for history in ("incremental", "paper", "end-point", "potential"):
        for cone in ("circle", "box"):
            for own in curves:
                yield laws.FrictionalLaw(own, 0.2, history=history, cone=cone, n_points=5)
    for own in (elastic, asperities()):
        yield laws.FoundationLaw(own, 0.2, tangential_ratio=0.8, n_springs=6, reach=1e-5, n_points=5)
    yield resolved()
    yield resolved(annuli=8, cone="box")
    yield resolved(radii=20)
    for limit in ("coulomb", "ceb", "shear-strength"):
        yield resolved(yield_strength=350e6, tangent_modulus=2e9, slip_limit=limit)
    law = laws.FrictionalLaw(elastic, 0.3, n_points=5)
    static = np.vstack([np.zeros((2, 5)), [1e-6, 2e-6, 3e-6, 4e-6, -1e-6]])
    yield law.linearised(static, law.evaluate(static)[2])


LAWS = list(every_law())
NAMES = [f"{i}: {law.info.name} {law.arguments.get('history')} {law.arguments.get('cone')}" for i, law in enumerate(LAWS)]
every = pytest.mark.parametrize("law", LAWS, ids=NAMES)

#: A path that presses, shears and turns: five points at different pressures.
PRESSED = np.vstack([np.zeros((2, 5)), [0.4e-6, 1e-6, 2e-6, 3e-6, 4e-6]])
SHEARED = PRESSED + np.array([[3e-8], [-2e-8], [5e-8]])
TURNED = PRESSED + np.array([[-4e-8], [3e-8], [-3e-8]])


def test_a_bed_of_equal_asperities_is_hertz_and_mindlin():
    density, beta = 1e6, 1e-3
    law = laws.FrictionalLaw(asperities(gaps=[0.0], probabilities=None, asperity_density=density, beta_x=beta), 0.3, n_points=3)
    u = np.array([1e-7, 1e-6, 1e-5])
    traction, tangent, state = law.evaluate([np.zeros(3), np.zeros(3), u])
    assert traction[2] == pytest.approx(density * 4 / 3 * COMPOSITE * np.sqrt(beta) * u**1.5, rel=1e-13)
    assert tangent[2, 2] == pytest.approx(density * 2 * COMPOSITE * np.sqrt(beta * u), rel=1e-13)
    # Sheared by little at constant interference: Mindlin's stiffness, proportional to the contact radius.
    shear = 1e-3 * u
    traction, tangent, _ = law.evaluate([shear, np.zeros(3), u], state)
    stiffness = density * MINDLIN * np.sqrt(beta * u)
    assert tangent[0, 0] == pytest.approx(stiffness, rel=1e-13)
    assert traction[0] == pytest.approx(stiffness * shear, rel=1e-13)


def test_constant_stiffness_sticks_and_slips():
    k_n, k_x, k_y, mu = 2e12, 1.5e12, 1e12, 0.3
    law = laws.FrictionalLaw(laws.ElasticCurves(k_n=k_n, k_x=k_x, k_y=k_y), mu)
    u_n = 1e-6
    limit = mu * k_n * u_n
    state = law.evaluate([[0.0], [0.0], [u_n]])[2]
    area = 0.0
    before = (0.0, 0.0)
    amplitude = 1e-6
    # The closed loop between two reversals dissipates 4 limit (amplitude - limit / k_x).
    path = np.concatenate([np.linspace(0, 1, 101)[1:], np.linspace(1, -1, 201)[1:], np.linspace(-1, 1, 201)[1:]]) * amplitude
    for step, x in enumerate(path):
        traction, tangent, state = law.evaluate([[x], [0.0], [u_n]], state)
        assert abs(traction[0, 0]) <= limit * (1 + 1e-12)
        if step >= 100:
            area += 0.5 * (traction[0, 0] + before[1]) * (x - before[0])
        before = (x, traction[0, 0])
    assert area == pytest.approx(4 * limit * (amplitude - limit / k_x), rel=1e-12)
    # In full slip the tangential stiffness is gone, and the limit follows the pressure.
    assert tangent[0, 0, 0] == pytest.approx(0.0, abs=1e-6 * k_x)
    assert tangent[0, 2, 0] == pytest.approx(mu * k_n, rel=1e-12)
    assert law.regimes([[2 * amplitude], [0.0], [u_n]], state)[0] == 1


def test_exponential_heights_have_the_closed_form_of_greenwood_and_williamson():
    scale, height, density, beta = 1e-6, 5e-6, 1e8, 1e-4
    law = laws.FrictionalLaw(greenwood(), 0.2, n_points=4)
    u = np.array([0.5e-6, 1e-6, 2e-6, 4e-6])
    pressure = law.evaluate([np.zeros(4), np.zeros(4), u])[0][2]
    factor = density * 4 / 3 * COMPOSITE * math.sqrt(beta) * math.gamma(2.5) * scale**1.5
    assert pressure == pytest.approx(factor * np.exp(-(height - u) / scale), rel=1e-12)


def test_tables_and_the_sums_behind_them_agree():
    source = asperities()
    table = laws.TabulatedCurves(source, range=(1e-8, 1e-4))
    u = np.geomspace(1e-7, 5e-5, 50)
    zero = np.zeros_like(u)
    exact, found = (
        laws.FrictionalLaw(curves, 0.2, n_points=u.size).evaluate([zero, zero, u])[0][2] for curves in (source, table)
    )
    assert found == pytest.approx(exact, rel=1e-5)
    assert 0 < table.errors[0] <= 1e-5 and 0 < table.errors[1] <= 1e-4


@every
def test_the_tangent_is_the_derivative(law):
    state = law.evaluate(PRESSED)[2]
    state = law.evaluate(SHEARED, state)[2]
    _, tangent, _ = law.evaluate(TURNED, state)
    scale = np.abs(tangent).max(axis=(0, 1))
    for j in range(3):
        # Steps that stay away from kinks, and above round-off.
        step = np.zeros((3, 1))
        step[j] = 2e-13
        up, down = (law.evaluate(TURNED + sign * step, state, tangent=False)[0] for sign in (1, -1))
        slope = (up - down) / 4e-13
        assert np.all(np.abs(slope - tangent[:, j]) <= 2e-4 * scale), (j, slope - tangent[:, j], scale)


@every
def test_the_derivative_along_a_direction_is_that_of_two_steps(law):
    rng = np.random.default_rng(3)
    rest = law.evaluate(PRESSED)[2]
    d_first, d_second = rng.normal(size=(2, 3, 5))
    traction, middle, d_traction, d_middle = law.derivative(SHEARED, rest, d_first, np.zeros_like(rest))
    assert np.array_equal(traction, law.evaluate(SHEARED, rest)[0])
    tangent = law.evaluate(SHEARED, rest)[1]
    scale = np.abs(tangent).max()
    assert np.allclose(d_traction, np.einsum("ijp,jp->ip", tangent, d_first), atol=1e-9 * scale)
    _, _, d_traction, _ = law.derivative(TURNED, middle, d_second, d_middle)
    h = 2e-13

    def end(sign):
        state = law.evaluate(SHEARED + sign * h * d_first, rest)[2]
        return law.evaluate(TURNED + sign * h * d_second, state)[0]

    assert np.allclose(d_traction, (end(1) - end(-1)) / (2 * h), atol=1e-3 * scale)


@every
def test_evaluation_is_pure(law):
    state = law.evaluate(PRESSED)[2]
    kept = state.copy()
    first = law.evaluate(SHEARED, state)
    law.evaluate(TURNED, state)
    again = law.evaluate(SHEARED, state)
    assert np.array_equal(state, kept)
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))


@every
def test_laws_are_pickled_by_their_arguments(law):
    copy = pickle.loads(pickle.dumps(law))
    assert copy == law and repr(copy) == repr(law) and hash(copy) == hash(law)
    assert copy.info == law.info
    state = law.evaluate(PRESSED)[2]
    assert all(np.array_equal(a, b) for a, b in zip(law.evaluate(SHEARED, state), copy.evaluate(SHEARED, state), strict=True))


@every
def test_info_names_the_state(law):
    info = law.info
    assert len(info.state) == law.n_state == law.initial_state().shape[0]
    assert len({quantity.name for quantity in info.state}) == law.n_state
    assert all(quantity.unit for quantity in info.state + info.parameters)
    assert info.name and info.reference
    assert type(law).__name__ in repr(law)


def test_arrays_are_written_without_a_copy():
    law = laws.FrictionalLaw(laws.ElasticCurves(k_n=2e12, k_x=1.5e12), 0.3, n_points=5)
    expected = law.evaluate(SHEARED)
    out = (np.empty((3, 5)), np.empty((3, 3, 5)), np.empty((5, 5)))
    found = law.evaluate(SHEARED, out=out)
    assert all(a is b for a, b in zip(found, out, strict=True))
    assert all(np.array_equal(a, b) for a, b in zip(found, expected, strict=True))
    none = law.evaluate(SHEARED, tangent=False, out=(out[0], None, out[2]))
    assert none[1] is None


def test_arrays_of_other_kinds_are_understood():
    law = laws.FrictionalLaw(laws.ElasticCurves(k_n=2e12, k_x=1.5e12), 0.3, n_points=5)
    expected = law.evaluate(SHEARED)[0]
    for other in (SHEARED.tolist(), np.asfortranarray(SHEARED), np.ascontiguousarray(SHEARED.T).T, SHEARED[:, ::1]):
        assert np.array_equal(law.evaluate(other)[0], expected)
    single = law.evaluate(SHEARED.astype(np.float32))[0]
    assert single == pytest.approx(expected, rel=1e-5)


def test_parameters_are_broadcast_to_points():
    one = laws.FrictionalLaw(laws.ElasticCurves(k_n=2e12, k_x=1e12), 0.3)
    assert one.n_points == 1
    each = laws.FrictionalLaw(laws.ElasticCurves(k_n=[1e12, 2e12, 3e12], k_x=1e12), [0.1, 0.2, 0.3])
    assert each.n_points == 3
    zero = np.zeros(3)
    assert each.evaluate([zero, zero, np.full(3, 1e-6)])[0][2] == pytest.approx([1e6, 2e6, 3e6])
    shared = laws.FrictionalLaw(laws.ElasticCurves(k_n=[1e12, 2e12], k_x=1e12), 0.3, index=[1, 0, 1])
    assert shared.evaluate([zero, zero, np.full(3, 1e-6)])[0][2] == pytest.approx([2e6, 1e6, 2e6])


def test_sticking_is_chosen():
    law = laws.FrictionalLaw(laws.ElasticCurves(k_n=2e12, k_x=1e12), 0.3)
    jump, state = [[1e-4], [0.0], [1e-6]], law.evaluate([[0.0], [0.0], [1e-6]])[2]
    tangential = {how: law.evaluate(jump, state, sticking=how)[0][0, 0] for how in ("coulomb", "full", "frictionless")}
    assert tangential == pytest.approx({"coulomb": 0.3 * 2e6, "full": 1e8, "frictionless": 0.0})


def test_input_that_is_not_finite_spoils_its_point_alone():
    law = laws.FrictionalLaw(laws.ElasticCurves(k_n=2e12, k_x=1e12), 0.3, n_points=5)
    jump = SHEARED.copy()
    jump[0, 2] = np.nan
    traction, _, _ = law.evaluate(jump)
    assert np.array_equal(np.isnan(traction[0]), [False, False, True, False, False])
    assert law.regimes(jump)[2] == 3


def test_threads_find_the_same_bits():
    law = laws.FoundationLaw(asperities(), 0.2, tangential_ratio=0.8, n_springs=8, reach=1e-5, n_points=2000)
    jump = np.abs(np.random.default_rng(5).normal(scale=2e-6, size=(3, 2000)))
    expected = law.evaluate(jump)
    with ThreadPoolExecutor(4) as pool:
        for found in pool.map(lambda _: law.evaluate(jump), range(16)):
            assert all(np.array_equal(a, b) for a, b in zip(found, expected, strict=True))


ELASTIC = laws.ElasticCurves(k_n=2e12, k_x=1e12)
LAW = laws.FrictionalLaw(ELASTIC, 0.3, n_points=5)


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda: laws.ElasticCurves(k_n=-1.0, k_x=1.0), ["k_n", "-1"]),
        (lambda: laws.ElasticCurves(k_n=[1.0, np.nan], k_x=1.0), ["k_n", "NaN", "index 1"]),
        (lambda: laws.ElasticCurves(k_n=[1.0, 2.0], k_x=[1.0, 2.0, 3.0]), ["k_x has 3", "k_n has 2"]),
        (lambda: laws.ElasticCurves(k_n=[[1.0]], k_x=1.0), ["k_n", "(1, 1)"]),
        (lambda: laws.ElasticCurves(k_n=[], k_x=1.0), ["k_n"]),
        (lambda: laws.ElasticCurves(k_n="stiff", k_x=1.0), ["k_n", "numbers"]),
        (lambda: laws.FrictionalLaw(ELASTIC, -0.1), ["mu", "-1e-1"]),
        (lambda: laws.FrictionalLaw(ELASTIC, 0.1, history="masing"), ["history", "masing", "incremental"]),
        (lambda: laws.FrictionalLaw(ELASTIC, 0.1, cone="square"), ["cone", "square", "circle"]),
        (lambda: laws.FrictionalLaw(ELASTIC, [0.1, 0.2], n_points=3), ["mu", "2", "n_points", "3"]),
        (lambda: laws.FrictionalLaw(ELASTIC, 0.1, n_points=0), ["0 points"]),
        (lambda: laws.FrictionalLaw(ELASTIC, 0.1, index=[0, 1]), ["1", "0..1"]),
        (lambda: laws.FrictionalLaw(ELASTIC, 0.1, index=[-1]), ["index", "-1"]),
        (lambda: laws.FrictionalLaw(ELASTIC, 0.1, index=[0.5]), ["index", "float64"]),
        (lambda: laws.FrictionalLaw("elastic", 0.1), ["curves", "elastic"]),
        (lambda: laws.FoundationLaw(ELASTIC, 0.1, tangential_ratio=0.8, n_springs=0, reach=1e-5), ["bins"]),
        (lambda: laws.TabulatedCurves(asperities(), range=(1e-4, 1e-8)), ["range"]),
        (lambda: laws.TabulatedCurves(laws.TabulatedCurves(ELASTIC, range=(1e-8, 1e-4)), range=(1e-8, 1e-4)), ["table"]),
        (lambda: laws.SampledCurves(interferences=[0, 1], tractions=[0, 1], areas=[0, 0], tangential_ratio=0.8), ["interferences", "3"]),
        (lambda: laws.SampledCurves(interferences=[0, 1, 2], tractions=[0, 2, 1], areas=[0, 0, 0], tangential_ratio=0.8), ["tractions"]),
        (lambda: asperities(poisson_ratio=0.7), ["poisson_ratio", "7e-1"]),
        (lambda: greenwood("uniform"), ["heights", "uniform", "gaussian"]),
        (lambda: laws.FittedCurves(normal=(1.0,) * 4, tangential_x=(1.0,) * 4, u_ref=1e-6), ["normal", "4", "5"]),
        (lambda: resolved(annuli=4, radii=4), ["annuli", "radii"]),
        (lambda: resolved(slip_limit="ceb"), ["yield strength"]),
        (lambda: resolved(densities=np.ones(3)), ["densities", "(3, 1)", "(9, 1)"]),
        (lambda: resolved(yield_strength=350e6, history="potential"), ["potential"]),
        (lambda: LAW.evaluate(np.zeros((5, 3))), ["jump", "(5, 3)", "(3, 5)"]),
        (lambda: LAW.evaluate(np.zeros(3)), ["jump"]),
        (lambda: LAW.evaluate(np.zeros((3, 5)), np.zeros((4, 5))), ["state", "(4, 5)", "(5, 5)"]),
        (lambda: LAW.evaluate(np.zeros((3, 5)), sticking="glued"), ["sticking", "glued"]),
        (lambda: LAW.evaluate(np.zeros((3, 5)), out=(np.empty((3, 5)), None, np.empty((5, 5)))), ["out", "tangent"]),
        (
            lambda: LAW.evaluate(np.zeros((3, 5)), tangent=False, out=(np.empty((5, 3)).T, None, np.empty((5, 5)))),
            ["traction", "contiguous"],
        ),
        (
            lambda: LAW.evaluate(np.zeros((3, 5)), tangent=False, out=(np.empty((3, 5), np.float32), None, np.empty((5, 5)))),
            ["traction", "float64"],
        ),
    ],
)
def test_refusals_name_the_argument(act, words):
    with pytest.raises(microslip.InputError) as refused:
        act()
    assert isinstance(refused.value, ValueError) and isinstance(refused.value, microslip.Error)
    assert all(word in str(refused.value) for word in words), str(refused.value)


def test_output_that_overlaps_input_is_refused():
    state = LAW.initial_state()
    with pytest.raises(microslip.InputError, match="memory"):
        LAW.evaluate(SHEARED, state, tangent=False, out=(np.empty((3, 5)), None, state))
    assert not state.any()


def test_parameters_cannot_be_changed_from_outside():
    stiffness = np.array([1e12, 2e12])
    curves = laws.ElasticCurves(k_n=stiffness, k_x=1e12)
    stiffness[0] = 5.0
    assert curves.arguments["k_n"][0] == 1e12
    with pytest.raises(ValueError):
        curves.arguments["k_n"][0] = 5.0
