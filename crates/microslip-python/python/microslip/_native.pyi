"""
Functions and classes that the Python modules of the package are made of.
"""

from _typeshed import SupportsGetItem, SupportsLenAndGetItem
import collections.abc
import numpy
import numpy.typing
from typing import Any, SupportsFloat, SupportsIndex, final

@final
class Curves:
    """
    Contact curves of all points.
    """
    def __len__(self, /) -> int:
        """
        Number of parameter sets.
        """
    @staticmethod
    def asperity_sum(gaps: Any, probabilities: Any | None, asperity_density: Any, beta_x: Any, beta_y: Any, youngs_modulus: Any, poisson_ratio: Any, reading: str) -> Curves:
        """
        Sums over asperities whose gaps are samples, or with `probabilities` quantiles.
        """
    @staticmethod
    def elastic(k_n: Any, k_x: Any, k_y: Any) -> Curves:
        """
        Constant stiffnesses.
        """
    @staticmethod
    def fitted(normal: SupportsLenAndGetItem[Any], tangential_x: SupportsLenAndGetItem[Any], tangential_y: SupportsLenAndGetItem[Any], u_ref: Any, ranges: SupportsLenAndGetItem[SupportsLenAndGetItem[SupportsFloat | SupportsIndex]] | None, ends: str) -> Curves:
        """
        Fitted curves; `ranges` are lower and upper ends of the normal fit, of that along x and of that along y, or nothing.
        """
    @staticmethod
    def greenwood_williamson(heights: str, scale: Any, reference_height: Any, asperity_density: Any, beta_x: Any, beta_y: Any, youngs_modulus: Any, poisson_ratio: Any, reading: str) -> Curves:
        """
        Closed forms for exponential or Gaussian heights.
        """
    @staticmethod
    def sampled(interferences: SupportsGetItem[int, SupportsFloat | SupportsIndex], tractions: SupportsGetItem[int, SupportsFloat | SupportsIndex], areas: SupportsGetItem[int, SupportsFloat | SupportsIndex], tangential_ratio: SupportsFloat | SupportsIndex) -> Curves:
        """
        Curves through points.
        """
    @staticmethod
    def table(source: Curves, range: SupportsLenAndGetItem[SupportsFloat | SupportsIndex], tolerance_normal: SupportsFloat | SupportsIndex, tolerance_tangential: SupportsFloat | SupportsIndex, max_knots_per_octave: SupportsIndex) -> Curves:
        """
        Tables of other curves between two interferences.
        """
    def table_errors(self, /) -> tuple[float, float] | None:
        """
        Largest relative errors of normal traction and tangential stiffness that tables have in their range; none of other curves.
        """

@final
class Law:
    """
    A traction law over a number of points. It never changes.
    """
    def about(self, /, jump: numpy.typing.NDArray[numpy.float64], state: numpy.typing.NDArray[numpy.float64]) -> tuple[list[numpy.typing.NDArray[numpy.float64]], list[bool]]:
        """
        What [`Self::linearised`] takes, of this law about a static state.
        """
    def derivative(self, /, jump: Any, begin: Any, d_jump: Any, d_begin: Any, sticking: str, traction: Any, end: Any, d_traction: Any, d_end: Any) -> None:
        """
        The same, with the change of tractions and end state along a direction.
        """
    def evaluate(self, /, jump: Any, begin: Any, sticking: str, traction: Any, tangent: Any | None, end: Any) -> None:
        """
        Tractions, end state and, where there is an array for it, the tangent; the arrays are written.
        """
    @staticmethod
    def foundation(curves: Curves, mu: Any, ratio: SupportsFloat | SupportsIndex, n_springs: SupportsIndex, reach: SupportsFloat | SupportsIndex, n_points: SupportsIndex | None, index: Any | None) -> Law:
        """
        Springs of contact curves.
        """
    @staticmethod
    def frictional(curves: Curves, mu: Any, history: str, cone: str, n_points: SupportsIndex | None, index: Any | None) -> Law:
        """
        Contact curves with a history rule of friction.
        """
    def info(self, /) -> tuple[str, str, list[tuple[str, str]], list[tuple[str, str]]]:
        """
        Name, reference, state and parameters.
        """
    @staticmethod
    def linearised(jump: Any, traction: Any, stiffness: Any, slip_limit: Any, closed: SupportsGetItem[int, bool]) -> Law:
        """
        Linearised contact; what is 3 x n has a row for each of x, y, n, and `closed` tells points that are in contact.
        """
    @property
    def n_points(self, /) -> int: ...
    @property
    def n_state(self, /) -> int: ...
    def regimes(self, /, jump: numpy.typing.NDArray[numpy.float64], begin: numpy.typing.NDArray[numpy.float64]) -> numpy.typing.NDArray[numpy.uint8]:
        """
        Regimes of the points: 0 stick, 1 slip, 2 open, 3 input that is not finite.
        """
    @staticmethod
    def resolved(gaps: Any, densities: Any, radius: SupportsFloat | SupportsIndex, youngs_modulus: SupportsFloat | SupportsIndex, poisson_ratio: SupportsFloat | SupportsIndex, yielding: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex, str] | None, mu: Any, history: str, annuli: SupportsIndex | None, radii: SupportsIndex | None, cone: str, slip_limit: str, n_points: SupportsIndex | None, index: Any | None) -> Law:
        """
        Asperities bin by bin; `gaps` and `densities` are bins x sets.
        """

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

@final
class Structure:
    """
    A structure with points of contact. It never changes.
    """
    def __new__(cls, /, stiffness: Any, mass: Any, jump: Any, areas: Any, law: Law, gap: Any, interference: Any, loads: Any, recover: Any, n_modes: SupportsIndex | None, zero_energy_modes: SupportsIndex, attachment_modes: bool | None, threads: SupportsIndex | None) -> Structure: ...
    def reduced(self, /) -> dict[str, Any]:
        """
        The reduced matrices without the components of the jump that are held, and what goes with them.
        """

def benchmarks() -> list[str]:
    """
    Names of the scenes that come with the package, as `BENCHMARK/SCENE`.
    """

def characterise(top: tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None], bottom: tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None], nodes: numpy.typing.NDArray[numpy.float64], elements: numpy.typing.NDArray[numpy.int64], settings: str) -> tuple[dict[str, numpy.typing.NDArray[numpy.float64]], dict[str, numpy.typing.NDArray[numpy.float64]], dict[str, numpy.typing.NDArray[numpy.float64]], list[numpy.typing.NDArray[numpy.float64]], str]:
    """
    Characterises two maps over the elements of a plane mesh, whose rows may end with -1.

    Per element: arrays by name, those of the top and of the bottom face, heights of the peaks, fallbacks of the fits; and as JSON
    the whole faces.
    """

def identify(channels: collections.abc.Sequence[tuple[str, str, str | None, float | None, numpy.typing.NDArray[numpy.float64] | None, numpy.typing.NDArray[numpy.float64]]], unit: str | None, sample_rate: float | None, frequency: float | None, bandwidth: float | None, start: float | None, smoothing: int, noise_margin: float, amplitude: str | None, points: int) -> tuple[str, numpy.typing.NDArray[numpy.float64], list[tuple[numpy.typing.NDArray[numpy.float64], float, numpy.typing.NDArray[numpy.float64], str]]]:
    """
    The backbone of one mode in several hits: what amplitudes are; amplitudes, frequencies, damping ratios, their spreads and numbers of
    hits; and for each hit its backbone with times, its spectrum with the distance of its lines, and more as JSON.
    """

def misfit(theory: tuple[str, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], str], reference: tuple[str, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], str], band: collections.abc.Sequence[tuple[str, numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], str]] | None, amplitude: str) -> tuple[dict[str, tuple[float, float, float] | None], tuple[float, float] | None, dict[str, numpy.typing.NDArray[numpy.float64]], tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]]:
    """
    How far a backbone lies from a reference, over amplitudes of a quantity: by name mean, root mean square and largest, and the arrays
    that they are of; the shares of the reference that lie within a band; and both backbones.
    """

def press(map: tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None], pressures: collections.abc.Sequence[float]) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], list[int]]:
    """
    Contact of heights on a half-space by boundary elements, at mean pressures over the contact modulus: mean gaps (m), parts of the area in contact, points that
    touch.
    """

def read_matrices(path: str) -> tuple[list[tuple[str, object]], list[str]]:
    """
    The arrays of a file by name, sparse matrices as shape, starts of rows, columns and entries; and what was not read.
    """

def read_mesh(path: str) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.int64], list[tuple[str, numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.int64]]], list[tuple[str, numpy.typing.NDArray[numpy.int64]]], list[tuple[str, numpy.typing.NDArray[numpy.int64]]], list[tuple[str, numpy.typing.NDArray[numpy.int64]]], numpy.typing.NDArray[numpy.int64], list[str]]:
    """
    The solids in a file and its named groups.
    """

def read_record(path: str, channel: str | None) -> tuple[str, list[tuple[str, str | None, float | None, numpy.typing.NDArray[numpy.float64] | None, numpy.typing.NDArray[numpy.float64]]], list[str]]:
    """
    All channels in a file, or those of one name: the file, the channels, and what is worth knowing.
    """

def read_scan(path: str, format: str | None, lateral_unit: str | None, height_unit: str | None, lateral_step: tuple[float, float] | None, first_row: str | None, layer: int | None, array: str | None, header_lines: int | None, accept_implausible: bool) -> tuple[tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None], str]:
    """
    The scan in a file: the map, and as JSON what the file says about it.
    """

def reduced_model(scene: Scene, progress: collections.abc.Callable[[str, float], object] | None, threads: int | None, cache: bool | str) -> list[tuple[str, object]]:
    """
    The reduced model of a scene as arrays by name.
    """

def run(scene: Scene, progress: collections.abc.Callable[[str, float], object] | None, threads: int | None, cache: bool | str, ensemble: int | None, out: str | None, overwrite: bool) -> Run:
    """
    Runs a scene.

    `cache` is a folder, `True` for that of the user, or `False` for none.
    """

def run_cqsma(structure: Structure, modal_amplitudes: SupportsGetItem[int, SupportsFloat | SupportsIndex], mode: SupportsIndex, n_linear_modes: SupportsIndex, closure: SupportsFloat | SupportsIndex | None, vertices_per_quarter: SupportsIndex, cycles: SupportsIndex | None, until_closed: SupportsFloat | SupportsIndex, max_cycles: SupportsIndex, commit: str, tolerance: SupportsFloat | SupportsIndex, max_iterations: SupportsIndex, threads: SupportsIndex | None) -> dict[str, Any]:
    """
    Hysteresis loops of a mode, at amplitudes that hold by linear estimate.
    """

def run_epmc(structure: Structure, modal_amplitudes: SupportsGetItem[int, SupportsFloat | SupportsIndex], mode: SupportsIndex, n_linear_modes: SupportsIndex, closure: SupportsFloat | SupportsIndex | None, sampling: SupportsLenAndGetItem[SupportsIndex], accuracy: SupportsLenAndGetItem[SupportsFloat | SupportsIndex] | None, max_sampling: SupportsLenAndGetItem[SupportsIndex], tolerance: SupportsFloat | SupportsIndex, max_iterations: SupportsIndex, static_tolerance: SupportsFloat | SupportsIndex, threads: SupportsIndex | None) -> dict[str, Any]:
    """
    Free periodic motions at modal amplitudes.
    """

def run_transient(structure: Structure, release: SupportsFloat | SupportsIndex | None, pulse: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex] | None, mode: SupportsIndex, n_linear_modes: SupportsIndex, closure: SupportsFloat | SupportsIndex | None, steps_per_period: SupportsIndex, periods: SupportsIndex, spectral_radius: SupportsFloat | SupportsIndex, background_damping: SupportsFloat | SupportsIndex, other_damping: SupportsFloat | SupportsIndex, tolerance: SupportsFloat | SupportsIndex, max_iterations: SupportsIndex, static_tolerance: SupportsFloat | SupportsIndex, threads: SupportsIndex | None) -> dict[str, Any]:
    """
    The motion after a release (a modal amplitude) or a pulse (impulse and duration), along the first row that is recovered; a
    pulse acts along the last one.
    """

def synthetic_face(points: tuple[int, int], step: tuple[float, float], origin: tuple[float, float], rms: float, correlation_length: tuple[float, float], waviness: collections.abc.Sequence[tuple[float, float, float, float]], tilt: tuple[float, float], height_step: float | None, seed: int) -> tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None]:
    """
    A seeded Gaussian face.
    """

def synthetic_ring_down(amplitude: float, over: tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]], sample_rate: float, samples: int, phase: float, noise: float, seed: int) -> numpy.typing.NDArray[numpy.float64]:
    """
    A ring-down whose frequency (Hz) and damping ratio are linear in the logarithm of the amplitude between the given ones, and constant
    beyond; with Gaussian noise.
    """

def time_law(law: Law, jump: Any, begin: Any, traction: Any, tangent: Any, end: Any, repeats: SupportsIndex) -> list[float]:
    """
    Seconds that each of `repeats` evaluations with tangent takes without Python in between, on the same arrays: what calls from
    Python are compared with.
    """

def version() -> str:
    """
    The version of the package.
    """

def write_matrices(path: str, arrays: list[tuple[str, object]]) -> None:
    """
    Writes arrays into one file, of which the extension names the format.
    """

def write_mesh(path: str, nodes: numpy.typing.NDArray[numpy.float64], cells: list[tuple[str, numpy.typing.NDArray[numpy.int64], numpy.typing.NDArray[numpy.int64]]], volumes: list[tuple[str, numpy.typing.NDArray[numpy.int64]]], surfaces: list[tuple[str, numpy.typing.NDArray[numpy.int64]]], points: list[tuple[str, numpy.typing.NDArray[numpy.int64]]], point_fields: list[tuple[str, numpy.typing.NDArray[numpy.float64]]], cell_fields: list[tuple[str, numpy.typing.NDArray[numpy.float64]]]) -> None:
    """
    Writes a mesh for Gmsh or VTK. Fields go with VTK, groups of faces and nodes with Gmsh; groups of cells are disjoint.
    """

def write_scan(path: str, map: tuple[numpy.typing.NDArray[numpy.float64], tuple[float, float], tuple[float, float], float | None]) -> None:
    """
    Writes a map as X3P, or as text with a line of heights per line along x.
    """

__all__ = [
    "Curves",
    "Law",
    "Run",
    "Scene",
    "Structure",
    "benchmarks",
    "characterise",
    "identify",
    "misfit",
    "press",
    "read_matrices",
    "read_mesh",
    "read_record",
    "read_scan",
    "reduced_model",
    "run",
    "run_cqsma",
    "run_epmc",
    "run_transient",
    "synthetic_face",
    "synthetic_ring_down",
    "time_law",
    "version",
    "write_matrices",
    "write_mesh",
    "write_scan",
]
