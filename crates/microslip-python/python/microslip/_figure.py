"""Figures of matplotlib. This module is loaded when one is made."""

from __future__ import annotations

from io import BytesIO

try:
    from matplotlib.figure import Figure
except ImportError as error:
    raise ImportError("plot needs matplotlib; install it by `pip install microslip[plot]`") from error

__all__: list[str] = []


class Picture(Figure):
    """A figure that notebooks show. It is not made by pyplot, which would keep it and choose a window."""

    def _repr_png_(self) -> bytes:
        png = BytesIO()
        self.savefig(png, format="png")
        return png.getvalue()


def picture(width: float, height: float) -> Picture:
    """An empty figure of this size (inches)."""
    return Picture(figsize=(width, height), layout="constrained")
