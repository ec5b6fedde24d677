"""Exceptions of the package.

All of them are :class:`Error`, so that one ``except`` clause catches what the package raises on purpose.
"""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["ConvergenceError", "Error", "FileError", "InputError", "SceneError", "SolverError"]


class Error(Exception):
    """Base of all exceptions of the package.

    Attributes
    ----------
    message : str
        What is wrong, where, and what can be done about it.
    field : str or None
        Field of the scene, or argument, that is wrong, such as ``"bolts.load"``.
    value : float, str or None
        Its value, where it is a number or a name.
    unit : str or None
        Unit of the value, where it has one.
    remedy : str or None
        What can be done about it, where the message says so.
    path : str or None
        File or folder that cannot be used.
    history : list of float
        Relative residuals of the iterations that did not converge; empty elsewhere.

    Examples
    --------
    >>> import microslip
    >>> try:
    ...     microslip.Scene.from_dict({"units": "SI"})
    ... except microslip.Error as error:
    ...     print(error.field)
    units
    """

    def __init__(
        self,
        message: str,
        *,
        field: str | None = None,
        value: float | str | None = None,
        unit: str | None = None,
        remedy: str | None = None,
        path: str | None = None,
        history: Sequence[float] = (),
    ) -> None:
        super().__init__(message)
        self.message = message
        self.field = field
        self.value = value
        self.unit = unit
        self.remedy = remedy
        self.path = path
        self.history = list(history)

    def __str__(self) -> str:
        return self.message


class SceneError(Error, ValueError):
    """A scene is malformed, has a value out of range, or does not fit the files that it names.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam")
    >>> try:
    ...     scene.replace({"interfaces.mu": -0.1})
    ... except microslip.SceneError as error:
    ...     print(error.field, error.value, error.remedy)
    interfaces.mu -0.1 it must be finite and not negative
    """


class InputError(Error, ValueError):
    """An argument of a function cannot be what it is meant for.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam")
    >>> try:
    ...     microslip.run(scene, threads=0)
    ... except microslip.InputError as error:
    ...     print(error.field)
    threads
    """


class FileError(Error, OSError):
    """A file or a folder cannot be read or written, or holds something else.

    Examples
    --------
    >>> import microslip
    >>> try:
    ...     microslip.Scene.from_file("nowhere.json")
    ... except microslip.FileError as error:
    ...     print(error.path)
    nowhere.json
    """


class ConvergenceError(Error, ArithmeticError):
    """A nonlinear solve that everything else rests on did not converge, such as that of the prestress.

    Amplitudes of a backbone that do not converge are results, not errors: they are NaN, and ``converged`` is false there.

    Examples
    --------
    >>> import microslip
    >>> issubclass(microslip.ConvergenceError, microslip.Error)
    True
    """


class SolverError(Error, ArithmeticError):
    """Matrices that a solver cannot work on, such as a stiffness that is not positive definite.

    Examples
    --------
    >>> import microslip
    >>> issubclass(microslip.SolverError, microslip.Error)
    True
    """
