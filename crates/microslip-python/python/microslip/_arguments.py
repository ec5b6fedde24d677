"""Whole numbers as the native module takes them."""

from __future__ import annotations

from microslip.errors import InputError

__all__: list[str] = []


def count(number: int) -> int:
    """A number that counts something: beyond 64 bits the nearest that is refused all the same."""
    return max(-1, min(number, 2**62))


def seed(number: int) -> int:
    """The seed of a generator."""
    if not 0 <= number < 2**64:
        remedy = "it must be from 0 to 2^64 - 1"
        raise InputError(f"seed = {number} is not admissible; {remedy}", field="seed", remedy=remedy)
    return number
