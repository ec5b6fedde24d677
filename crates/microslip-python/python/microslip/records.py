"""Measured ring-downs, their backbones, and backbones beside one another."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from microslip import _native
from microslip._arguments import count
from microslip._arguments import seed as _seed
from microslip.errors import InputError
from microslip.results import Backbone, MethodBackbone, Run, _Comparable

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

__all__ = [
    "Channel",
    "Comparison",
    "Difference",
    "Hit",
    "Identification",
    "MeasuredBackbone",
    "Misfit",
    "Record",
    "compare",
    "identify",
    "read_record",
    "synthetic_ring_down",
]

Floats = npt.NDArray[np.float64]
Quantity = Literal["acceleration", "velocity", "displacement"]

_UNITS = {"acceleration": "m/s^2", "velocity": "m/s", "displacement": "m"}
_NativeChannel = tuple[str, str, str | None, float | None, Floats | None, Floats]
_Curve = tuple[str, Floats, Floats, Floats, str]


@dataclass(frozen=True, eq=False)
class Channel(_Comparable):
    """A channel of a record, as it stands in its file.

    Examples
    --------
    >>> import numpy as np
    >>> import microslip
    >>> channel = microslip.Channel("tip", "g", 20480.0, None, np.zeros(100))
    >>> channel.samples.size
    100
    """

    name: str
    """Its name."""
    unit: str | None
    """Its unit as it is written, if it is."""
    sample_rate: float | None
    """Samples per second (Hz), if that is stated."""
    times: Floats | None
    """Times of the samples (s), if those are stated."""
    samples: Floats
    """Samples in that unit, NaN where there are none."""


@dataclass(frozen=True, eq=False)
class Record(_Comparable):
    """What a file of measurements holds.

    Examples
    --------
    >>> import microslip
    >>> microslip.Record("hit.csv", (), ()).channels
    ()
    """

    path: str
    """The file."""
    channels: tuple[Channel, ...]
    """Its channels, in their order. Several of one name are successive hits."""
    notes: tuple[str, ...]
    """What was not read, and what is remarkable."""


def read_record(path: str | os.PathLike[str], channel: str | None = None) -> Record:
    """Read a file of measurements.

    Parameters
    ----------
    path : path-like
        Universal file (58, 58b), MATLAB (v5, v7), NumPy archive, CSV or WAV. The contents tell which.
    channel : str, optional
        Only the channels of this name.

    Raises
    ------
    FileError
        The file cannot be read, or is damaged.
    InputError
        There is no such channel.

    Examples
    --------
    >>> import microslip, numpy as np, pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "hit.npz"
    >>> np.savez(path, tip=np.sin(np.arange(100.0)), fs=1000.0, unit="m/s^2")
    >>> record = microslip.read_record(path)
    >>> [(channel.name, channel.unit, channel.sample_rate) for channel in record.channels]
    [('tip', 'm/s^2', 1000.0)]
    """
    file, channels, notes = _native.read_record(os.fspath(path), channel)
    return Record(file, tuple(Channel(*one) for one in channels), tuple(notes))


@dataclass(frozen=True, eq=False)
class Hit(_Comparable):
    """A ring-down and what was found in it. Points are in the order of time, two per cycle, and have shape ``(n,)``.

    Examples
    --------
    >>> import microslip
    >>> signal = microslip.synthetic_ring_down(50.0, 160.0, 2e-3, fs=8192.0, samples=16384)
    >>> hit = microslip.identify(signal, 8192.0).hits[0]
    >>> round(hit.peak_hz, 1), bool((hit.time[1:] > hit.time[:-1]).all())
    (160.0, True)
    """

    record: str
    """Where it is from."""
    quantity: str
    """What was measured."""
    sample_rate_hz: float
    """Samples per second (Hz)."""
    samples: int
    """Number of samples."""
    time: Floats
    """Time of each point after the first sample (s)."""
    amplitude: Floats
    """Amplitude (SI unit of the quantity of the identification)."""
    frequency_hz: Floats
    """Undamped natural frequency (Hz)."""
    damping_ratio: Floats
    """Damping ratio."""
    peak_hz: float
    """Peak of the spectrum after the hit (Hz)."""
    band_hz: tuple[float, float]
    """Half-power points of the band-pass filter (Hz)."""
    start_s: float
    """Start of what of the record is used (s)."""
    end_s: float
    """Its end (s)."""
    end_reason: str
    """Why it ends there: ``"Filter"``, ``"Noise"``, ``"LaterExcitation"`` or ``"IrregularPeaks"``."""
    noise_amplitude: float
    """Amplitude of the noise in the band (SI unit of what was measured)."""
    cross_check: Mapping[str, float] | None
    """Differences to a second method, if the record is long enough for it."""
    spectrum_step_hz: float
    """Distance of the lines of the spectrum (Hz); the first is at zero."""
    spectrum: Floats
    """Magnitudes of the lines after the hit, before the filter (unit of the signal times s)."""
    warnings: tuple[str, ...]
    """What was noticed."""


@dataclass(frozen=True, eq=False)
class MeasuredBackbone(_Comparable):
    """Frequency and damping against amplitude, from elsewhere, to be compared.

    Examples
    --------
    >>> import microslip
    >>> microslip.MeasuredBackbone([1.0, 10.0], [160.0, 158.0], [1e-3, 4e-3], "velocity").amplitude.tolist()
    [1.0, 10.0]
    """

    amplitude: Floats
    """Amplitudes (SI unit of the quantity)."""
    frequency_hz: Floats
    """Frequencies (Hz)."""
    damping_ratio: Floats
    """Damping ratios, NaN where they are not known."""
    quantity: Quantity = "acceleration"
    """What amplitudes are."""
    name: str = "measured"
    """What it is called."""

    def __post_init__(self) -> None:
        for column in ("amplitude", "frequency_hz", "damping_ratio"):
            object.__setattr__(self, column, np.array(_vector(column, getattr(self, column))))
        super().__post_init__()


@dataclass(frozen=True, eq=False)
class Identification(_Comparable):
    """The backbone of one mode from one or several ring-downs. Arrays run over the amplitudes, ascending, and have shape ``(n,)``.

    Examples
    --------
    >>> import microslip
    >>> signal = microslip.synthetic_ring_down(50.0, 160.0, 2e-3, fs=8192.0, samples=16384)
    >>> found = microslip.identify(signal, 8192.0)
    >>> found
    Identification(acceleration, 1 hit, 160.00 to 160.00 Hz)
    """

    quantity: Quantity
    """What amplitudes are."""
    amplitude: Floats
    """Amplitudes (SI unit of the quantity)."""
    frequency_hz: Floats
    """Undamped natural frequency, the mean of the hits (Hz)."""
    damping_ratio: Floats
    """Damping ratio, the mean of the hits."""
    frequency_spread_hz: Floats
    """Standard deviation of the frequency between the hits (Hz); NaN for a single one."""
    damping_ratio_spread: Floats
    """Standard deviation of the damping ratio between the hits; NaN for a single one."""
    hits_at: npt.NDArray[np.int64]
    """Number of hits that reach each amplitude."""
    hits: tuple[Hit, ...]
    """The ring-downs."""

    @property
    def unit(self) -> str:
        """Unit of the amplitudes.

        Examples
        --------
        >>> import microslip
        >>> signal = microslip.synthetic_ring_down(50.0, 160.0, 2e-3, fs=8192.0, samples=16384)
        >>> microslip.identify(signal, 8192.0, amplitude="velocity").unit
        'm/s'
        """
        return _UNITS[self.quantity]

    @property
    def warnings(self) -> tuple[str, ...]:
        """What was noticed in any of the hits.

        Examples
        --------
        >>> import microslip
        >>> signal = microslip.synthetic_ring_down(50.0, 160.0, 2e-3, fs=8192.0, samples=16384)
        >>> microslip.identify(signal, 8192.0).warnings
        ()
        """
        return tuple(warning for hit in self.hits for warning in hit.warnings)

    def to_pandas(self) -> pandas.DataFrame:
        """The backbone as a table.

        Returns
        -------
        pandas.DataFrame
            One row per amplitude.

        Raises
        ------
        ImportError
            pandas is not installed.

        Examples
        --------
        >>> import microslip
        >>> signal = microslip.synthetic_ring_down(50.0, 160.0, 2e-3, fs=8192.0, samples=16384)
        >>> list(microslip.identify(signal, 8192.0).to_pandas())[:3]
        ['amplitude', 'frequency_hz', 'damping_ratio']
        """
        try:
            import pandas
        except ImportError as error:
            raise ImportError("to_pandas needs pandas; install it by `pip install microslip[pandas]`") from error
        columns = ("amplitude", "frequency_hz", "damping_ratio", "frequency_spread_hz", "damping_ratio_spread", "hits_at")
        return pandas.DataFrame({column: getattr(self, column) for column in columns})

    def plot(self) -> Figure:
        """Draws frequency and damping against amplitude: each hit, the mean, and its spread.

        Returns
        -------
        matplotlib.figure.Figure
            Frequency above damping, with logarithmic amplitudes. It is not shown.

        Raises
        ------
        ImportError
            matplotlib is not installed.

        Examples
        --------
        >>> import microslip
        >>> signal = microslip.synthetic_ring_down(50.0, 160.0, 2e-3, fs=8192.0, samples=16384)
        >>> [axes.get_ylabel() for axes in microslip.identify(signal, 8192.0).plot().axes]
        ['frequency (Hz)', 'damping ratio (-)']
        """
        from microslip._pictures import identification

        return identification(self)

    def __repr__(self) -> str:
        hits = "1 hit" if len(self.hits) == 1 else f"{len(self.hits)} hits"
        low, high = self.frequency_hz.min(), self.frequency_hz.max()
        return f"Identification({self.quantity}, {hits}, {low:.2f} to {high:.2f} Hz)"


_Source = npt.ArrayLike | str | os.PathLike[str] | Record | Channel


def identify(
    record: _Source | Sequence[_Source],
    fs: float | None = None,
    *,
    channel: str | None = None,
    unit: str | None = None,
    frequency: float | None = None,
    bandwidth: float | None = None,
    start: float | None = None,
    smoothing: int = 41,
    noise_margin: float = 50.0,
    amplitude: Quantity | None = None,
    points: int = 200,
) -> Identification:
    """Frequency and damping of one mode against amplitude, from ring-downs.

    The record is filtered backward in time by a Butterworth band-pass, extrema are followed by parabolas, and what the filter did is
    undone. Frequencies are undamped natural ones.

    Parameters
    ----------
    record : array_like, path-like, Record, Channel, or list of these
        A ring-down of shape ``(n,)``, several in the rows of an array of shape ``(hits, n)``, or files of measurements, see
        :func:`read_record`. Several hits are averaged.
    fs : float, optional
        Samples per second (Hz). Arrays need it; files that state it do not.
    channel : str, optional
        Channel of the files to identify; by default the only one.
    unit : str, optional
        Unit of the samples, such as ``"m/s^2"``, ``"g"``, ``"mm/s"``, also with a factor (``"98.1 m/s^2"``). Arrays are in m/s^2 by
        default; files mostly state it.
    frequency : float, optional
        Frequency near which the mode is (Hz); by default the highest peak of the spectrum.
    bandwidth : float, optional
        Width of the band (Hz); by default a ninth of the frequency.
    start : float, optional
        Start of the backbone after the first sample (s); by default a cycle after the hit.
    smoothing : int
        Points per window of the smoothing, two per cycle; odd.
    noise_margin : float
        The backbone ends where the amplitude falls below so many times that of the noise in the band.
    amplitude : {"acceleration", "velocity", "displacement"}, optional
        What amplitudes shall be; by default what was measured.
    points : int
        Amplitudes of the mean of several hits.

    Returns
    -------
    Identification
        With warnings of clipping, dropouts, further hits and modes beside the band.

    Raises
    ------
    InputError
        A setting is out of range, or the record cannot be identified: gaps, missing values, two modes in the band, too few cycles.
    FileError
        A file cannot be read.

    Examples
    --------
    >>> import numpy as np
    >>> import microslip
    >>> t = np.arange(16384) / 8192.0
    >>> found = microslip.identify(30.0 * np.exp(-2.0 * t) * np.cos(2.0 * np.pi * 160.0 * t), fs=8192.0)
    >>> f = np.hypot(160.0, 2.0 / (2.0 * np.pi))
    >>> bool(abs(found.frequency_hz / f - 1.0).max() < 1e-6), bool(abs(found.damping_ratio * 2.0 * np.pi * f - 2.0).max() < 1e-3)
    (True, True)
    """
    channels = list(_channels(record, channel))
    if any(found[0] == _ARRAY for found in channels) and fs is None:
        remedy = "give fs, the samples per second (Hz)"
        raise InputError(f"an array does not state its sample rate; {remedy}", field="fs", remedy=remedy)
    if unit is None:
        # Arrays are in SI; files say themselves.
        channels = [(*found[:2], "m/s^2" if found[0] == _ARRAY else found[2], *found[3:]) for found in channels]
    quantity, table, hits = _native.identify(
        channels,
        unit,
        None if fs is None else float(fs),
        frequency,
        bandwidth,
        start,
        count(smoothing),
        noise_margin,
        amplitude,
        count(points),
    )
    names = ("amplitude", "frequency_hz", "damping_ratio", "frequency_spread_hz", "damping_ratio_spread")
    columns: dict[str, Any] = {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(names)}
    return Identification(
        quantity,  # type: ignore[arg-type]
        **columns,
        hits_at=table[:, 5].astype(np.int64),
        hits=tuple(_hit(*hit) for hit in hits),
    )


def _hit(table: Floats, step: float, spectrum: Floats, about: str) -> Hit:
    said = json.loads(about)
    said["band_hz"] = tuple(said["band_hz"])
    said["warnings"] = tuple(said["warnings"])
    names = ("time", "amplitude", "frequency_hz", "damping_ratio")
    columns: dict[str, Any] = {name: np.ascontiguousarray(table[:, k]) for k, name in enumerate(names)}
    return Hit(**said, **columns, spectrum_step_hz=step, spectrum=spectrum)


#: What arrays are called in messages.
_ARRAY = "the array"


def _channels(record: Any, channel: str | None) -> Sequence[_NativeChannel]:
    """The channels of a source, as the native module takes them."""
    if isinstance(record, Channel):
        return [(f"channel `{record.name}`", record.name, record.unit, record.sample_rate, record.times, record.samples)]
    if isinstance(record, (str, os.PathLike)):
        record = read_record(record)
    if isinstance(record, Record):
        chosen = [one for one in record.channels if channel is None or one.name == channel]
        names = sorted({one.name for one in (chosen or record.channels)})
        if not chosen or len(names) > 1:
            remedy = f"name one of {', '.join(names)}" if names else "give a file with a signal"
            wanted = "which channel to identify is not stated" if channel is None else f"there is no channel `{channel}`"
            raise InputError(f"{record.path}: {wanted}; {remedy}", field="channel", value=channel, remedy=remedy)
        return [(record.path, one.name, one.unit, one.sample_rate, one.times, one.samples) for one in chosen]
    if isinstance(record, (list, tuple)) and any(isinstance(one, (str, os.PathLike, Record, Channel, np.ndarray)) for one in record):
        return [found for one in record for found in _channels(one, channel)]
    try:
        signal = np.asarray(record, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise InputError(f"record cannot be read as numbers: {error}", field="record") from None
    if signal.ndim not in (1, 2):
        remedy = "give one hit of shape (n,), or several in the rows of shape (hits, n)"
        raise InputError(f"record has the shape {signal.shape}; {remedy}", field="record", remedy=remedy)
    return [(_ARRAY, f"hit {k}", None, None, None, hit) for k, hit in enumerate(np.atleast_2d(signal), 1)]


@dataclass(frozen=True)
class Difference:
    """How far a backbone lies from another, over amplitudes equally spaced in their logarithm.

    Examples
    --------
    >>> import microslip
    >>> microslip.Difference(0.1, 0.2, 0.4).rms
    0.2
    """

    mean: float
    """Mean, with its sign."""
    rms: float
    """Root mean square."""
    largest: float
    """Largest magnitude."""


@dataclass(frozen=True, eq=False)
class Misfit(_Comparable):
    """Theory minus one experiment over the amplitudes that both cover. Arrays have shape ``(200,)``.

    Examples
    --------
    >>> import microslip
    >>> theory = microslip.MeasuredBackbone([1.0, 10.0], [160.0, 158.0], [1e-3, 4e-3])
    >>> experiment = microslip.MeasuredBackbone([2.0, 20.0], [161.0, 159.0], [1e-3, 4e-3])
    >>> misfit = microslip.compare(theory, experiment).misfits[0]
    >>> misfit.amplitude.size, round(misfit.frequency_hz.mean, 2)
    (200, -1.6)
    """

    name: str
    """The experiment."""
    amplitude: Floats
    """Amplitudes (SI unit of the quantity of the comparison)."""
    frequency_difference_hz: Floats
    """Difference of frequencies (Hz)."""
    frequency_difference_percent: Floats
    """The same relative to the experiment (%)."""
    damping_difference_ln: Floats
    """Logarithm of the ratio of the damping ratios, NaN where one has none."""
    frequency_hz: Difference
    """Of the difference of frequencies (Hz)."""
    frequency_percent: Difference
    """Of the same relative to the experiment (%)."""
    damping_ln: Difference | None
    """Of the logarithm of the ratio of the damping ratios; None where they share no amplitude."""
    within_band: tuple[float, float] | None
    """Shares of the amplitudes at which frequency and damping of the experiment lie within the band of an ensemble."""
    experiment: Floats
    """Amplitude, frequency (Hz) and damping ratio of the experiment, shape ``(points, 3)``."""


@dataclass(frozen=True, eq=False)
class Comparison(_Comparable):
    """A backbone of theory beside experiments.

    Examples
    --------
    >>> import microslip
    >>> theory = microslip.MeasuredBackbone([1.0, 10.0], [160.0, 158.0], [1e-3, 4e-3])
    >>> microslip.compare(theory, theory).misfits[0].frequency_hz.rms
    0.0
    """

    quantity: Quantity
    """What amplitudes are."""
    name: str
    """The theory."""
    theory: Floats
    """Amplitude, frequency (Hz) and damping ratio of theory, shape ``(points, 3)``."""
    misfits: tuple[Misfit, ...]
    """One per experiment, in their order."""

    def to_pandas(self) -> pandas.DataFrame:
        """The misfits as a table.

        Returns
        -------
        pandas.DataFrame
            One row per experiment.

        Raises
        ------
        ImportError
            pandas is not installed.

        Examples
        --------
        >>> import microslip
        >>> theory = microslip.MeasuredBackbone([1.0, 10.0], [160.0, 158.0], [1e-3, 4e-3])
        >>> microslip.compare(theory, theory).to_pandas()["frequency_rms_hz"].tolist()
        [0.0]
        """
        try:
            import pandas
        except ImportError as error:
            raise ImportError("to_pandas needs pandas; install it by `pip install microslip[pandas]`") from error
        rows = []
        for misfit in self.misfits:
            row: dict[str, Any] = {
                "experiment": misfit.name,
                "amplitude_from": misfit.amplitude[0],
                "amplitude_to": misfit.amplitude[-1],
            }
            for name, unit, difference in (
                ("frequency", "hz", misfit.frequency_hz),
                ("frequency", "percent", misfit.frequency_percent),
                ("damping", "ln", misfit.damping_ln),
            ):
                for part in ("mean", "rms", "largest"):
                    row[f"{name}_{part}_{unit}"] = np.nan if difference is None else getattr(difference, part)
            rows.append(row)
        return pandas.DataFrame(rows)

    def plot(self) -> Figure:
        """Draws theory and experiments: frequency and damping against amplitude.

        Returns
        -------
        matplotlib.figure.Figure
            Frequency above damping, with logarithmic amplitudes and dampings. It is not shown.

        Raises
        ------
        ImportError
            matplotlib is not installed.

        Examples
        --------
        >>> import microslip
        >>> theory = microslip.MeasuredBackbone([1.0, 10.0], [160.0, 158.0], [1e-3, 4e-3])
        >>> len(microslip.compare(theory, theory).plot().axes)
        2
        """
        from microslip._pictures import comparison

        return comparison(self)


_Experiment = Identification | MeasuredBackbone | Backbone | MethodBackbone | Run


def compare(theory: _Experiment, *experiments: _Experiment, amplitude: Quantity | None = None) -> Comparison:
    """How far a backbone lies from measured ones.

    Differences are theory minus experiment, over 200 amplitudes equally spaced in their logarithm over the common range. Between its
    points a backbone is linear over the logarithm of the amplitude, in frequency and in the logarithm of the damping ratio. Amplitudes
    of another quantity are converted with the backbone's own frequency. All must belong to the same point of the structure.

    Parameters
    ----------
    theory : Run, Backbone, MethodBackbone, MeasuredBackbone or Identification
        The backbone that is judged. Of a run the first mode is taken, with first-harmonic frequencies against the motion of the
        response point, and with the bands of its ensemble.
    *experiments
        The same kinds of objects; at least one.
    amplitude : {"acceleration", "velocity", "displacement"}, optional
        What amplitudes are; by default those of the first experiment.

    Returns
    -------
    Comparison
        The misfits, and both backbones over the same quantity.

    Raises
    ------
    InputError
        There is no experiment, a backbone has fewer than two points, or two share no amplitude.

    Examples
    --------
    >>> import microslip
    >>> scene = microslip.Scene.benchmark("brake-reuss-beam/brb-quick").replace({"analyses.backbone.amplitudes": 5})
    >>> run = microslip.run(scene)
    >>> microslip.compare(run, run, amplitude="acceleration").misfits[0].frequency_hz.largest
    0.0
    """
    if not experiments:
        remedy = "give at least one after the theory"
        raise InputError(f"there is no experiment; {remedy}", field="experiments", remedy=remedy)
    judged = _curve(theory, "theory")
    measured = [_curve(experiment, f"experiment {k}") for k, experiment in enumerate(experiments, 1)]
    wanted = measured[0][4] if amplitude is None else amplitude
    band = _band(theory)
    misfits = []
    table = np.zeros((0, 3))
    for curve in measured:
        numbers, within, arrays, (table, of_experiment) = _native.misfit(judged, curve, band, wanted)
        damping = numbers["damping_ln"]
        misfits.append(
            Misfit(
                name=curve[0],
                amplitude=arrays["amplitude"],
                frequency_difference_hz=arrays["frequency_hz"],
                frequency_difference_percent=arrays["frequency_percent"],
                damping_difference_ln=arrays["damping_ln"],
                frequency_hz=Difference(*(numbers["frequency_hz"] or ())),
                frequency_percent=Difference(*(numbers["frequency_percent"] or ())),
                damping_ln=None if damping is None else Difference(*damping),
                within_band=within,
                experiment=of_experiment,
            )
        )
    return Comparison(wanted, judged[0], table, tuple(misfits))  # type: ignore[arg-type]


def _curve(of: _Experiment, place: str) -> _Curve:
    """Name, amplitudes, frequencies, damping ratios and what amplitudes are, of points that have a frequency."""
    if isinstance(of, (Identification, MeasuredBackbone)):
        name = of.name if isinstance(of, MeasuredBackbone) else of.hits[0].record if len(of.hits) == 1 else "measured"
        return (place if name == _ARRAY else name), of.amplitude, of.frequency_hz, of.damping_ratio, of.quantity
    name = of.scene.name if isinstance(of, Run) else place
    table = of.backbone if isinstance(of, Run) else of
    if not isinstance(table, (Backbone, MethodBackbone)):
        remedy = "give a run, a backbone or an identification"
        raise InputError(f"{place} is a {type(of).__name__}; {remedy}", field=place, remedy=remedy)
    amplitude, frequency, damping = table.response_displacement, table.frequency_hz, table.damping_ratio
    if isinstance(table, Backbone) and np.isfinite(table.frequency_first_harmonic_hz).any():
        # What identification of a measured motion sees.
        amplitude, frequency, damping = table.response_motion, table.frequency_first_harmonic_hz, table.damping_ratio_first_harmonic
    found = np.isfinite(amplitude) & np.isfinite(frequency)
    return name, amplitude[found], frequency[found], damping[found], "displacement"


def _band(of: _Experiment) -> list[_Curve] | None:
    """The backbones of 5 and 95 % of a run's ensemble."""
    if not isinstance(of, Run) or of.ensemble is None:
        return None
    ensemble = of.ensemble
    first = ensemble.frequency_first_harmonic_hz
    frequency = np.where(np.isfinite(first), first, ensemble.frequency_hz)
    edges = []
    for name, k in (("5 %", 0), ("95 %", 2)):
        columns = (ensemble.response_displacement, frequency[:, k], ensemble.damping_ratio[:, k])
        edges.append((name, *(np.ascontiguousarray(column) for column in columns), "displacement"))
    return edges  # type: ignore[return-value]


def _vector(name: str, values: Any) -> Floats:
    try:
        found = np.asarray(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} cannot be read as numbers: {error}", field=name) from None
    if found.ndim != 1:
        remedy = "give a list of numbers"
        raise InputError(f"{name} has the shape {found.shape}; {remedy}", field=name, remedy=remedy)
    return found


def synthetic_ring_down(
    amplitude: float,
    frequency: npt.ArrayLike,
    damping_ratio: npt.ArrayLike,
    over: npt.ArrayLike | None = None,
    *,
    fs: float,
    samples: int,
    phase: float = 0.0,
    noise: float = 0.0,
    seed: int = 0,
) -> Floats:
    """A mode that rings down with known frequency and damping, to try identification with.

    The signal is ``A cos(phi)`` with ``A' = -zeta omega A`` and ``phi' = omega sqrt(1 - zeta^2)``.

    Parameters
    ----------
    amplitude : float
        Amplitude at the start, in any unit.
    frequency : float or array_like
        Undamped natural frequency (Hz), at the amplitudes ``over``.
    damping_ratio : float or array_like
        Damping ratio at the same amplitudes.
    over : array_like, optional
        Ascending amplitudes. Between them frequency and damping are linear over the logarithm of the amplitude, beyond them
        constant.
    fs : float
        Samples per second (Hz).
    samples : int
        Number of samples.
    phase : float
        Phase at the start (rad).
    noise : float
        Standard deviation of Gaussian noise that is added.
    seed : int
        The same seed gives the same noise.

    Returns
    -------
    numpy.ndarray
        The samples, shape ``(samples,)``.

    Raises
    ------
    InputError
        The curves do not fit one another, or a number is out of range.

    Examples
    --------
    >>> import microslip
    >>> signal = microslip.synthetic_ring_down(100.0, [161.0, 158.0], [1e-3, 5e-3], over=[1.0, 100.0], fs=8192.0, samples=16384)
    >>> signal.shape, round(float(signal[0]), 6)
    ((16384,), 100.0)
    """
    at = np.array([amplitude], dtype=np.float64) if over is None else _vector("over", over)
    curves = [_vector(name, np.atleast_1d(np.asarray(values))) for name, values in (("frequency", frequency), ("damping_ratio", damping_ratio))]
    return _native.synthetic_ring_down(
        float(amplitude), (at, curves[0], curves[1]), float(fs), count(samples), float(phase), float(noise), _seed(seed)
    )
