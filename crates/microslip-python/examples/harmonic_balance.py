"""A harmonic balance of one's own with a law of microslip.

The structure is two masses that are pressed onto the ground at two rough points. Each moves along the ground (x) and towards it
(n), and stiffnesses couple both, so that pressures change while the structure vibrates:

    M u'' - 2 zeta omega M u' + K u + B^T (A t(B u)) = f

Its free periodic motions by the extended periodic motion concept (Krack 2015) are found here with NumPy and SciPy alone; from
microslip comes the traction law, which is followed in time. Run it to see the backbone: ``python harmonic_balance.py``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from microslip import laws

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Structure:
    """Matrices, contact points and static load; the rows of `jump` are x, y, n of each point in turn."""

    stiffness: Array
    mass: Array
    jump: Array
    areas: Array
    law: laws.Law
    load: Array


def two_masses() -> Structure:
    """The example: coordinates are x and n of the first mass, then of the second."""
    stiffness = 2e8 * np.array(
        [
            [3.0, 0.4, -1.5, -0.2],
            [0.4, 2.0, -0.2, -0.8],
            [-1.5, -0.2, 2.5, 0.3],
            [-0.2, -0.8, 0.3, 1.8],
        ]
    )
    mass = np.diag([2.0, 2.0, 1.5, 1.5])
    jump = np.zeros((6, 4))
    # The ground is the bottom body: x and n of each mass are the jump; nothing moves along y.
    jump[[0, 2, 3, 5], range(4)] = 1.0
    asperities = laws.AsperitySumCurves(
        gaps=[0.0, 2e-6, 5e-6, 9e-6],
        probabilities=[0.0, 0.2, 0.7, 1.0],
        asperity_density=4e6,
        beta_x=2e-4,
        youngs_modulus=200e9,
        poisson_ratio=0.3,
    )
    return Structure(
        stiffness=stiffness,
        mass=mass,
        jump=jump,
        areas=np.array([1e-4, 1e-4]),
        law=laws.FrictionalLaw(asperities, 0.3, n_points=2),
        load=np.array([0.0, 300.0, 0.0, 250.0]),
    )


class HarmonicBalance:
    """Free periodic motions about the static state, with harmonics up to `harmonics` and `samples` per period.

    The unknowns are the Fourier coefficients of the displacements from the static state, ``X_0, C_1, S_1, ...``, and the
    angular frequency and damping ratio. Two more equations set the amplitude of the first harmonic and its phase.
    """

    def __init__(self, structure: Structure, harmonics: int, samples: int, periods: int = 2) -> None:
        self.structure = structure
        self.harmonics = harmonics
        self.periods = periods
        phase = 2 * np.pi * np.arange(samples) / samples
        columns = [np.ones(samples)]
        for h in range(1, harmonics + 1):
            columns += [np.cos(h * phase), np.sin(h * phase)]
        #: From coefficients to samples, and back: the trapezoidal rule.
        self.synthesis = np.array(columns)
        self.analysis = self.synthesis.T * np.where(np.arange(len(columns)) == 0, 1.0, 2.0) / samples
        self.rest, self.state = self._static_state()
        _, tangent, _ = structure.law.evaluate(self._jump(self.rest), self.state, sticking="full")
        stuck = structure.stiffness + self._assemble(tangent)
        self.eigenvalues, self.shapes = scipy.linalg.eigh(0.5 * (stuck + stuck.T), structure.mass)
        self.shapes *= np.sign(self.shapes[0])

    def _jump(self, displacement: Array) -> Array:
        return np.ascontiguousarray((self.structure.jump @ displacement).reshape(-1, 3).T)

    def _force(self, traction: Array) -> Array:
        force: Array = self.structure.jump.T @ (traction * self.structure.areas).T.ravel()
        return force

    def _assemble(self, tangent: Array) -> Array:
        """Tangent stiffness of the contact from the tangents at the points."""
        n_points = tangent.shape[2]
        blocks = np.zeros((3 * n_points, 3 * n_points))
        for p in range(n_points):
            blocks[3 * p : 3 * p + 3, 3 * p : 3 * p + 3] = tangent[:, :, p] * self.structure.areas[p]
        matrix: Array = self.structure.jump.T @ blocks @ self.structure.jump
        return matrix

    def _static_state(self) -> tuple[Array, Array]:
        """Equilibrium under the static load by Newton's method, and the history committed there."""
        structure = self.structure
        untouched = structure.law.evaluate(np.zeros((3, structure.law.n_points)))[2]
        displacement = np.zeros(len(structure.load))
        displacement[1::2] = 5e-6
        for _ in range(50):
            traction, tangent, state = structure.law.evaluate(self._jump(displacement), untouched)
            residual = structure.stiffness @ displacement + self._force(traction) - structure.load
            if np.linalg.norm(residual) < 1e-12 * np.linalg.norm(structure.load):
                return displacement, state
            displacement -= np.linalg.solve(structure.stiffness + self._assemble(tangent), residual)
        raise RuntimeError("the static state was not found")

    def contact(self, coefficients: Array) -> Array:
        """Fourier coefficients of the contact force from the static one, from those of the motion, by sampling in time."""
        law, state = self.structure.law, self.state
        static = self._force(law.evaluate(self._jump(self.rest), state, tangent=False)[0])
        motion = self.rest[:, np.newaxis] + coefficients @ self.synthesis
        forces = np.empty_like(motion)
        # The first period leads from the static state onto the loop, the last one is measured.
        for sample, u in self._path(motion):
            traction, _, state = law.evaluate(self._jump(u), state, tangent=False)
            forces[:, sample] = self._force(traction) - static
        harmonics: Array = forces @ self.analysis
        return harmonics

    def contact_change(self, coefficients: Array, direction: Array) -> Array:
        """How these coefficients change along a change of the motion: the derivative of the law, chained over the samples."""
        law, state = self.structure.law, self.state
        d_state = np.zeros_like(state)
        motion = self.rest[:, np.newaxis] + coefficients @ self.synthesis
        change = direction @ self.synthesis
        forces = np.empty_like(motion)
        for sample, u in self._path(motion):
            _, state, d_traction, d_state = law.derivative(self._jump(u), state, self._jump(change[:, sample]), d_state)
            forces[:, sample] = self._force(d_traction)
        harmonics: Array = forces @ self.analysis
        return harmonics

    def _path(self, motion: Array) -> Iterator[tuple[int, Array]]:
        for _ in range(self.periods):
            yield from enumerate(motion.T)

    def residual(self, unknown: Array, amplitude: float, mode: int) -> Array:
        """What is missing in the balance of every harmonic, in the amplitude and in the phase, each over its own size.

        `unknown` are the coefficients over the amplitude, then omega over that of the linear mode, then zeta.
        """
        coefficients = amplitude * unknown[:-2].reshape(len(self.rest), -1)
        balance = self._linear(coefficients, *self._parameters(unknown, mode)) + self.contact(coefficients)
        phi, mass = self.shapes[:, mode], self.structure.mass
        of_amplitude = np.sum(coefficients[:, 1:3] * (mass @ coefficients[:, 1:3])) / amplitude**2 - 1.0
        of_phase = coefficients[:, 2] @ mass @ phi / amplitude
        return np.concatenate([balance.ravel() / (self.eigenvalues[mode] * amplitude), [of_amplitude, of_phase]])

    def jacobian(self, unknown: Array, amplitude: float, mode: int) -> Array:
        """The derivative of :meth:`residual`, column by column; that along the two parameters by differences."""
        phi, mass = self.shapes[:, mode], self.structure.mass
        coefficients = amplitude * unknown[:-2].reshape(len(self.rest), -1)
        parameters = self._parameters(unknown, mode)
        matrix = np.zeros((unknown.size, unknown.size))
        for column in range(unknown.size - 2):
            direction = np.zeros(unknown.size - 2)
            direction[column] = amplitude
            change = direction.reshape(coefficients.shape)
            balance = self._linear(change, *parameters) + self.contact_change(coefficients, change)
            matrix[:-2, column] = balance.ravel() / (self.eigenvalues[mode] * amplitude)
            matrix[-2, column] = 2 * np.sum(change[:, 1:3] * (mass @ coefficients[:, 1:3])) / amplitude**2
            matrix[-1, column] = change[:, 2] @ mass @ phi / amplitude
        for column in (-2, -1):
            step = np.zeros(unknown.size)
            step[column] = 1e-6
            ends = [self._linear(coefficients, *self._parameters(unknown + sign * step, mode)) for sign in (1, -1)]
            matrix[:-2, column] = (ends[0] - ends[1]).ravel() / (2e-6 * self.eigenvalues[mode] * amplitude)
        return matrix

    def _parameters(self, unknown: Array, mode: int) -> tuple[float, float]:
        return float(np.sqrt(self.eigenvalues[mode]) * unknown[-2]), float(unknown[-1])

    def _linear(self, coefficients: Array, omega: float, zeta: float) -> Array:
        """Elastic forces, inertia and the damping that sustains the motion."""
        balance: Array = self.structure.stiffness @ coefficients
        for h in range(1, self.harmonics + 1):
            c, s = 2 * h - 1, 2 * h
            inertia = self.structure.mass @ coefficients[:, [c, s]]
            balance[:, [c, s]] -= (h * omega) ** 2 * inertia
            # The velocity is h omega (S_h cos - C_h sin).
            damping = 2 * zeta * omega * h * omega * inertia
            balance[:, c] -= damping[:, 1]
            balance[:, s] += damping[:, 0]
        return balance

    def backbone(self, amplitudes: Array, mode: int = 0) -> tuple[Array, Array]:
        """Frequency [Hz] and damping ratio of the motions that begin as a linear mode, at ascending modal amplitudes."""
        shape = np.zeros((len(self.rest), 2 * self.harmonics + 1))
        shape[:, 1] = self.shapes[:, mode]
        unknown = np.concatenate([shape.ravel(), [1.0, 0.0]])
        frequencies, dampings = [], []
        for amplitude in amplitudes:
            unknown = self._solve(unknown, float(amplitude), mode)
            omega, zeta = self._parameters(unknown, mode)
            frequencies.append(omega / (2 * np.pi))
            dampings.append(zeta)
        return np.array(frequencies), np.array(dampings)

    def _solve(self, unknown: Array, amplitude: float, mode: int) -> Array:
        """Newton's method, with steps that are halved until the residual falls."""
        residual = self.residual(unknown, amplitude, mode)
        for _ in range(40):
            if np.abs(residual).max() < 1e-11:
                return unknown
            step = np.linalg.solve(self.jacobian(unknown, amplitude, mode), residual)
            for halving in range(8):
                trial = unknown - 0.5**halving * step
                found = self.residual(trial, amplitude, mode)
                if np.linalg.norm(found) < np.linalg.norm(residual):
                    break
            unknown, residual = trial, found
        raise RuntimeError(f"no motion at the modal amplitude {amplitude:.2e} sqrt(kg) m")


def main() -> None:
    """Prints the backbone of the first mode."""
    balance = HarmonicBalance(two_masses(), harmonics=3, samples=64)
    amplitudes = np.geomspace(1e-7, 5e-6, 12)
    for q, frequency, damping in zip(amplitudes, *balance.backbone(amplitudes), strict=True):
        print(f"q {q:.2e} sqrt(kg) m   {frequency:8.3f} Hz   damping ratio {damping:.3e}")


if __name__ == "__main__":
    main()
