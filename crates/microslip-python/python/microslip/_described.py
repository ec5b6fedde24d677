"""Objects that are described by the arguments they were made with."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip.errors import InputError

__all__: list[str] = []

#: Longer lists are shown by their shape.
_SHOWN = 6

_T = TypeVar("_T", bound="Described")


def values(name: str, value: ArrayLike, *, ndim: int = 1) -> NDArray[np.float64]:
    """A contiguous copy of an argument; with ``ndim=1`` a number becomes a list of one."""
    found = array(name, value)
    if found.ndim == 0 and ndim == 1:
        found = found[np.newaxis]
    if found.ndim != ndim:
        raise InputError(f"{name} has the shape {found.shape}, but {ndim} dimensions are needed")
    found = np.array(found)
    found.setflags(write=False)
    return found


def array(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """An argument as contiguous array of float64, without a copy where it is one."""
    if isinstance(value, np.ndarray) and value.dtype == np.float64:
        # Unlike ascontiguousarray it leaves numbers numbers.
        return np.asarray(value, order="C")
    try:
        found = np.asarray(value)
    except ValueError as error:
        raise InputError(f"{name} cannot be read as numbers: {error}") from None
    if found.dtype.kind not in "biuf":
        raise InputError(f"{name} cannot be read as real numbers: it is of the type {found.dtype}")
    return np.asarray(found, dtype=np.float64, order="C")


class Result:
    """Base of dataclasses of arrays: shown without their contents."""

    def __repr__(self) -> str:
        shown = ", ".join(f"{field}={_show(getattr(self, field))}" for field in self.__dataclass_fields__)  # type: ignore[attr-defined]
        return f"{type(self).__name__}({shown})"


class Described:
    """Base of objects that never change: shown, compared and pickled by the arguments they were made with."""

    _arguments: Mapping[str, Any]

    def _describe(self, **arguments: Any) -> None:
        self._arguments = MappingProxyType(arguments)

    @property
    def arguments(self) -> Mapping[str, Any]:
        """The arguments by name, as they were understood."""
        return self._arguments

    def __repr__(self) -> str:
        shown = ", ".join(f"{name}={_show(value)}" for name, value in self._arguments.items() if value is not None)
        return f"{type(self).__name__}({shown})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Described) or type(other) is not type(self):
            return NotImplemented
        mine, its = self._arguments, other._arguments
        return all(_same(mine[name], its[name]) for name in mine)

    def __hash__(self) -> int:
        return hash((type(self), tuple(self._arguments)))

    def __reduce__(self) -> tuple[Any, ...]:
        return _remake, (type(self), dict(self._arguments))


def _remake(cls: type[_T], arguments: dict[str, Any]) -> _T:
    return cls(**arguments)


def _show(value: Any) -> str:
    if isinstance(value, np.ndarray):
        if value.size == 1 and value.ndim == 1:
            return repr(value.item())
        return repr(value.tolist()) if value.size <= _SHOWN else f"<array of shape {value.shape}>"
    if hasattr(value, "tocsr"):
        return f"<sparse matrix of shape {value.shape}>"
    if isinstance(value, tuple) and len(value) > _SHOWN:
        return f"<{len(value)} entries>"
    if isinstance(value, tuple):
        return "(" + ", ".join(_show(entry) for entry in value) + ("," if len(value) == 1 else "") + ")"
    return repr(value)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return bool(np.array_equal(a, b))
    if hasattr(a, "tocsr") and hasattr(b, "tocsr"):
        return bool(a.shape == b.shape and (a != b).nnz == 0)
    return bool(a is b or (type(a) is type(b) and np.all(a == b)))
