"""What a law costs from Python against the same evaluations in Rust: ``python tests/overhead_laws.py``.

Both evaluate 10 000 points with their tangents from the same state, in turns, so that what else the machine does hits both
alike. A number is the smallest time of a call; the overhead is that of Python over that of Rust.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from microslip import _native, laws

POINTS = 10_000
ROUNDS = 400
LARGEST = 0.05


def examples() -> dict[str, laws.Law]:
    fitted = laws.FittedCurves(
        normal=(13.0, 2.2, 0.4, 0.5, 1.2), tangential_x=(28.0, 1.5, 0.3, 0.6), u_ref=1e-6, ranges=(1e-7, 1e-5)
    )
    asperities = laws.AsperitySumCurves(
        gaps=[0.0, 8e-6, 14e-6, 28e-6],
        probabilities=[0.0, 0.1, 0.5, 1.0],
        asperity_density=1.4e6,
        beta_x=1.4e-3,
        youngs_modulus=192.85e9,
        poisson_ratio=0.29,
    )
    table = laws.TabulatedCurves(asperities, range=(1e-8, 1e-4))
    elastic = laws.ElasticCurves(k_n=2e12, k_x=1.5e12)
    return {
        "constant stiffness": laws.FrictionalLaw(elastic, 0.3, n_points=POINTS),
        "fitted": laws.FrictionalLaw(fitted, 0.2, n_points=POINTS),
        "table": laws.FrictionalLaw(table, 0.2, n_points=POINTS),
        "asperity sum": laws.FrictionalLaw(asperities, 0.2, n_points=POINTS),
        "foundation, 64 springs": laws.FoundationLaw(table, 0.2, tangential_ratio=0.8, n_springs=64, reach=1e-5, n_points=POINTS),
    }


def overhead(law: laws.Law) -> tuple[float, float, float]:
    """Smallest seconds of a call in Rust, from Python with arrays to write to, and with new arrays."""
    rng = np.random.default_rng(1)
    jump = np.abs(rng.normal(scale=2e-6, size=(3, law.n_points)))
    state = law.evaluate(0.7 * jump)[2]
    out = (np.empty((3, law.n_points)), np.empty((3, 3, law.n_points)), np.empty_like(state))
    best = [float("inf")] * 3
    for _ in range(ROUNDS):
        best[0] = min(best[0], *_native.time_law(law._made, jump, state, *out, 1))
        start = time.perf_counter()
        law.evaluate(jump, state, out=out)
        best[1] = min(best[1], time.perf_counter() - start)
        start = time.perf_counter()
        law.evaluate(jump, state)
        best[2] = min(best[2], time.perf_counter() - start)
    return best[0], best[1], best[2]


def main() -> int:
    """Prints a row for each law; 1 if the overhead of a call with arrays to write to is above the bound."""
    print(f"{'law':26s} {'Rust':>10s} {'with out':>10s} {'overhead':>9s} {'without':>10s} {'overhead':>9s}")
    worst = 0.0
    for name, law in examples().items():
        rust, written, new = overhead(law)
        worst = max(worst, written / rust - 1.0)
        print(
            f"{name:26s} {1e6 * rust:7.1f} us {1e6 * written:7.1f} us {written / rust - 1.0:+8.1%} "
            f"{1e6 * new:7.1f} us {new / rust - 1.0:+8.1%}"
        )
    print(f"largest overhead {worst:+.1%}, at most {LARGEST:.0%}")
    return int(worst > LARGEST)


if __name__ == "__main__":
    sys.exit(main())
