"""
Functions and classes that the Python modules of the package are made of.
"""

import collections.abc
import numpy
import numpy.typing
from typing import final

@final
class Run:
    """
    A finished run.
    """
    def fields(self, /) -> list[list[tuple[int, tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.uint8], numpy.typing.NDArray[numpy.float64]]]]]:
        """
        Per mode followed, the amplitudes of which fields were stored: their numbers from 1, and the fields as in `prestress`.
        """
    def geometry(self, /) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64] | None, numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64] | None, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.float64] | None, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64] | None]:
        """
        The interface: nodes in its plane and in the model, nodes of elements, points in its plane and in the model, their areas, elements
        and gaps, the frame and the frames of the nodes.
        """
    def prestress(self, /) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.uint8], numpy.typing.NDArray[numpy.float64]]:
        """
        Fields of the static state: jump, traction, regime, flux.
        """
    def save(self, /, directory: str, overwrite: bool) -> None:
        """
        Writes the files of the run into a folder.
        """
    def summary(self, /) -> str:
        """
        The summary as JSON.
        """

@final
class Scene:
    """
    A scene that was checked, in SI.
    """
    @staticmethod
    def benchmark(name: str) -> Scene:
        """
        A scene that comes with a benchmark.
        """
    @staticmethod
    def from_file(path: str) -> Scene:
        """
        The scene in a file.
        """
    @staticmethod
    def from_json(text: str, place: str, name: str, directory: str | None) -> Scene:
        """
        The scene in a text, of which relative paths start from a folder; errors name `place`.
        """
    @staticmethod
    def from_state(scene: str, source: str) -> Scene:
        """
        What `state` gave.
        """
    @property
    def name(self, /) -> str:
        """
        Its name.
        """
    def state(self, /) -> tuple[str, str]:
        """
        The scene with all defaults, and the file that it is from, as JSON.
        """

def benchmarks() -> list[str]:
    """
    Names of the scenes that come with the package, as `BENCHMARK/SCENE`.
    """

def run(scene: Scene, progress: collections.abc.Callable[[str, float], object] | None, threads: int | None, cache: bool | str, ensemble: int | None, out: str | None, overwrite: bool) -> Run:
    """
    Runs a scene.

    `cache` is a folder, `True` for that of the user, or `False` for none.
    """

def version() -> str:
    """
    The version of the package.
    """

__all__ = [
    "Run",
    "Scene",
    "benchmarks",
    "run",
    "version",
]
