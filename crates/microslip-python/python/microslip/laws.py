"""Traction laws of rough and dry-friction contact at points.

A law answers the jump at its points and the state committed last with tractions, the tangent and the state reached. All
arrays begin with the component, so that ``u_x, u_y, u_n = jump`` works and nothing is copied:

=========  =====================  ======  ==========================================================
array      shape                  unit    meaning
=========  =====================  ======  ==========================================================
jump       ``(3, n_points)``      m       ``u_top - u_bottom`` along x, y and the normal n, which
                                          points from the top body into the bottom one; the gap is
                                          subtracted, so that ``jump[2] > 0`` is interference
traction   ``(3, n_points)``      Pa      answers the jump with the same sign: ``traction[2] >= 0``
                                          is pressure
tangent    ``(3, 3, n_points)``   Pa/m    ``tangent[i, j] = d traction[i] / d jump[j]``
state      ``(n_state,            mixed   history; zeros are a point that touches nothing; names and
           n_points)``                    units in ``law.info.state``
=========  =====================  ======  ==========================================================

``np.moveaxis(tangent, -1, 0)`` is the view with one 3 x 3 matrix for each point.

A law is made of contact curves and a way that friction remembers:

>>> import numpy as np
>>> from microslip import laws
>>> curves = laws.ElasticCurves(k_n=2e12, k_x=1.5e12)
>>> law = laws.FrictionalLaw(curves, mu=0.3)
>>> closed = [[0.0], [0.0], [1e-6]]
>>> traction, tangent, state = law.evaluate(closed)
>>> traction, tangent, state = law.evaluate([[1e-6], [0.0], [1e-6]], state)
>>> print(traction[0] / traction[2])
[0.3]

Evaluation is pure: it never changes ``state``. Whether the state that is returned becomes the next one that is given is the
caller's decision, at every converged step or at load reversals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip import _native
from microslip._described import Described, array, values
from microslip.errors import InputError

__all__ = [
    "AsperitySumCurves",
    "Curves",
    "ElasticCurves",
    "FittedCurves",
    "FoundationLaw",
    "FrictionalLaw",
    "GreenwoodWilliamsonCurves",
    "Law",
    "LawInfo",
    "LinearisedContact",
    "Quantity",
    "ResolvedLaw",
    "SampledCurves",
    "TabulatedCurves",
]

Array = NDArray[np.float64]

#: How the stuck traction follows from the state committed last.
History = Literal["incremental", "paper", "end-point", "potential"]
#: Shape of the slip limit: the same in every direction, or each direction by itself.
Cone = Literal["circle", "box"]
#: Whether points slip at Coulomb's limit, all stick, or none carries a tangential traction.
Sticking = Literal["coulomb", "full", "frictionless"]
#: Tangential stiffness of an asperity: Mindlin's, or as published the same for every loaded one.
Reading = Literal["mindlin", "paper"]


# Arrays that a call returns are freed before the next call. By default the C library then hands their memory back to the
# system, and asking for it again costs several times the evaluation. It stops doing so for sizes up to the largest block that
# was freed once: this one is never touched, so that it takes no memory.
np.empty(1 << 19)


@dataclass(frozen=True)
class Quantity:
    """Name and unit of a state component or a parameter.

    Examples
    --------
    >>> from microslip import laws
    >>> laws.FrictionalLaw(laws.ElasticCurves(k_n=1.0, k_x=1.0), mu=0.2).info.state[0]
    Quantity(name='u_x', unit='m')
    """

    name: str
    unit: str


@dataclass(frozen=True)
class LawInfo:
    """What a law is: its name, where it is described, and its state and parameters in their order.

    Examples
    --------
    >>> from microslip import laws
    >>> info = laws.FrictionalLaw(laws.ElasticCurves(k_n=1.0, k_x=1.0), mu=0.2).info
    >>> info.name, [quantity.name for quantity in info.parameters]
    ('elastic dry friction', ['k_n', 'k_x', 'k_y', 'mu'])
    """

    name: str
    reference: str
    state: tuple[Quantity, ...]
    parameters: tuple[Quantity, ...]


class Curves(Described):
    """Normal traction and tangential stiffness as functions of the interference: base of the classes that can be made.

    Parameters of curves are numbers, or lists with one value for each parameter set. All lists of several values have the
    same length. A law takes one set for all points, one for each point, or any number with an ``index``.

    Examples
    --------
    >>> from microslip import laws
    >>> curves = laws.ElasticCurves(k_n=[1e12, 2e12], k_x=1e12)
    >>> curves.n_sets
    2
    """

    _made: _native.Curves

    @property
    def n_sets(self) -> int:
        """Number of parameter sets.

        Examples
        --------
        >>> from microslip import laws
        >>> laws.ElasticCurves(k_n=[1e12, 2e12], k_x=1e12).n_sets
        2
        """
        return len(self._made)


class ElasticCurves(Curves):
    """Constant stiffnesses per area, for elastic dry friction.

    Parameters
    ----------
    k_n : array_like
        Normal stiffness [Pa/m].
    k_x, k_y : array_like
        Tangential stiffnesses [Pa/m]; `k_y` is `k_x` if it is not given.

    Raises
    ------
    InputError
        For stiffnesses that are not above zero, and lists of different length.

    Examples
    --------
    >>> from microslip import laws
    >>> laws.ElasticCurves(k_n=2e12, k_x=1.5e12)
    ElasticCurves(k_n=2000000000000.0, k_x=1500000000000.0, k_y=1500000000000.0)
    """

    def __init__(self, *, k_n: ArrayLike, k_x: ArrayLike, k_y: ArrayLike | None = None) -> None:
        normal, x = values("k_n", k_n), values("k_x", k_x)
        y = x if k_y is None else values("k_y", k_y)
        self._describe(k_n=normal, k_x=x, k_y=y)
        self._made = _native.Curves.elastic(normal, x, y)


class SampledCurves(Curves):
    """Curves through points that were measured or computed elsewhere, such as by :func:`microslip.press`.

    Parameters
    ----------
    interferences : array_like
        Rising [m].
    tractions : array_like
        Normal tractions there [Pa], rising from 0.
    areas : array_like
        Parts of the area in contact there [1].
    tangential_ratio : float
        Tangential over normal stiffness, of equal bodies ``2 (1 - nu)/(2 - nu)``.

    Raises
    ------
    InputError
        For lists of different length or out of order.

    Examples
    --------
    >>> from microslip import laws
    >>> curves = laws.SampledCurves(interferences=[0, 1e-6, 2e-6], tractions=[0, 2e6, 6e6], areas=[0, 0.01, 0.03], tangential_ratio=0.8)
    >>> laws.FoundationLaw(curves, mu=0.2, tangential_ratio=0.8, n_springs=16, reach=2e-6).n_points
    1
    """

    def __init__(
        self, *, interferences: ArrayLike, tractions: ArrayLike, areas: ArrayLike, tangential_ratio: float
    ) -> None:
        u, t, a = values("interferences", interferences), values("tractions", tractions), values("areas", areas)
        self._describe(interferences=u, tractions=t, areas=a, tangential_ratio=tangential_ratio)
        self._made = _native.Curves.sampled(u.tolist(), t.tolist(), a.tolist(), tangential_ratio)


class FittedCurves(Curves):
    """Fitted curves, eqs. (28) and (29) of Balaji, Chen and Brake (2020).

    With ``U = u_n / u_ref`` and natural logarithms, ``ln(t_n / 1 Pa) = a + b ln U + c exp(-((ln U + d) / e)^2 / 2)`` and
    ``ln(k / 1 Pa/m) = a + b tanh(d (ln U - c))``, the latter apart for x and y.

    Parameters
    ----------
    normal : sequence of five array_like
        a, b, c, d, e of the normal traction [1].
    tangential_x, tangential_y : sequence of four array_like
        a, b, c, d of the tangential stiffnesses [1]; those along y are those along x if they are not given.
    u_ref : array_like
        Reference interference [m].
    ranges : array_like, optional
        Interferences between which the fits hold [m], ``(3, 2)``: of the normal traction, of the stiffness along x, of that
        along y; or ``(2,)``, the same for all. Beyond them the curves go on smoothly. Without, the formulas hold everywhere.
    ends : {'mindlin', 'constant'}
        How the tangential stiffness goes on: with the slope of single asperities, or as a constant.

    Raises
    ------
    InputError
        For parameters outside what the formulas allow.

    Examples
    --------
    >>> import numpy as np
    >>> from microslip import laws
    >>> curves = laws.FittedCurves(
    ...     normal=(13.0, 2.2, 0.4, 0.5, 1.2), tangential_x=(28.0, 1.5, 0.3, 0.6), u_ref=1e-6, ranges=(1e-7, 1e-5)
    ... )
    >>> law = laws.FrictionalLaw(curves, mu=0.2)
    >>> pressure = law.evaluate([[0.0], [0.0], [1e-6]])[0][2, 0]
    >>> print(np.isclose(np.log(pressure), 13.0 + 0.4 * np.exp(-((0.5 / 1.2) ** 2) / 2)))
    True
    """

    def __init__(
        self,
        *,
        normal: tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike, ArrayLike],
        tangential_x: tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike],
        tangential_y: tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike] | None = None,
        u_ref: ArrayLike,
        ranges: ArrayLike | None = None,
        ends: Literal["mindlin", "constant"] = "mindlin",
    ) -> None:
        def several(name: str, given: tuple[ArrayLike, ...], count: int) -> list[Array]:
            if len(given) != count:
                raise InputError(f"{name} has {len(given)} parameters, but {count} are needed")
            return [values(f"{name} {letter}", value) for letter, value in zip("abcde", given, strict=False)]

        of_normal = several("normal", normal, 5)
        along_x = several("tangential_x", tangential_x, 4)
        along_y = along_x if tangential_y is None else several("tangential_y", tangential_y, 4)
        reference = values("u_ref", u_ref)
        limits = None if ranges is None else _ranges(ranges)
        self._describe(
            normal=tuple(of_normal),
            tangential_x=tuple(along_x),
            tangential_y=tuple(along_y),
            u_ref=reference,
            ranges=limits,
            ends=ends,
        )
        as_lists = None if limits is None else limits.tolist()
        self._made = _native.Curves.fitted(of_normal, along_x, along_y, reference, as_lists, ends)


class AsperitySumCurves(Curves):
    """Sums over asperities of two equal elastic bodies, by Hertz and Mindlin, without a fit.

    Parameters
    ----------
    gaps : array_like
        Gaps of the asperity pairs when the surfaces just touch [m], not negative, ``(n_gaps,)``: samples of equal weight, or
        with `probabilities` the quantiles that belong to them. The same for all points.
    probabilities : array_like, optional
        Ascending from 0 to 1, one for each gap.
    asperity_density : array_like
        Asperity pairs per area [1/m^2].
    beta_x, beta_y : array_like
        Effective radii [m]; `beta_y` is `beta_x` if it is not given.
    youngs_modulus : array_like
        Young's modulus of both bodies [Pa].
    poisson_ratio : array_like
        Poisson's ratio of both.
    reading : {'mindlin', 'paper'}
        Tangential stiffness of an asperity: proportional to its contact radius, or as published the same for every loaded one.

    Raises
    ------
    InputError
        For gaps, densities, radii or materials that are not physical.

    Examples
    --------
    A single height is a bed of Hertz contacts:

    >>> import numpy as np
    >>> from microslip import laws
    >>> curves = laws.AsperitySumCurves(
    ...     gaps=[0.0], asperity_density=1e6, beta_x=1e-3, youngs_modulus=200e9, poisson_ratio=0.3
    ... )
    >>> pressure = laws.FrictionalLaw(curves, mu=0.2).evaluate([[0.0], [0.0], [1e-6]])[0][2, 0]
    >>> composite = 200e9 / (2 * (1 - 0.3**2))
    >>> print(np.isclose(pressure, 1e6 * 4 / 3 * composite * np.sqrt(1e-3) * 1e-6**1.5))
    True
    """

    def __init__(
        self,
        *,
        gaps: ArrayLike,
        probabilities: ArrayLike | None = None,
        asperity_density: ArrayLike,
        beta_x: ArrayLike,
        beta_y: ArrayLike | None = None,
        youngs_modulus: ArrayLike,
        poisson_ratio: ArrayLike,
        reading: Reading = "mindlin",
    ) -> None:
        own = values("gaps", gaps)
        quantiles = None if probabilities is None else values("probabilities", probabilities)
        density, x = values("asperity_density", asperity_density), values("beta_x", beta_x)
        y = x if beta_y is None else values("beta_y", beta_y)
        modulus, ratio = values("youngs_modulus", youngs_modulus), values("poisson_ratio", poisson_ratio)
        self._describe(
            gaps=own,
            probabilities=quantiles,
            asperity_density=density,
            beta_x=x,
            beta_y=y,
            youngs_modulus=modulus,
            poisson_ratio=ratio,
            reading=reading,
        )
        self._made = _native.Curves.asperity_sum(own, quantiles, density, x, y, modulus, ratio, reading)


class GreenwoodWilliamsonCurves(Curves):
    """Asperities of equal radius whose heights follow a distribution, in closed form.

    Parameters
    ----------
    heights : {'exponential', 'gaussian'}
        Distribution of the heights: ``exp(-z / scale) / scale`` for ``z >= 0``, or normal about zero.
    scale : array_like
        Mean of exponential heights, standard deviation of Gaussian ones [m].
    reference_height : array_like
        Distance of the opposite plane from the zero of the heights where ``u_n = 0`` [m].
    asperity_density : array_like
        Asperities per area [1/m^2].
    beta_x, beta_y : array_like
        Effective radii [m]; `beta_y` is `beta_x` if it is not given.
    youngs_modulus : array_like
        Young's modulus of both bodies [Pa].
    poisson_ratio : array_like
        Poisson's ratio of both.
    reading : {'mindlin', 'paper'}
        As for :class:`AsperitySumCurves`.

    Raises
    ------
    InputError
        For lengths or densities that are not above zero, or a material that is not physical.

    Examples
    --------
    Exponential heights make the pressure rise by a factor of e over one scale:

    >>> import numpy as np
    >>> from microslip import laws
    >>> curves = laws.GreenwoodWilliamsonCurves(
    ...     heights="exponential", scale=1e-6, reference_height=5e-6, asperity_density=1e8, beta_x=1e-4,
    ...     youngs_modulus=200e9, poisson_ratio=0.3,
    ... )
    >>> law = laws.FrictionalLaw(curves, mu=0.2, n_points=2)
    >>> pressure = law.evaluate([[0.0, 0.0], [0.0, 0.0], [1e-6, 2e-6]])[0][2]
    >>> print(np.isclose(pressure[1] / pressure[0], np.e))
    True
    """

    def __init__(
        self,
        *,
        heights: Literal["exponential", "gaussian"],
        scale: ArrayLike,
        reference_height: ArrayLike,
        asperity_density: ArrayLike,
        beta_x: ArrayLike,
        beta_y: ArrayLike | None = None,
        youngs_modulus: ArrayLike,
        poisson_ratio: ArrayLike,
        reading: Reading = "mindlin",
    ) -> None:
        own, reference = values("scale", scale), values("reference_height", reference_height)
        density, x = values("asperity_density", asperity_density), values("beta_x", beta_x)
        y = x if beta_y is None else values("beta_y", beta_y)
        modulus, ratio = values("youngs_modulus", youngs_modulus), values("poisson_ratio", poisson_ratio)
        self._describe(
            heights=heights,
            scale=own,
            reference_height=reference,
            asperity_density=density,
            beta_x=x,
            beta_y=y,
            youngs_modulus=modulus,
            poisson_ratio=ratio,
            reading=reading,
        )
        self._made = _native.Curves.greenwood_williamson(
            heights, own, reference, density, x, y, modulus, ratio, reading
        )


class TabulatedCurves(Curves):
    """A monotone table of other curves whose error is measured when it is made.

    Parameters
    ----------
    source : Curves
        The curves, of any kind but tables.
    range : tuple of two float
        Interferences between which the table interpolates [m]; beyond, it goes on smoothly.
    tolerance_normal, tolerance_tangential : float
        Largest relative errors of normal traction and tangential stiffnesses.
    max_knots_per_octave : int
        Finest table that is tried.

    Raises
    ------
    InputError
        For a range that is not positive and ascending, and where the finest table is not good enough.

    Examples
    --------
    >>> from microslip import laws
    >>> curves = laws.AsperitySumCurves(
    ...     gaps=[0.0, 8e-6, 14e-6, 28e-6], probabilities=[0.0, 0.1, 0.5, 1.0], asperity_density=1.4e6, beta_x=1.4e-3,
    ...     youngs_modulus=192.85e9, poisson_ratio=0.29,
    ... )
    >>> table = laws.TabulatedCurves(curves, range=(1e-8, 1e-4))
    >>> table.errors[0] < 1e-5 and table.errors[1] < 1e-4
    True
    """

    def __init__(
        self,
        source: Curves,
        *,
        range: tuple[float, float],
        tolerance_normal: float = 1e-5,
        tolerance_tangential: float = 1e-4,
        max_knots_per_octave: int = 1024,
    ) -> None:
        if not isinstance(source, Curves):
            raise InputError(f"source is {source!r}; it must be contact curves")
        lower, upper = _pair("range", range)
        self._describe(
            source=source,
            range=(lower, upper),
            tolerance_normal=tolerance_normal,
            tolerance_tangential=tolerance_tangential,
            max_knots_per_octave=max_knots_per_octave,
        )
        self._made = _native.Curves.table(
            source._made, (lower, upper), tolerance_normal, tolerance_tangential, max_knots_per_octave
        )

    @property
    def errors(self) -> tuple[float, float]:
        """Largest relative errors in the range, of normal traction and of tangential stiffnesses.

        Examples
        --------
        >>> from microslip import laws
        >>> curves = laws.GreenwoodWilliamsonCurves(
        ...     heights="gaussian", scale=2e-6, reference_height=7e-6, asperity_density=1.4e6, beta_x=1.4e-3,
        ...     youngs_modulus=192.85e9, poisson_ratio=0.29,
        ... )
        >>> table = laws.TabulatedCurves(curves, range=(1e-8, 2e-5))
        >>> table.errors[0] <= 1e-5
        True
        """
        return self._made.table_errors() or (0.0, 0.0)


class Law(Described):
    """A traction law over a number of points: base of the classes that can be made.

    Any number of threads may evaluate a law at the same time; the interpreter's lock is released meanwhile.

    Examples
    --------
    >>> import pickle
    >>> from microslip import laws
    >>> law = laws.FrictionalLaw(laws.ElasticCurves(k_n=2e12, k_x=1.5e12), mu=0.3, n_points=4)
    >>> law.n_points, law.n_state, law.initial_state().shape
    (4, 5, (5, 4))
    >>> pickle.loads(pickle.dumps(law)) == law
    True
    """

    _made: _native.Law

    @property
    def n_points(self) -> int:
        """Number of points.

        Examples
        --------
        >>> from microslip import laws
        >>> law = laws.FrictionalLaw(laws.ElasticCurves(k_n=[2e12, 3e12], k_x=1.5e12), mu=0.3)
        >>> law.n_points
        2
        """
        return self._made.n_points

    @property
    def n_state(self) -> int:
        """Numbers that the state of a point has.

        Examples
        --------
        >>> from microslip import laws
        >>> law = laws.FrictionalLaw(laws.ElasticCurves(k_n=[2e12, 3e12], k_x=1.5e12), mu=0.3)
        >>> law.initial_state().shape == (law.n_state, law.n_points)
        True
        """
        return self._made.n_state

    @property
    def info(self) -> LawInfo:
        """Name, source, state and parameters of the law.

        Examples
        --------
        >>> from microslip import laws
        >>> law = laws.FrictionalLaw(laws.ElasticCurves(k_n=[2e12, 3e12], k_x=1.5e12), mu=0.3)
        >>> law.info.name
        'elastic dry friction'
        """
        name, reference, state, parameters = self._made.info()
        return LawInfo(
            name,
            reference,
            tuple(Quantity(name, unit) for name, unit in state),
            tuple(Quantity(name, unit) for name, unit in parameters),
        )

    def initial_state(self) -> Array:
        """The state of points that touch nothing and carry nothing.

        Returns
        -------
        ndarray, ``(n_state, n_points)``
            Zeros.

        Examples
        --------
        >>> from microslip import laws
        >>> laws.FrictionalLaw(laws.ElasticCurves(k_n=1.0, k_x=1.0), mu=0.2).initial_state().shape
        (5, 1)
        """
        return np.zeros((self._made.n_state, self._made.n_points))

    @overload
    def evaluate(
        self,
        jump: ArrayLike,
        state: ArrayLike | None = None,
        *,
        tangent: Literal[True] = True,
        sticking: Sticking = "coulomb",
        out: tuple[Array, Array | None, Array] | None = None,
    ) -> tuple[Array, Array, Array]: ...

    @overload
    def evaluate(
        self,
        jump: ArrayLike,
        state: ArrayLike | None = None,
        *,
        tangent: Literal[False],
        sticking: Sticking = "coulomb",
        out: tuple[Array, Array | None, Array] | None = None,
    ) -> tuple[Array, None, Array]: ...

    @overload
    def evaluate(
        self,
        jump: ArrayLike,
        state: ArrayLike | None = None,
        *,
        tangent: bool,
        sticking: Sticking = "coulomb",
        out: tuple[Array, Array | None, Array] | None = None,
    ) -> tuple[Array, Array | None, Array]: ...

    def evaluate(
        self,
        jump: ArrayLike,
        state: ArrayLike | None = None,
        *,
        tangent: bool = True,
        sticking: Sticking = "coulomb",
        out: tuple[Array, Array | None, Array] | None = None,
    ) -> tuple[Array, Array | None, Array]:
        """Tractions, tangent and the state reached.

        Parameters
        ----------
        jump : array_like, ``(3, n_points)``
            Jump along x, y and n, gap subtracted [m].
        state : array_like, ``(n_state, n_points)``, optional
            The state committed last; that of points that touch nothing if it is not given. Never changed.
        tangent : bool
            Whether the tangent is computed.
        sticking : {'coulomb', 'full', 'frictionless'}
            Whether points slip at Coulomb's limit, all that are closed stick, or none carries a tangential traction.
        out : tuple of three arrays, optional
            Traction, tangent (None without) and state to write to and return: nothing is allocated then. Arrays of float64,
            contiguous in C order, that share no memory with one another and with the input.

        Returns
        -------
        traction : ndarray, ``(3, n_points)``
            Tractions [Pa].
        tangent : ndarray, ``(3, 3, n_points)``, or None
            Consistent tangent [Pa/m], at a kink that of the branch taken; not symmetric in slip.
        state : ndarray, ``(n_state, n_points)``
            The state reached.

        Raises
        ------
        InputError
            For arrays of another shape or kind. A point whose jump or state is not finite is no error: all that is returned
            for it is NaN.

        Examples
        --------
        >>> import numpy as np
        >>> from microslip import laws
        >>> law = laws.FrictionalLaw(laws.ElasticCurves(k_n=2e12, k_x=1.5e12), mu=0.3, n_points=2)
        >>> jump = np.array([[0.0, 0.0], [0.0, 0.0], [1e-6, -1e-6]])
        >>> traction, tangent, state = law.evaluate(jump)
        >>> print(traction[2])
        [2000000.       0.]
        >>> out = (np.empty((3, 2)), np.empty((3, 3, 2)), np.empty((5, 2)))
        >>> law.evaluate(jump, state, out=out)[0] is out[0]
        True
        """
        made = self._made
        begin = self.initial_state() if state is None else array("state", state)
        if out is None:
            n = made.n_points
            traction, end = np.empty((3, n)), np.empty((made.n_state, n))
            slopes = np.empty((3, 3, n)) if tangent else None
        else:
            traction, slopes, end = _out(out, tangent)
        made.evaluate(array("jump", jump), begin, sticking, traction, slopes, end)
        return traction, slopes, end

    def derivative(
        self,
        jump: ArrayLike,
        state: ArrayLike,
        d_jump: ArrayLike,
        d_state: ArrayLike,
        *,
        sticking: Sticking = "coulomb",
    ) -> tuple[Array, Array, Array, Array]:
        """Tractions and state reached, and how both change along a direction of jump and state.

        Chained over the steps of a path, with the change of the state reached as `d_state` of the next step, it gives the
        derivative of the path: what Newton's method in harmonic balance or a shooting method needs.

        Parameters
        ----------
        jump, state : array_like
            As for :meth:`evaluate`.
        d_jump : array_like, ``(3, n_points)``
            Change of the jump.
        d_state : array_like, ``(n_state, n_points)``
            Change of the state.
        sticking : {'coulomb', 'full', 'frictionless'}
            As for :meth:`evaluate`.

        Returns
        -------
        traction, state : ndarray
            As from :meth:`evaluate`, to the last bit.
        d_traction : ndarray, ``(3, n_points)``
            Change of the tractions; one-sided at kinks.
        d_state : ndarray, ``(n_state, n_points)``
            Change of the state reached.

        Raises
        ------
        InputError
            For arrays of another shape or kind.

        Examples
        --------
        >>> import numpy as np
        >>> from microslip import laws
        >>> law = laws.FrictionalLaw(laws.ElasticCurves(k_n=2e12, k_x=1.5e12), mu=0.3)
        >>> rest = np.zeros((5, 1))
        >>> jump, along = [[0.0], [0.0], [1e-6]], [[0.0], [0.0], [1.0]]
        >>> d_traction = law.derivative(jump, rest, along, rest)[2]
        >>> print(d_traction[2])
        [2.e+12]
        """
        made = self._made
        n, n_state = made.n_points, made.n_state
        traction, d_traction = np.empty((3, n)), np.empty((3, n))
        end, d_end = np.empty((n_state, n)), np.empty((n_state, n))
        made.derivative(
            array("jump", jump),
            array("state", state),
            array("d_jump", d_jump),
            array("d_state", d_state),
            sticking,
            traction,
            end,
            d_traction,
            d_end,
        )
        return traction, end, d_traction, d_end

    def regimes(self, jump: ArrayLike, state: ArrayLike | None = None) -> NDArray[np.uint8]:
        """What the points do at a jump.

        Parameters
        ----------
        jump, state : array_like
            As for :meth:`evaluate`.

        Returns
        -------
        ndarray of uint8, ``(n_points,)``
            0 sticks, 1 slips, 2 is open, 3 has input that is not finite.

        Raises
        ------
        InputError
            For arrays of another shape or kind.

        Examples
        --------
        >>> from microslip import laws
        >>> law = laws.FrictionalLaw(laws.ElasticCurves(k_n=2e12, k_x=1.5e12), mu=0.3, n_points=3)
        >>> print(law.regimes([[0.0, 1e-5, 0.0], [0.0, 0.0, 0.0], [1e-6, 1e-6, -1e-6]]))
        [0 1 2]
        """
        begin = self.initial_state() if state is None else array("state", state)
        return self._made.regimes(array("jump", jump), begin)

    def linearised(self, jump: ArrayLike, state: ArrayLike) -> LinearisedContact:
        """This law, linearised about a static state.

        Parameters
        ----------
        jump : array_like, ``(3, n_points)``
            Jump of the static state, gap subtracted [m].
        state : array_like, ``(n_state, n_points)``
            The history committed there.

        Returns
        -------
        LinearisedContact
            With the tractions of the static state, the diagonal of its stuck tangent and the slip limits ``mu t_n``.

        Raises
        ------
        InputError
            For arrays that do not fit, a state that is not finite, and laws without a friction coefficient.

        Examples
        --------
        >>> from microslip import laws
        >>> law = laws.FrictionalLaw(laws.ElasticCurves(k_n=2e12, k_x=1.5e12), mu=0.3)
        >>> static = [[0.0], [0.0], [1e-6]]
        >>> linear = law.linearised(static, law.evaluate(static)[2])
        >>> print(linear.evaluate(static)[0][2])
        [2000000.]
        """
        columns, closed = self._made.about(array("jump", jump), array("state", state))
        return LinearisedContact(
            jump=columns[0:3],
            traction=columns[3:6],
            stiffness=columns[6:9],
            slip_limit=columns[9],
            closed=closed,
        )


class FrictionalLaw(Law):
    """Contact curves with Coulomb friction, which stick or slip as a whole.

    Parameters
    ----------
    curves : Curves
        Normal traction and tangential stiffness.
    mu : array_like
        Friction coefficient, one or one for each point.
    history : History
        How the stuck traction follows from the state committed last. By default by the midpoint rule along the closed part of
        the path; 'potential' never gains energy when every step is committed. The page on friction has the equations of all.
    cone : {'circle', 'box'}
        Slip limit: the same in every direction, or each direction by itself.
    n_points : int, optional
        Number of points; otherwise that of the lists given, or one.
    index : array_like of int, ``(n_points,)``, optional
        Parameter set of every point, counted from 0: few sets that many points share, for instance one for each element.

    Raises
    ------
    InputError
        For coefficients that are negative or not finite, names that do not exist, and lists that do not fit.

    Examples
    --------
    >>> from microslip import laws
    >>> curves = laws.ElasticCurves(k_n=[2e12, 3e12], k_x=1.5e12)
    >>> law = laws.FrictionalLaw(curves, mu=0.3, history="potential", index=[0, 1, 1, 0])
    >>> law.n_points
    4
    """

    def __init__(
        self,
        curves: Curves,
        mu: ArrayLike,
        *,
        history: History = "incremental",
        cone: Cone = "circle",
        n_points: int | None = None,
        index: ArrayLike | None = None,
    ) -> None:
        friction, sets = values("mu", mu), _index(index)
        self._describe(curves=_curves(curves), mu=friction, history=history, cone=cone, n_points=n_points, index=sets)
        self._made = _native.Law.frictional(curves._made, friction, history, cone, n_points, sets)


class FoundationLaw(Law):
    """Contact curves as a foundation of linear springs that slip one by one: partial slip as Cattaneo and Mindlin found it.

    Parameters
    ----------
    curves : Curves
        Normal traction, whose stiffness must not fall with the interference, and contact area.
    mu : array_like
        Friction coefficient, one or one for each point.
    tangential_ratio : float
        Tangential over normal stiffness, of equal bodies ``2 (1 - nu)/(2 - nu)``.
    n_springs : int
        Springs up to `reach`, an even number. More follow the curves, and cycles of small amplitudes, more closely.
    reach : float
        Largest interference that is expected (m). Beyond it few springs are left.
    n_points, index : optional
        As for :class:`FrictionalLaw`.

    Raises
    ------
    InputError
        As for :class:`FrictionalLaw`, for numbers out of bounds, and for curves whose stiffness falls.

    Examples
    --------
    >>> from microslip import laws
    >>> curves = laws.ElasticCurves(k_n=2e12, k_x=1.6e12)
    >>> laws.FoundationLaw(curves, mu=0.3, tangential_ratio=0.8, n_springs=8, reach=1e-5).n_points
    1
    """

    def __init__(
        self,
        curves: Curves,
        mu: ArrayLike,
        *,
        tangential_ratio: float,
        n_springs: int,
        reach: float,
        n_points: int | None = None,
        index: ArrayLike | None = None,
    ) -> None:
        friction, sets = values("mu", mu), _index(index)
        self._describe(
            curves=_curves(curves),
            mu=friction,
            tangential_ratio=tangential_ratio,
            n_springs=n_springs,
            reach=reach,
            n_points=n_points,
            index=sets,
        )
        self._made = _native.Law.foundation(curves._made, friction, tangential_ratio, n_springs, reach, n_points, sets)


class ResolvedLaw(Law):
    """Friction resolved over asperities: bins of one initial gap each, every bin with a history of its own.

    Parameters
    ----------
    gaps : array_like, ``(n_bins,)`` or ``(n_bins, n_sets)``
        Initial gap of each bin [m]; 0 is the first asperity to touch.
    densities : array_like, of the same shape
        Asperities per area of each bin [1/m^2].
    radius : float
        Effective radius of an asperity [m].
    youngs_modulus : float
        Young's modulus of both bodies [Pa].
    poisson_ratio : float
        Poisson's ratio of both.
    mu : array_like
        Friction coefficient, one or one for each point; without effect where the slip limit follows from the yield strength.
    yield_strength : float, optional
        Yield strength [Pa]. Without, asperities are elastic.
    tangent_modulus : float
        Tangent modulus of the hardening material [Pa].
    yield_curves : {'continuous', 'published'}
        Whether the jumps of the published curves are taken out.
    history : History
        As for :class:`FrictionalLaw`; 'potential' for elastic asperities only.
    annuli : int, optional
        Asperities slip from their rim inwards, in so many annuli, 1 to 256.
    radii : int, optional
        The same as published, with tractions remembered at so many radii, 3 to 256. With neither, asperities stick or slip as
        a whole.
    cone : {'circle', 'box'}
        As for :class:`FrictionalLaw`, for every asperity.
    slip_limit : {'coulomb', 'ceb', 'shear-strength'}
        What limits the tangential force of an asperity: a share of its normal force, its first yield under both forces, or the
        shear strength that its pressure leaves.
    n_points, index : optional
        As for :class:`FrictionalLaw`.

    Raises
    ------
    InputError
        For bins, materials and choices that do not go together.

    Examples
    --------
    >>> from microslip import laws
    >>> law = laws.ResolvedLaw(
    ...     gaps=[0.0, 1e-6, 2e-6], densities=[1e6, 2e6, 3e6], radius=1e-3, youngs_modulus=200e9, poisson_ratio=0.3, mu=0.2,
    ...     yield_strength=350e6,
    ... )
    >>> law.n_state
    15
    """

    def __init__(
        self,
        *,
        gaps: ArrayLike,
        densities: ArrayLike,
        radius: float,
        youngs_modulus: float,
        poisson_ratio: float,
        mu: ArrayLike,
        yield_strength: float | None = None,
        tangent_modulus: float = 0.0,
        yield_curves: Literal["continuous", "published"] = "continuous",
        history: History = "incremental",
        annuli: int | None = None,
        radii: int | None = None,
        cone: Cone = "circle",
        slip_limit: Literal["coulomb", "ceb", "shear-strength"] = "coulomb",
        n_points: int | None = None,
        index: ArrayLike | None = None,
    ) -> None:
        def bins(name: str, value: ArrayLike) -> Array:
            found = array(name, value)
            return values(name, found[:, np.newaxis] if found.ndim == 1 else found, ndim=2)

        own, density = bins("gaps", gaps), bins("densities", densities)
        friction, sets = values("mu", mu), _index(index)
        self._describe(
            gaps=own,
            densities=density,
            radius=float(radius),
            youngs_modulus=float(youngs_modulus),
            poisson_ratio=float(poisson_ratio),
            mu=friction,
            yield_strength=yield_strength,
            tangent_modulus=tangent_modulus,
            yield_curves=yield_curves,
            history=history,
            annuli=annuli,
            radii=radii,
            cone=cone,
            slip_limit=slip_limit,
            n_points=n_points,
            index=sets,
        )
        yielding = None if yield_strength is None else (yield_strength, tangent_modulus, yield_curves)
        self._made = _native.Law.resolved(
            own,
            density,
            radius,
            youngs_modulus,
            poisson_ratio,
            yielding,
            friction,
            history,
            annuli,
            radii,
            cone,
            slip_limit,
            n_points,
            sets,
        )


class LinearisedContact(Law):
    """Contact with constant stiffnesses and a constant slip limit about a static state; it never opens.

    :meth:`Law.linearised` makes one of any other law.

    Parameters
    ----------
    jump : array_like, ``(3, n_points)``
        Jump of the static state [m].
    traction : array_like, ``(3, n_points)``
        Its traction [Pa].
    stiffness : array_like, ``(3, n_points)``
        Stiffness per area along x, y and n [Pa/m].
    slip_limit : array_like, ``(n_points,)``
        Largest tangential traction [Pa], at least that of the static state.
    closed : sequence of bool, ``(n_points,)``, optional
        Points that are in contact; the others stay open. By default all are.

    Raises
    ------
    InputError
        For values that are not finite, negative stiffnesses, and limits below the tangential traction.

    Examples
    --------
    A slider with a spring, whatever the normal load:

    >>> from microslip import laws
    >>> law = laws.LinearisedContact(
    ...     jump=[[0.0], [0.0], [0.0]], traction=[[0.0], [0.0], [0.0]], stiffness=[[4e3], [4e3], [0.0]], slip_limit=[4.0]
    ... )
    >>> print(law.evaluate([[5e-3], [0.0], [0.0]], tangent=False)[0][0])
    [4.]
    """

    def __init__(
        self,
        *,
        jump: ArrayLike,
        traction: ArrayLike,
        stiffness: ArrayLike,
        slip_limit: ArrayLike,
        closed: ArrayLike | None = None,
    ) -> None:
        at, carried, stiff = (
            values("jump", jump, ndim=2),
            values("traction", traction, ndim=2),
            values("stiffness", stiffness, ndim=2),
        )
        limit = values("slip_limit", slip_limit)
        contact = tuple(bool(c) for c in np.ravel(np.asarray(closed))) if closed is not None else (True,) * limit.size
        self._describe(jump=at, traction=carried, stiffness=stiff, slip_limit=limit, closed=contact)
        self._made = _native.Law.linearised(at, carried, stiff, limit, list(contact))


def _curves(curves: Curves) -> Curves:
    if not isinstance(curves, Curves):
        raise InputError(f"curves is {curves!r}; it must be contact curves, as ElasticCurves")
    return curves


def _index(index: ArrayLike | None) -> NDArray[np.int64] | None:
    if index is None:
        return None
    found = np.asarray(index)
    if found.ndim != 1 or not np.issubdtype(found.dtype, np.integer):
        raise InputError(f"index has the shape {found.shape} and the type {found.dtype}; it must be a list of integers")
    own = np.array(found, dtype=np.int64)
    own.setflags(write=False)
    return own


def _pair(name: str, value: tuple[float, float]) -> tuple[float, float]:
    found = array(name, value)
    if found.shape != (2,):
        raise InputError(f"{name} has the shape {found.shape}, but (2,) is needed")
    return float(found[0]), float(found[1])


def _ranges(value: ArrayLike) -> Array:
    found = array("ranges", value)
    if found.shape not in ((2,), (3, 2)):
        raise InputError(f"ranges has the shape {found.shape}, but (2,) or (3, 2) is needed")
    own = np.array(np.broadcast_to(found, (3, 2)))
    own.setflags(write=False)
    return own


def _out(out: tuple[Array, Array | None, Array], tangent: bool) -> tuple[Array, Array | None, Array]:
    if not (isinstance(out, tuple) and len(out) == 3):
        raise InputError("out must be a tuple of three arrays: traction, tangent (or None) and state")
    if tangent and out[1] is None:
        raise InputError("out has no array for the tangent; give one, or ask with tangent=False")
    return out if tangent else (out[0], None, out[2])
