"""Analyses of structures given as matrices.

A structure is a pair of symmetric matrices, stiffness K [N/m] and mass M [kg], over any coordinates u, without the contact.
Where two bodies touch there is an :class:`Interface`: points of contact, whose jump is linear in the coordinates, with the area
that each stands for and a traction law from :mod:`microslip.laws`:

    M u'' + K u + B^T (A t(B u - g)) = f

with the rows B of the jump, the areas A, the tractions t of the law and the gaps g. Matrices are NumPy arrays or of
:mod:`scipy.sparse`. All quantities are in SI units.

=====================  =====================================================================================================
:func:`reduce`         smaller matrices over the jump and the first modes of the structure with the contact stuck
:func:`cqsma`          frequency and damping against amplitude from quasi-static hysteresis loops
:func:`epmc`           the same from free periodic motions by harmonic balance
:func:`transient`      a ring-down in time
=====================  =====================================================================================================

The last three find the equilibrium under a static load first, and the modes about it with all that is in contact stuck.
Modes are counted from 0. A modal amplitude q [sqrt(kg) m] is that of a mass-normalised mode: the displacement at a coordinate is
q times the mode's entry there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip import _native
from microslip._described import Described, Result, array, values
from microslip.errors import InputError
from microslip.laws import Law

__all__ = [
    "CqsmaBackbone",
    "EpmcBackbone",
    "Interface",
    "LinearModes",
    "Pulse",
    "ReducedModel",
    "Release",
    "RingDown",
    "StaticState",
    "cqsma",
    "epmc",
    "reduce",
    "transient",
]

Array = NDArray[np.float64]
#: An array of two dimensions, or a matrix of scipy.sparse.
Matrix: TypeAlias = Any


class Interface(Described):
    """Points of contact of a structure.

    Parameters
    ----------
    jump : array_like or sparse matrix, ``(3 * n_points, n)``
        Rows that give the jump at the points from the coordinates of the structure: those along x, y and n of the first point,
        then those of the second, and so on. The jump is ``u_top - u_bottom``, and n points from the top body into the bottom
        one, so that a positive normal jump closes the contact. Rows without entries are components along which nothing moves.
        Rows with one entry, 1, or with two, 1 and -1, keep the matrices sparse if every 1 is at a coordinate of its own; any
        others take full matrices.
    areas : array_like
        Area that each point stands for [m^2], one or ``(n_points,)``: tractions times areas are forces.
    law : Law
        Traction law of the points, as many as there are.
    gap : array_like
        What separates the bodies at rest [m], not negative, one or ``(n_points,)``.
    interference : array_like
        What the bodies are pressed into one another by at rest [m], not negative, one or ``(n_points,)``. With normal rows
        without entries it makes a contact of constant pressure.

    Raises
    ------
    InputError
        For a law or lists that do not fit the rows.

    Examples
    --------
    A mass on a support: its coordinates are the jump.

    >>> import numpy as np
    >>> import microslip
    >>> law = microslip.laws.FrictionalLaw(microslip.laws.ElasticCurves(k_n=1e10, k_x=1e10), mu=0.3)
    >>> microslip.Interface(np.eye(3), areas=1e-4, law=law).n_points
    1
    """

    def __init__(
        self,
        jump: Matrix,
        areas: ArrayLike,
        law: Law,
        *,
        gap: ArrayLike = 0.0,
        interference: ArrayLike = 0.0,
    ) -> None:
        if not isinstance(law, Law):
            raise InputError(f"law is {law!r}; it must be a law, as microslip.laws.FrictionalLaw")
        shape = _shape("jump", jump)
        if shape[0] != 3 * law.n_points:
            raise InputError(
                f"jump has the shape {shape}, but {3 * law.n_points} rows are needed: three for each of the law's "
                f"{law.n_points} points"
            )
        self._describe(
            jump=jump.tocsr(copy=True) if hasattr(jump, "tocsr") else values("jump", jump, ndim=2),
            areas=values("areas", areas),
            law=law,
            gap=values("gap", gap),
            interference=values("interference", interference),
        )

    @property
    def n_points(self) -> int:
        """Number of points.

        Examples
        --------
        >>> import numpy as np
        >>> import microslip
        >>> law = microslip.laws.FrictionalLaw(microslip.laws.ElasticCurves(k_n=1e10, k_x=1e10), mu=0.3)
        >>> interface = microslip.Interface(np.eye(3), areas=1e-4, law=law)
        >>> interface.n_points
        1
        """
        return self.law.n_points

    @property
    def jump(self) -> Matrix:
        """Rows of the jump, ``(3 * n_points, n)``.

        Examples
        --------
        >>> import numpy as np
        >>> import microslip
        >>> law = microslip.laws.FrictionalLaw(microslip.laws.ElasticCurves(k_n=1e10, k_x=1e10), mu=0.3)
        >>> interface = microslip.Interface(np.eye(3), areas=1e-4, law=law)
        >>> interface.jump.shape
        (3, 3)
        """
        return self._arguments["jump"]

    @property
    def areas(self) -> Array:
        """Areas [m^2], one or ``(n_points,)``.

        Examples
        --------
        >>> import numpy as np
        >>> import microslip
        >>> law = microslip.laws.FrictionalLaw(microslip.laws.ElasticCurves(k_n=1e10, k_x=1e10), mu=0.3)
        >>> interface = microslip.Interface(np.eye(3), areas=1e-4, law=law)
        >>> print(interface.areas)
        [0.0001]
        """
        found: Array = self._arguments["areas"]
        return found

    @property
    def law(self) -> Law:
        """The traction law.

        Examples
        --------
        >>> import numpy as np
        >>> import microslip
        >>> law = microslip.laws.FrictionalLaw(microslip.laws.ElasticCurves(k_n=1e10, k_x=1e10), mu=0.3)
        >>> interface = microslip.Interface(np.eye(3), areas=1e-4, law=law)
        >>> interface.law is law
        True
        """
        found: Law = self._arguments["law"]
        return found

    @property
    def gap(self) -> Array:
        """Gaps [m], one or ``(n_points,)``.

        Examples
        --------
        >>> import numpy as np
        >>> import microslip
        >>> law = microslip.laws.FrictionalLaw(microslip.laws.ElasticCurves(k_n=1e10, k_x=1e10), mu=0.3)
        >>> interface = microslip.Interface(np.eye(3), areas=1e-4, law=law, gap=1e-6)
        >>> print(interface.gap)
        [1.e-06]
        """
        found: Array = self._arguments["gap"]
        return found

    @property
    def interference(self) -> Array:
        """Interferences at rest [m], one or ``(n_points,)``.

        Examples
        --------
        >>> import numpy as np
        >>> import microslip
        >>> law = microslip.laws.FrictionalLaw(microslip.laws.ElasticCurves(k_n=1e10, k_x=1e10), mu=0.3)
        >>> interface = microslip.Interface(np.eye(3), areas=1e-4, law=law, interference=2e-6)
        >>> print(interface.interference)
        [2.e-06]
        """
        found: Array = self._arguments["interference"]
        return found


@dataclass(frozen=True, eq=False, repr=False)
class ReducedModel(Result):
    """Matrices over the jump and the first modes of the stuck structure, from :func:`reduce`.

    Attributes
    ----------
    stiffness, mass : ndarray, ``(m, m)``
        [N/m] and [kg] of the jump, omega^2 [rad^2/s^2] and 1 of the modes.
    interface : Interface
        The same points over the reduced coordinates.
    loads : ndarray, ``(n_loads, m)``
        The loads over the reduced coordinates.
    recovery : ndarray, ``(n_rows, m)``
        The rows to recover over the reduced coordinates.
    n_modes, n_attachment_modes : int
        How many of the last coordinates are modes, and static responses to loads.
    stuck_frequency_hz : ndarray, ``(n_modes,)``
        Frequencies with the jump held at zero [Hz].
    zero_energy_modes : int
        Rigid motions that were left out.
    asymmetry : float
        Relative round-off of the condensed matrices.

    Examples
    --------
    See :func:`reduce`.

    >>> from microslip import ReducedModel
    >>> "stiffness" in ReducedModel.__dataclass_fields__
    True
    """

    stiffness: Array
    mass: Array
    interface: Interface
    loads: Array
    recovery: Array
    n_modes: int
    n_attachment_modes: int
    stuck_frequency_hz: Array
    zero_energy_modes: int
    asymmetry: float


@dataclass(frozen=True, eq=False, repr=False)
class StaticState(Result):
    """The equilibrium under the static load.

    Attributes
    ----------
    converged : bool
        Whether it was found; if not, all numbers are NaN.
    reason : str or None
        Why it was not found.
    jump : ndarray, ``(3, n_points)``
        Jump along x, y and n, gap subtracted [m].
    traction : ndarray, ``(3, n_points)``
        Traction [Pa].
    regime : ndarray of uint8, ``(n_points,)``
        0 sticks, 1 slips, 2 is open.
    residual : float
        Residual relative to the load, in the energy norm.
    iterations : int
        Newton iterations.

    Examples
    --------
    >>> from microslip import StaticState
    >>> "traction" in StaticState.__dataclass_fields__
    True
    """

    converged: bool
    reason: str | None
    jump: Array
    traction: Array
    regime: NDArray[np.uint8]
    residual: float
    iterations: int


@dataclass(frozen=True, eq=False, repr=False)
class LinearModes(Result):
    """Modes about the static state with all that is in contact stuck.

    Attributes
    ----------
    frequency_hz : ndarray, ``(n_linear_modes,)``
        Ascending frequencies [Hz].
    shapes : ndarray, ``(n_rows, n_linear_modes)``
        Mass-normalised mode shapes at the rows that are recovered [1/sqrt(kg)]; not negative at the first.

    Examples
    --------
    >>> from microslip import LinearModes
    >>> "frequency_hz" in LinearModes.__dataclass_fields__
    True
    """

    frequency_hz: Array
    shapes: Array


@dataclass(frozen=True, eq=False, repr=False)
class CqsmaBackbone(Result):
    """Hysteresis loops of a mode against the amplitude, from :func:`cqsma`.

    All arrays have one entry for each amplitude, NaN where there is no result.

    Attributes
    ----------
    modal_amplitude : ndarray
        Half the range of the modal amplitude in the loop [sqrt(kg) m].
    frequency_hz : ndarray
        Secant frequency of the loop [Hz].
    harmonic_frequency_hz : ndarray
        Frequency of the first harmonic of the modal force [Hz]: closer to that of a free oscillation.
    damping_ratio : ndarray
        Damping ratio by friction [1].
    damping_floor : ndarray
        What residuals and open loops may make of it: a smaller damping ratio is not resolved.
    dissipation : ndarray
        Energy per cycle [J].
    modal_force : ndarray
        Peak of the modal force [sqrt(kg) m/s^2].
    shape_deviation : ndarray
        Part of the motion at the peak that is mass-orthogonal to the mode.
    residual : ndarray
        Largest residual, relative to the peak load in the energy norm.
    converged, closed, resolved : ndarray of bool
        Whether there is a result, the loop closed within the tolerance, and the damping is above its floor.
    cycles, n_slip, n_open : ndarray of int
        Cycles computed, and points that slip and that are open at the peak.
    reason : tuple of str or None
        Why there is no result.
    loops : tuple of (ndarray, ndarray)
        Modal amplitude [sqrt(kg) m] and modal force [sqrt(kg) m/s^2] along each loop.
    response_amplitude : ndarray or None
        Displacement amplitude at the response [m] by the linear mode's shape, if there is a response.
    static : StaticState
        The equilibrium under the static load.
    modes : LinearModes
        Modes about it.
    mode : int
        The mode followed.

    Examples
    --------
    See :func:`cqsma`.

    >>> from microslip import CqsmaBackbone
    >>> "damping_ratio" in CqsmaBackbone.__dataclass_fields__
    True
    """

    modal_amplitude: Array
    frequency_hz: Array
    harmonic_frequency_hz: Array
    damping_ratio: Array
    damping_floor: Array
    dissipation: Array
    modal_force: Array
    shape_deviation: Array
    residual: Array
    converged: NDArray[np.bool_]
    closed: NDArray[np.bool_]
    resolved: NDArray[np.bool_]
    cycles: NDArray[np.int64]
    n_slip: NDArray[np.int64]
    n_open: NDArray[np.int64]
    reason: tuple[str | None, ...]
    loops: tuple[tuple[Array, Array], ...]
    response_amplitude: Array | None
    static: StaticState
    modes: LinearModes
    mode: int


@dataclass(frozen=True, eq=False, repr=False)
class EpmcBackbone(Result):
    """Free periodic motions of a mode against the amplitude, from :func:`epmc`.

    Arrays have one entry for each amplitude, NaN where there is no result. Harmonics are ``x(t) = X_0 + sum_h (C_h cos(h w t) +
    S_h sin(h w t))``, in the order ``X_0, C_1, S_1, C_2, ...``.

    Attributes
    ----------
    modal_amplitude : ndarray
        Amplitude of the first harmonic in the norm of the mass [sqrt(kg) m].
    frequency_hz : ndarray
        Frequency [Hz].
    damping_ratio : ndarray
        Damping ratio by friction [1].
    dissipation : ndarray
        Energy that the contact takes per period [J].
    energy_error : ndarray
        What is missing in the balance of energies, as a damping ratio.
    residual : ndarray
        Residual relative to the elastic forces, in the energy norm.
    drift : ndarray
        Change of the tractions from the last period but one to the last, relative to their range.
    converged : ndarray of bool
        Whether there is a result.
    reason : tuple of str or None
        Why there is none.
    harmonics, samples : ndarray of int
        Highest harmonic and samples per period.
    jump : ndarray, ``(n_amplitudes, 3, n_points, 2 * H + 1)``
        Harmonics of the jump from the static state [m].
    response : ndarray or None, ``(n_amplitudes, 2 * H + 1)``
        Harmonics of the displacement at the response from the static state [m], if there is a response.
    response_amplitude : ndarray or None
        Amplitude of its first harmonic [m].
    static : StaticState
        The equilibrium under the static load.
    modes : LinearModes
        Modes about it.
    mode : int
        The mode followed.

    Examples
    --------
    See :func:`epmc`.

    >>> from microslip import EpmcBackbone
    >>> "harmonics" in EpmcBackbone.__dataclass_fields__
    True
    """

    modal_amplitude: Array
    frequency_hz: Array
    damping_ratio: Array
    dissipation: Array
    energy_error: Array
    residual: Array
    drift: Array
    converged: NDArray[np.bool_]
    reason: tuple[str | None, ...]
    harmonics: NDArray[np.int64]
    samples: NDArray[np.int64]
    jump: Array
    response: Array | None
    response_amplitude: Array | None
    static: StaticState
    modes: LinearModes
    mode: int


@dataclass(frozen=True)
class Release:
    """A ring-down that begins with the release from the equilibrium under the mode's own inertial load.

    Parameters
    ----------
    modal_amplitude : float
        Modal amplitude by linear estimate [sqrt(kg) m].

    Examples
    --------
    >>> from microslip import Release
    >>> Release(1e-4)
    Release(modal_amplitude=0.0001)
    """

    modal_amplitude: float


@dataclass(frozen=True, eq=False)
class Pulse:
    """A ring-down that begins with one half-sine of force on the structure at rest.

    Parameters
    ----------
    impulse : float
        Integral of the force over time [N s].
    duration : float
        Duration [s].
    direction : array_like, ``(n,)``, optional
        Row over the coordinates along which the force acts; the response if it is not given.

    Examples
    --------
    >>> from microslip import Pulse
    >>> Pulse(impulse=0.1, duration=1e-3).duration
    0.001
    """

    impulse: float
    duration: float
    direction: ArrayLike | None = None


@dataclass(frozen=True, eq=False, repr=False)
class RingDown(Result):
    """Motion in time, from :func:`transient`. Arrays have one entry for each sample.

    Attributes
    ----------
    time : ndarray
        [s].
    displacement, velocity, acceleration : ndarray
        At the response, from the static state [m], [m/s], [m/s^2].
    kinetic_energy, elastic_energy : ndarray
        Of the bodies, from the static state [J].
    contact_work, viscous_work, external_work : ndarray
        Work done on the contact, against viscous forces and by the pulse since the start [J].
    step : float
        Time step [s].
    converged : bool
        Whether the motion was followed to its end; if not, the samples up to there are given.
    reason : str or None
        Why not.
    residual : float
        Largest residual of a step (energy norm).
    energy_error : float
        Largest change of the energy balance relative to the energy in the motion.
    share_elsewhere : float
        Share of the kinetic energy outside the mode.
    algorithmic_frequency_ratio, algorithmic_damping_ratio : float
        What the time integration does to the linear mode: frequency over the true one, and damping ratio.
    static : StaticState
        The equilibrium under the static load.
    modes : LinearModes
        Modes about it.

    Examples
    --------
    See :func:`transient`.

    >>> from microslip import RingDown
    >>> "acceleration" in RingDown.__dataclass_fields__
    True
    """

    time: Array
    displacement: Array
    velocity: Array
    acceleration: Array
    kinetic_energy: Array
    elastic_energy: Array
    contact_work: Array
    viscous_work: Array
    external_work: Array
    step: float
    converged: bool
    reason: str | None
    residual: float
    energy_error: float
    share_elsewhere: float
    algorithmic_frequency_ratio: float
    algorithmic_damping_ratio: float
    static: StaticState
    modes: LinearModes


def reduce(
    stiffness: Matrix,
    mass: Matrix,
    interface: Interface,
    *,
    n_modes: int = 20,
    loads: ArrayLike | None = None,
    recover: ArrayLike | None = None,
    zero_energy_modes: int = 0,
    attachment_modes: bool = False,
    threads: int | None = None,
) -> ReducedModel:
    """Condenses a structure onto its jump and the first modes that it has with the jump held at zero (Craig-Bampton).

    Contact forces act on the leading coordinates of the result alone, and the analyses take it in place of the structure.

    Parameters
    ----------
    stiffness, mass : array_like or sparse matrix, ``(n, n)``
        Symmetric and positive semi-definite, without the contact [N/m], [kg].
    interface : Interface
        Points of contact.
    n_modes : int
        Modes of the stuck structure to retain.
    loads : array_like, ``(n,)`` or ``(n_loads, n)``, optional
        Forces to carry over [N].
    recover : array_like, ``(n,)`` or ``(n_rows, n)``, optional
        Rows whose products with the coordinates are wanted, such as the displacement at a sensor.
    zero_energy_modes : int
        Rigid motions that the stuck structure has: 6 for a free one in space, 0 for one that is held.
    attachment_modes : bool
        Whether the static response of the stuck structure to each load joins the modes.
    threads : int, optional
        Threads to use; by default as many as there are processors.

    Returns
    -------
    ReducedModel

    Raises
    ------
    InputError
        For matrices that are not square, symmetric, finite and semi-definite or do not fit, rows of the jump that depend on one
        another, and another number of rigid motions than expected.
    SolverError
        If the matrices cannot be factored.

    Examples
    --------
    A bar of 200 masses, held at one end and touching a support at the other:

    >>> import numpy as np
    >>> import scipy.sparse
    >>> import microslip
    >>> n = 200
    >>> stiffness = 1e6 * scipy.sparse.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(n, n))
    >>> mass = 1e-2 * scipy.sparse.eye(n)
    >>> law = microslip.laws.FrictionalLaw(microslip.laws.ElasticCurves(k_n=1e10, k_x=1e10), mu=0.3)
    >>> end = scipy.sparse.csr_array(([1.0], ([0], [n - 1])), shape=(3, n))
    >>> interface = microslip.Interface(end, areas=1e-4, law=law, interference=1e-6)
    >>> model = microslip.reduce(stiffness, mass, interface, n_modes=5)
    >>> model.stiffness.shape
    (6, 6)
    """
    n = _shape("stiffness", stiffness)[0]
    made = _structure(
        stiffness,
        mass,
        interface,
        load=_rows("loads", loads, n),
        recover=_rows("recover", recover, n),
        n_modes=n_modes,
        zero_energy_modes=zero_energy_modes,
        attachment_modes=attachment_modes,
        threads=threads,
    )
    found = made.reduced()
    matrix = found["stiffness"]
    jump = np.zeros((3 * interface.n_points, matrix.shape[0]))
    jump[found["jump_rows"], range(len(found["jump_rows"]))] = 1.0
    return ReducedModel(
        stiffness=matrix,
        mass=found["mass"],
        interface=Interface(
            jump, interface.areas, interface.law, gap=interface.gap, interference=interface.interference
        ),
        loads=found["loads"],
        recovery=found["recovery"],
        n_modes=found["n_modes"],
        n_attachment_modes=found["n_attachment_modes"],
        stuck_frequency_hz=found["stuck_frequency_hz"],
        zero_energy_modes=found["zero_energy_modes"],
        asymmetry=found["asymmetry"],
    )


def cqsma(
    stiffness: Matrix,
    mass: Matrix,
    interface: Interface,
    modal_amplitudes: ArrayLike,
    *,
    load: ArrayLike | None = None,
    response: ArrayLike | None = None,
    mode: int = 0,
    n_linear_modes: int = 10,
    n_modes: int | None = None,
    zero_energy_modes: int = 0,
    closure: float | None = None,
    vertices_per_quarter: int = 4,
    cycles: int | None = None,
    until_closed: float = 2e-3,
    max_cycles: int = 20,
    commit: Literal["every-vertex", "reversals"] = "every-vertex",
    tolerance: float = 1e-9,
    max_iterations: int = 60,
    threads: int | None = None,
) -> CqsmaBackbone:
    """Frequency and damping of a mode from its quasi-static hysteresis loops (coupled quasi-static modal analysis).

    The structure in its static equilibrium is loaded by the inertia of one of its linear modes, to and fro; the loop of modal
    force and modal amplitude gives the secant frequency and, by its area, the damping ratio.

    Parameters
    ----------
    stiffness, mass : array_like or sparse matrix, ``(n, n)``
        Symmetric and positive semi-definite, without the contact [N/m], [kg].
    interface : Interface
        Points of contact.
    modal_amplitudes : array_like
        Amplitudes by linear estimate [sqrt(kg) m]: modal forces over omega^2. Positive.
    load : array_like, ``(n,)``, optional
        Static load [N], such as bolt forces; none by default.
    response : array_like, ``(n,)``, optional
        Row over the coordinates at which amplitudes are wanted, too; it also tells the sign of modes.
    mode : int
        Linear mode to follow, counted from 0.
    n_linear_modes : int
        Linear modes to report.
    n_modes : int, optional
        Modes of the stuck structure to retain; all by default, which is exact and takes full matrices.
    zero_energy_modes : int
        Rigid motions of the stuck structure, see :func:`reduce`.
    closure : float, optional
        Uniform normal jump that the search for the static state begins with [m]; by default one that carries the load.
    vertices_per_quarter : int
        Vertices per quarter of a loop. Unless `cycles` is given it is the least number: where half as many change the damping
        ratio by more than 5 %, twice as many are taken, up to four times.
    cycles : int, optional
        Cycles to compute, of which the last is measured; by default until the loop closes.
    until_closed : float
        Part of the damping ratio that the gap between the ends of a closed loop may make up.
    max_cycles : int
        Most cycles until then.
    commit : {'every-vertex', 'reversals'}
        When the history becomes that of later solves.
    tolerance : float
        Residual relative to the load, in the energy norm.
    max_iterations : int
        Most Newton iterations of a solve.
    threads : int, optional
        Threads to use; results do not depend on it.

    Returns
    -------
    CqsmaBackbone
        Amplitudes that did not converge are NaN; so is everything if the static state was not found.

    Raises
    ------
    InputError
        For matrices, rows, loads and settings that do not fit; the message names the argument.
    SolverError
        If the structure can move freely.

    Examples
    --------
    A mass on a spring and a slider, which slips at 0.3 times 1e10 Pa/m times 1 um times 1e-4 m^2 = 0.3 N:

    >>> import numpy as np
    >>> import microslip
    >>> law = microslip.laws.FrictionalLaw(microslip.laws.ElasticCurves(k_n=1e10, k_x=4e7), mu=0.3)
    >>> along = np.array([[1.0], [0.0], [0.0]])
    >>> interface = microslip.Interface(along, areas=1e-4, law=law, interference=1e-6)
    >>> found = microslip.cqsma([[1e4]], [[1.0]], interface, [1e-5, 1e-3])
    >>> print(np.round(found.frequency_hz, 3))
    [18.831 16.089]
    """
    n = _shape("stiffness", stiffness)[0]
    amplitudes = _amplitudes(modal_amplitudes)
    rows = _rows("response", response, n, single=True)
    made = _structure(
        stiffness,
        mass,
        interface,
        load=_rows("load", load, n, single=True),
        recover=rows,
        n_modes=n_modes,
        zero_energy_modes=zero_energy_modes,
        attachment_modes=None,
        threads=threads,
    )
    found = _native.run_cqsma(
        made,
        amplitudes,
        _count("mode", mode),
        _count("n_linear_modes", n_linear_modes),
        closure,
        _count("vertices_per_quarter", vertices_per_quarter),
        None if cycles is None else _count("cycles", cycles),
        until_closed,
        _count("max_cycles", max_cycles),
        commit,
        tolerance,
        _count("max_iterations", max_iterations),
        threads,
    )
    static, modes = _static(found, interface, len(rows))
    count = len(amplitudes)
    reason = tuple(found.get("reason", (static.reason,) * count))
    amplitude = _column(found, "modal_amplitude", count)
    return CqsmaBackbone(
        modal_amplitude=amplitude,
        frequency_hz=_column(found, "frequency_hz", count),
        harmonic_frequency_hz=_column(found, "harmonic_frequency_hz", count),
        damping_ratio=_column(found, "damping_ratio", count),
        damping_floor=_column(found, "damping_floor", count),
        dissipation=_column(found, "dissipation", count),
        modal_force=_column(found, "modal_force", count),
        shape_deviation=_column(found, "shape_deviation", count),
        residual=_column(found, "residual", count),
        converged=np.array([why is None for why in reason], dtype=np.bool_),
        closed=found.get("closed", np.zeros(count, dtype=np.bool_)),
        resolved=found.get("resolved", np.zeros(count, dtype=np.bool_)),
        cycles=found.get("cycles", np.zeros(count, dtype=np.int64)),
        n_slip=found.get("n_slip", np.zeros(count, dtype=np.int64)),
        n_open=found.get("n_open", np.zeros(count, dtype=np.int64)),
        reason=reason,
        loops=tuple(found.get("loops", ((np.empty(0), np.empty(0)),) * count)),
        response_amplitude=None if response is None else amplitude * (np.abs(modes.shapes[0, mode]) if static.converged else np.nan),
        static=static,
        modes=modes,
        mode=mode,
    )


def epmc(
    stiffness: Matrix,
    mass: Matrix,
    interface: Interface,
    modal_amplitudes: ArrayLike,
    *,
    load: ArrayLike | None = None,
    response: ArrayLike | None = None,
    mode: int = 0,
    n_linear_modes: int = 10,
    n_modes: int | None = None,
    zero_energy_modes: int = 0,
    closure: float | None = None,
    harmonics: int = 3,
    samples: int = 128,
    periods: int = 2,
    accuracy: tuple[float, float] | None = None,
    damping_floor: float = 1e-5,
    max_harmonics: int = 31,
    max_samples: int = 4096,
    tolerance: float = 1e-8,
    max_iterations: int = 30,
    static_tolerance: float = 1e-9,
    threads: int | None = None,
) -> EpmcBackbone:
    """Frequency and damping of a mode from free periodic motions (extended periodic motion concept, harmonic balance).

    A damping ``-2 zeta omega M u'`` supplies what friction takes, so that the motion is periodic; contact is followed in time.

    Parameters
    ----------
    stiffness, mass, interface, load, response, mode, n_linear_modes, n_modes, zero_energy_modes, closure, threads
        As for :func:`cqsma`.
    modal_amplitudes : array_like
        Amplitudes of the first harmonic in the norm of the mass [sqrt(kg) m], ascending.
    harmonics : int
        Highest harmonic, 1 to 200.
    samples : int
        Samples per period, more than twice the harmonics.
    periods : int
        Periods that the history is followed for, the last of which is measured.
    accuracy : tuple of two float, optional
        Relative errors of frequency and damping ratio that are borne: harmonics and samples are raised at each amplitude until
        what two harmonics more and twice the samples change shows smaller ones.
    damping_floor : float
        Damping ratio below which errors do not matter.
    max_harmonics, max_samples : int
        How far harmonics and samples may be raised.
    tolerance : float
        Residual relative to the elastic forces of the first harmonic, in the energy norm.
    max_iterations : int
        Most Newton iterations of a point.
    static_tolerance : float
        Residual of the static state relative to the load, in the energy norm.

    Returns
    -------
    EpmcBackbone
        Amplitudes that did not converge are NaN; so is everything if the static state was not found.

    Raises
    ------
    InputError
        For matrices, rows, loads and settings that do not fit; the message names the argument.
    SolverError
        If the structure can move freely.

    Examples
    --------
    With one harmonic a slider is its describing function:

    >>> import numpy as np
    >>> import microslip
    >>> law = microslip.laws.FrictionalLaw(microslip.laws.ElasticCurves(k_n=1e10, k_x=4e7), mu=0.3)
    >>> along = np.array([[1.0], [0.0], [0.0]])
    >>> interface = microslip.Interface(along, areas=1e-4, law=law, interference=1e-6)
    >>> found = microslip.epmc([[1e4]], [[1.0]], interface, [1e-5, 1e-3], harmonics=1, samples=2048)
    >>> print(np.round(found.frequency_hz, 3), np.round(found.damping_ratio, 4))
    [18.831 16.024] [0.     0.0174]
    """
    n = _shape("stiffness", stiffness)[0]
    amplitudes = _amplitudes(modal_amplitudes)
    rows = _rows("response", response, n, single=True)
    made = _structure(
        stiffness,
        mass,
        interface,
        load=_rows("load", load, n, single=True),
        recover=rows,
        n_modes=n_modes,
        zero_energy_modes=zero_energy_modes,
        attachment_modes=None,
        threads=threads,
    )
    found = _native.run_epmc(
        made,
        amplitudes,
        _count("mode", mode),
        _count("n_linear_modes", n_linear_modes),
        closure,
        [_count("harmonics", harmonics), _count("samples", samples), _count("periods", periods)],
        None if accuracy is None else [*_two("accuracy", accuracy), damping_floor],
        [_count("max_harmonics", max_harmonics), _count("max_samples", max_samples)],
        tolerance,
        _count("max_iterations", max_iterations),
        static_tolerance,
        threads,
    )
    static, modes = _static(found, interface, len(rows))
    count = len(amplitudes)
    reason = tuple(found.get("reason", (static.reason,) * count))
    jump = found.get("jump", np.full((count, 3 * interface.n_points, 1), np.nan))
    own = found.get("response", np.full((count, len(rows), 1), np.nan))
    first = np.hypot(own[:, 0, 1], own[:, 0, 2]) if len(rows) and own.shape[2] > 2 else np.full(count, np.nan)
    return EpmcBackbone(
        modal_amplitude=_column(found, "modal_amplitude", count),
        frequency_hz=_column(found, "frequency_hz", count),
        damping_ratio=_column(found, "damping_ratio", count),
        dissipation=_column(found, "dissipation", count),
        energy_error=_column(found, "energy_error", count),
        residual=_column(found, "residual", count),
        drift=_column(found, "drift", count),
        converged=np.array([why is None for why in reason], dtype=np.bool_),
        reason=reason,
        harmonics=found.get("harmonics", np.zeros(count, dtype=np.int64)),
        samples=found.get("samples", np.zeros(count, dtype=np.int64)),
        # Coordinates are point by point.
        jump=jump.reshape(count, interface.n_points, 3, jump.shape[2]).transpose(0, 2, 1, 3),
        response=own[:, 0] if len(rows) else None,
        response_amplitude=first if len(rows) else None,
        static=static,
        modes=modes,
        mode=mode,
    )


def transient(
    stiffness: Matrix,
    mass: Matrix,
    interface: Interface,
    start: Release | Pulse,
    *,
    response: ArrayLike,
    load: ArrayLike | None = None,
    mode: int = 0,
    n_linear_modes: int = 10,
    n_modes: int | None = None,
    zero_energy_modes: int = 0,
    closure: float | None = None,
    steps_per_period: int = 100,
    periods: int = 100,
    spectral_radius: float = 0.9,
    background_damping: float = 0.0,
    other_damping: float = 0.0,
    tolerance: float = 1e-8,
    max_iterations: int = 30,
    static_tolerance: float = 1e-9,
    threads: int | None = None,
) -> RingDown:
    """The motion of the structure in time, by the generalised-alpha method with the history committed at every step.

    Parameters
    ----------
    stiffness, mass, interface, load, mode, n_linear_modes, n_modes, zero_energy_modes, closure, threads
        As for :func:`cqsma`; `mode` sets the time step, and is the one that a release moves.
    start : Release or Pulse
        What begins the motion.
    response : array_like, ``(n,)``
        Row over the coordinates of the displacement that is recorded.
    steps_per_period : int
        Time steps per period of the linear mode, at least 8.
    periods : int
        Periods to follow.
    spectral_radius : float
        Spectral radius of the scheme at infinite frequency, 0 to 1: with 1 it damps nothing.
    background_damping : float
        Viscous damping ratio of every linear mode.
    other_damping : float
        Viscous damping ratio of the linear modes beside the one followed, where it is larger.
    tolerance : float
        Residual of a step relative to the inertia of the moment, in the energy norm.
    max_iterations : int
        Most Newton iterations of a step.
    static_tolerance : float
        Residual of the static state relative to the load, in the energy norm.

    Returns
    -------
    RingDown
        If a step did not converge, the samples up to there.

    Raises
    ------
    InputError
        For matrices, rows, loads and settings that do not fit; the message names the argument.
    SolverError
        If the structure can move freely.

    Examples
    --------
    Friction takes energy from a released mass:

    >>> import numpy as np
    >>> import microslip
    >>> law = microslip.laws.FrictionalLaw(microslip.laws.ElasticCurves(k_n=1e10, k_x=4e7), mu=0.3)
    >>> along = np.array([[1.0], [0.0], [0.0]])
    >>> interface = microslip.Interface(along, areas=1e-4, law=law, interference=1e-6)
    >>> motion = microslip.transient(
    ...     [[1e4]], [[1.0]], interface, microslip.Release(1e-3), response=[1.0], periods=10
    ... )
    >>> bool(abs(motion.displacement[-100:]).max() < 0.7 * motion.displacement[0])
    True
    """
    n = _shape("stiffness", stiffness)[0]
    rows = _rows("response", response, n, single=True)
    if isinstance(start, Pulse):
        direction = _rows("direction", start.direction, n, single=True)
        rows = np.ascontiguousarray(np.vstack([rows, direction]))
        begin: tuple[float | None, tuple[float, float] | None] = (None, (start.impulse, start.duration))
    elif isinstance(start, Release):
        begin = (start.modal_amplitude, None)
    else:
        raise InputError(f"start is {start!r}; it must be a Release or a Pulse")
    made = _structure(
        stiffness,
        mass,
        interface,
        load=_rows("load", load, n, single=True),
        recover=rows,
        n_modes=n_modes,
        zero_energy_modes=zero_energy_modes,
        attachment_modes=None,
        threads=threads,
    )
    found = _native.run_transient(
        made,
        *begin,
        _count("mode", mode),
        _count("n_linear_modes", n_linear_modes),
        closure,
        _count("steps_per_period", steps_per_period),
        _count("periods", periods),
        spectral_radius,
        background_damping,
        other_damping,
        tolerance,
        _count("max_iterations", max_iterations),
        static_tolerance,
        threads,
    )
    static, modes = _static(found, interface, len(rows))
    reason = found["reason"] if "reason" in found else static.reason
    return RingDown(
        time=_column(found, "time", 0),
        displacement=_column(found, "displacement", 0),
        velocity=_column(found, "velocity", 0),
        acceleration=_column(found, "acceleration", 0),
        kinetic_energy=_column(found, "kinetic_energy", 0),
        elastic_energy=_column(found, "elastic_energy", 0),
        contact_work=_column(found, "contact_work", 0),
        viscous_work=_column(found, "viscous_work", 0),
        external_work=_column(found, "external_work", 0),
        step=found.get("step", np.nan),
        converged=reason is None,
        reason=reason,
        residual=found.get("residual", np.nan),
        energy_error=found.get("energy_error", np.nan),
        share_elsewhere=found.get("share_elsewhere", np.nan),
        algorithmic_frequency_ratio=found.get("algorithmic_frequency_ratio", np.nan),
        algorithmic_damping_ratio=found.get("algorithmic_damping_ratio", np.nan),
        static=static,
        modes=modes,
    )


def _structure(
    stiffness: Matrix,
    mass: Matrix,
    interface: Interface,
    *,
    load: Array,
    recover: Array,
    n_modes: int | None,
    zero_energy_modes: int,
    attachment_modes: bool | None,
    threads: int | None,
) -> _native.Structure:
    if not isinstance(interface, Interface):
        raise InputError(f"interface is {interface!r}; it must be a microslip.Interface")
    return _native.Structure(
        _matrix("stiffness", stiffness),
        _matrix("mass", mass),
        _matrix("jump", interface.jump),
        interface.areas,
        interface.law._made,
        interface.gap,
        interface.interference,
        load,
        recover,
        None if n_modes is None else _count("n_modes", n_modes),
        _count("zero_energy_modes", zero_energy_modes),
        attachment_modes,
        threads,
    )


def _shape(name: str, matrix: Matrix) -> tuple[int, int]:
    shape = tuple(int(n) for n in (matrix.shape if hasattr(matrix, "shape") else np.shape(matrix)))
    if len(shape) != 2:
        raise InputError(f"{name} has the shape {shape}, but a matrix is needed")
    return shape[0], shape[1]


def _matrix(name: str, matrix: Matrix) -> Array | tuple[Any, ...]:
    """An array, or shape, row starts, columns and values of compressed rows."""
    _shape(name, matrix)
    if not hasattr(matrix, "tocsr"):
        return array(name, matrix)
    rows = matrix.tocsr()
    if not rows.has_canonical_format:
        rows = rows.copy()
        rows.sum_duplicates()
    return (
        tuple(int(n) for n in rows.shape),
        np.ascontiguousarray(rows.indptr, dtype=np.int64),
        np.ascontiguousarray(rows.indices, dtype=np.int64),
        array(name, rows.data),
    )


def _rows(name: str, rows: ArrayLike | None, n: int, *, single: bool = False) -> Array:
    """Rows over the coordinates; none is no row."""
    if rows is None:
        return np.empty((0, n))
    found = array(name, rows)
    if found.ndim == 1:
        found = found[np.newaxis]
    if found.ndim != 2 or found.shape[1] != n or (single and found.shape[0] != 1):
        needed = f"({n},)" if single else f"({n},) or (any, {n})"
        raise InputError(f"{name} has the shape {np.shape(rows)}, but {needed} is needed")
    return np.ascontiguousarray(found)


def _amplitudes(amplitudes: ArrayLike) -> list[float]:
    return [float(q) for q in values("modal_amplitudes", amplitudes)]


def _two(name: str, pair: Sequence[float]) -> tuple[float, float]:
    if len(pair) != 2:
        raise InputError(f"{name} has {len(pair)} values, but 2 are needed")
    return float(pair[0]), float(pair[1])


def _count(name: str, value: int) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= value < 1 << 32:
        raise InputError(f"{name} is {value!r}; it must be a whole number from 0 to {(1 << 32) - 1}")
    return int(value)


def _column(found: dict[str, Any], name: str, count: int) -> Array:
    column: Array = found.get(name, np.full(count, np.nan))
    return column


def _static(found: dict[str, Any], interface: Interface, n_rows: int) -> tuple[StaticState, LinearModes]:
    n = interface.n_points
    if "static" not in found:
        nothing = np.full((3, n), np.nan)
        state = StaticState(
            converged=False,
            reason=found["failure"],
            jump=nothing,
            traction=nothing.copy(),
            regime=np.full(n, 3, dtype=np.uint8),
            residual=float(found["history"][-1]) if len(found["history"]) else np.nan,
            iterations=len(found["history"]),
        )
        return state, LinearModes(np.full(0, np.nan), np.full((n_rows, 0), np.nan))
    own, modes = found["static"], found["modes"]
    return StaticState(converged=True, reason=None, **own), LinearModes(modes["frequency_hz"], modes["shapes"])
