"""Ring-downs, their backbones, and comparisons."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import microslip

FS = 8192.0


def chirp(amplitude: float, f0: float, slope: float, sigma: float, n: int = 16384, phase: float = 0.3) -> tuple[np.ndarray, np.ndarray]:
    """A decay at a constant rate whose damped frequency rises linearly in time, and that frequency (Hz)."""
    t = np.arange(n) / FS
    return amplitude * np.exp(-sigma * t) * np.cos(2 * np.pi * (f0 * t + 0.5 * slope * t**2) + phase), f0 + slope * t


def test_a_decaying_chirp_is_identified() -> None:
    amplitude, f0, slope, sigma = 40.0, 160.0, 2.0, 1.5
    signal, damped = chirp(amplitude, f0, slope, sigma)
    found = microslip.identify(signal, FS)
    assert found.quantity == "acceleration" and found.unit == "m/s^2" and not found.warnings
    (hit,) = found.hits
    # At each time amplitude and frequency are known in closed form.
    of_time = np.interp(hit.time, np.arange(len(damped)) / FS, damped)
    omega = np.hypot(2 * np.pi * of_time, sigma)
    np.testing.assert_allclose(hit.amplitude, amplitude * np.exp(-sigma * hit.time), rtol=2e-3)
    np.testing.assert_allclose(hit.frequency_hz, omega / (2 * np.pi), rtol=1e-5)
    np.testing.assert_allclose(hit.damping_ratio, sigma / omega, rtol=2e-3)
    # The backbone has the same points, by ascending amplitude.
    np.testing.assert_array_equal(found.amplitude, hit.amplitude[::-1])
    assert np.isnan(found.frequency_spread_hz).all() and (found.hits_at == 1).all()
    assert hit.cross_check is not None and hit.cross_check["frequency_median_hz"] < 1e-3
    assert hit.band_hz[0] < f0 < hit.band_hz[1] and hit.end_reason == "Filter"
    # The peak of the spectrum is there.
    k = int(np.argmax(hit.spectrum))
    assert abs(k * hit.spectrum_step_hz - hit.peak_hz) < hit.spectrum_step_hz


def test_amplitudes_of_another_quantity_are_divided_by_the_frequency() -> None:
    signal, _ = chirp(40.0, 160.0, 0.0, 1.5)
    acceleration = microslip.identify(signal, FS)
    displacement = microslip.identify(signal, FS, amplitude="displacement")
    assert displacement.unit == "m"
    omega = 2 * np.pi * acceleration.frequency_hz
    np.testing.assert_allclose(displacement.amplitude * omega**2, acceleration.amplitude, rtol=1e-12)
    in_g = microslip.identify(signal / 9.80665, FS, unit="g")
    np.testing.assert_allclose(in_g.amplitude, acceleration.amplitude, rtol=1e-12)
    moving = microslip.identify(signal, FS, unit="mm/s")
    assert moving.quantity == "velocity"
    np.testing.assert_allclose(moving.amplitude, 1e-3 * acceleration.amplitude, rtol=1e-12)


def test_hits_are_averaged() -> None:
    hits = np.array([microslip.synthetic_ring_down(a, 160.0, 2e-3, fs=FS, samples=16384, noise=0.01, seed=k) for k, a in enumerate((40.0, 30.0))])
    found = microslip.identify(hits, FS, points=50)
    assert len(found.hits) == 2 and set(found.hits_at) <= {1, 2} and len(found.amplitude) <= 50
    np.testing.assert_allclose(found.frequency_hz, 160.0, rtol=1e-4)
    both = found.hits_at == 2
    assert np.isfinite(found.frequency_spread_hz[both]).all() and np.isnan(found.frequency_spread_hz[~both]).all()
    listed = microslip.identify([hits[0], hits[1]], FS, points=50)
    assert listed == found and pickle.loads(pickle.dumps(found)) == found
    assert "2 hits" in repr(found)


def test_records_are_read_from_files(tmp_path: Path) -> None:
    signal, _ = chirp(40.0, 160.0, 1.0, 1.5)
    t = np.arange(len(signal)) / FS
    np.savetxt(tmp_path / "hit.csv", np.column_stack([t, signal, 0 * t]), fmt="%.17g", delimiter=",", header="time [s],tip:+Z [m/s^2],force [N]", comments="")
    np.savez(tmp_path / "hit.npz", tip=signal, fs=FS, unit="m/s^2")
    record = microslip.read_record(tmp_path / "hit.csv")
    assert [channel.name for channel in record.channels] == ["tip:+Z", "force"]
    assert record.channels[0].times is not None and record.channels[0].sample_rate is None
    np.testing.assert_array_equal(record.channels[0].samples, signal)
    chosen = microslip.read_record(tmp_path / "hit.csv", "tip:+Z")
    assert len(chosen.channels) == 1 and "one value throughout" in chosen.notes[0]
    array = microslip.identify(signal, FS)
    for found in (
        microslip.identify(tmp_path / "hit.csv", channel="tip:+Z"),
        microslip.identify(record.channels[0]),
        microslip.identify(record, channel="tip:+Z"),
        microslip.identify(tmp_path / "hit.npz"),
    ):
        np.testing.assert_allclose(found.frequency_hz, array.frequency_hz, rtol=1e-9)
    with pytest.raises(microslip.InputError, match="name one of force, tip") as caught:
        microslip.identify(record)
    assert caught.value.field == "channel"
    with pytest.raises(microslip.InputError, match="no channel"):
        microslip.read_record(tmp_path / "hit.csv", "side")
    with pytest.raises(microslip.InputError, match="no channel `side`"):
        microslip.identify(record, channel="side")
    with pytest.raises(microslip.FileError, match="nowhere"):
        microslip.identify(tmp_path / "nowhere.uff")


def test_synthetic_ring_downs_are_found_again() -> None:
    over, frequency, damping = [0.1, 1.0, 10.0, 100.0], [161.0, 161.0, 160.0, 157.0], [1e-3, 1e-3, 2e-3, 6e-3]
    signal = microslip.synthetic_ring_down(80.0, frequency, damping, over, fs=FS, samples=40000, phase=0.4)
    found = microslip.identify(signal, FS, smoothing=21)
    inner = (found.amplitude > 0.3) & (abs(np.log10(found.amplitude) % 1 - 0.5) < 0.4)
    expected = np.interp(np.log(found.amplitude), np.log(over), frequency)
    np.testing.assert_allclose(found.frequency_hz[inner], expected[inner], rtol=2e-4)
    expected = np.interp(np.log(found.amplitude), np.log(over), damping)
    np.testing.assert_allclose(found.damping_ratio[inner], expected[inner], rtol=0.05)


WRONG = [
    ({"fs": None}, "fs", "fs, the samples per second"),
    ({"fs": -1.0}, None, "must be positive"),
    ({"frequency": -5.0}, "frequency", "frequency is -5 Hz"),
    ({"bandwidth": 1e6}, "bandwidth", "0.4 of the sample rate"),
    ({"bandwidth": 1e-12}, None, "Hz; it must be"),
    ({"bandwidth": 1e-7}, None, "at least|peak"),
    ({"points": 2**70}, "points", "from 2"),
    ({"start": 100.0}, "start", "length of the record"),
    ({"smoothing": 40}, "smoothing", "odd and at least 5"),
    ({"smoothing": -1}, "smoothing", "smoothing"),
    ({"smoothing": 10**15 + 1}, "smoothing", "number of samples, 16384"),
    ({"noise_margin": 0.5}, "noise_margin", "at least 1"),
    ({"amplitude": "force"}, "amplitude", "acceleration, velocity, displacement"),
    ({"unit": "V"}, None, "unit `V`"),
    ({"points": 1}, "points", "from 2"),
    ({"frequency": 3000.0, "bandwidth": 10.0}, None, "cycles|peak"),
]


@pytest.mark.parametrize(("arguments", "field", "message"), WRONG)
def test_wrong_settings_are_named(arguments: dict[str, object], field: str | None, message: str) -> None:
    signal, _ = chirp(40.0, 160.0, 0.0, 1.5)
    with pytest.raises(microslip.InputError, match=message) as caught:
        microslip.identify(signal, **{"fs": FS, **arguments})  # type: ignore[arg-type]
    if field is not None:
        assert caught.value.field == field


def test_wrong_signals_are_named() -> None:
    signal, _ = chirp(40.0, 160.0, 0.0, 1.5)
    broken = signal.copy()
    broken[17] = np.nan
    for record, message in [
        (broken, "sample 18 is NaN"),
        (np.ones(100), "all 100 samples"),
        (np.zeros(3), "at least 16"),
        (np.zeros((2, 3, 4)), "shape"),
        ("text".split(), "nowhere|text"),
        ([["a", "b"]], "numbers"),
        ([], "samples"),
    ]:
        with pytest.raises(microslip.Error, match=message):
            microslip.identify(record, FS)  # type: ignore[arg-type]
    with pytest.raises(microslip.InputError, match="ascending"):
        microslip.synthetic_ring_down(1.0, [160.0, 150.0], [1e-3, 1e-3], [2.0, 1.0], fs=FS, samples=100)
    with pytest.raises(microslip.InputError, match="samples"):
        microslip.synthetic_ring_down(1.0, 160.0, 1e-3, fs=FS, samples=-1)
    with pytest.raises(microslip.InputError, match="seed"):
        microslip.synthetic_ring_down(1.0, 160.0, 1e-3, fs=FS, samples=10, seed=-1)
    with pytest.raises(microslip.InputError, match="sample_rate"):
        microslip.synthetic_ring_down(1.0, 160.0, 1e-3, fs=0.0, samples=10)


def test_a_backbone_compared_with_itself_is_zero(quick_run: microslip.Run) -> None:
    backbone = quick_run.backbone
    for amplitude in ("displacement", "velocity", "acceleration"):
        comparison = microslip.compare(quick_run, backbone, quick_run, amplitude=amplitude)  # type: ignore[arg-type]
        assert comparison.quantity == amplitude and len(comparison.misfits) == 2
        for misfit in comparison.misfits:
            for difference in (misfit.frequency_hz, misfit.frequency_percent, misfit.damping_ln):
                assert difference == microslip.Difference(0.0, 0.0, 0.0)
            assert not misfit.frequency_difference_hz.any() and misfit.amplitude.shape == (200,)
            assert misfit.within_band is None
            assert misfit.amplitude[0] == comparison.theory[0, 0] and misfit.amplitude[-1] == comparison.theory[-1, 0]
    assert pickle.loads(pickle.dumps(comparison)) == comparison


def test_known_differences_are_found() -> None:
    a = np.geomspace(1e-6, 1e-3, 13)
    # Linear in ln A and in ln zeta: interpolation is exact, whatever the points.
    theory = microslip.MeasuredBackbone(a, 170.0 - np.log(a), 3.0 * a, "displacement", "theory")
    b = 1.1 * np.geomspace(1e-5, 1e-2, 13)
    experiment = microslip.MeasuredBackbone(b, 169.5 - np.log(b), 2.0 * b, "displacement")
    comparison = microslip.compare(theory, experiment)
    (misfit,) = comparison.misfits
    assert misfit.name == "measured" and comparison.name == "theory"
    assert misfit.amplitude[0] == pytest.approx(1.1e-5) and misfit.amplitude[-1] == pytest.approx(1e-3)
    np.testing.assert_allclose(misfit.frequency_difference_hz, 0.5, rtol=1e-9)
    np.testing.assert_allclose(misfit.damping_difference_ln, np.log(1.5), rtol=1e-9)
    assert misfit.frequency_hz.mean == pytest.approx(0.5) and misfit.damping_ln is not None
    assert misfit.damping_ln.rms == pytest.approx(np.log(1.5)) == misfit.damping_ln.largest
    none = microslip.compare(theory, microslip.MeasuredBackbone(b, 169.5 - np.log(b), np.full(13, np.nan), "displacement"))
    assert none.misfits[0].damping_ln is None and np.isnan(none.misfits[0].damping_difference_ln).all()


def test_a_ring_down_lies_on_the_backbone_that_it_was_made_of(quick_run: microslip.Run) -> None:
    backbone = quick_run.backbone
    omega = 2 * np.pi * backbone.frequency_first_harmonic_hz
    signal = microslip.synthetic_ring_down(
        0.9 * float((backbone.response_motion * omega**2)[-1]),
        backbone.frequency_first_harmonic_hz,
        np.nan_to_num(backbone.damping_ratio_first_harmonic) + 1e-3,
        backbone.response_motion * omega**2,
        fs=4096.0,
        samples=30000,
    )
    comparison = microslip.compare(quick_run, microslip.identify(signal, 4096.0))
    assert comparison.quantity == "acceleration"
    assert comparison.misfits[0].frequency_percent.rms < 0.1


def test_what_cannot_be_compared_is_refused(quick_run: microslip.Run) -> None:
    far = microslip.MeasuredBackbone([1e3, 2e3], [100.0, 100.0], [0.1, 0.1], "displacement")
    with pytest.raises(microslip.InputError, match="share no amplitude"):
        microslip.compare(quick_run, far)
    with pytest.raises(microslip.InputError, match="no experiment"):
        microslip.compare(quick_run)
    with pytest.raises(microslip.InputError, match="two different amplitudes"):
        microslip.compare(quick_run, microslip.MeasuredBackbone([1.0], [100.0], [0.1]))
    with pytest.raises(microslip.InputError, match="point 2"):
        microslip.compare(quick_run, microslip.MeasuredBackbone([1.0, -2.0], [100.0, 100.0], [0.1, 0.1]))
    with pytest.raises(microslip.InputError, match="2 amplitudes, 1 frequencies"):
        microslip.compare(quick_run, microslip.MeasuredBackbone([1.0, 2.0], [100.0], [0.1, 0.1]))
    with pytest.raises(microslip.InputError, match="quantity"):
        microslip.compare(quick_run, far, amplitude="force")  # type: ignore[arg-type]
    with pytest.raises(microslip.InputError, match="experiment 1 is a int"):
        microslip.compare(quick_run, 3)  # type: ignore[arg-type]
    with pytest.raises(microslip.InputError, match="numbers"):
        microslip.MeasuredBackbone("abc", [1.0], [1.0])  # type: ignore[arg-type]


def test_tables_and_pictures_of_records(tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("matplotlib")
    hits = [microslip.synthetic_ring_down(a, 160.0, 2e-3, fs=FS, samples=16384, noise=0.05, seed=k) for k, a in enumerate((40.0, 30.0))]
    found = microslip.identify(hits, FS)
    assert len(found.to_pandas()) == len(found.amplitude)
    found.plot().savefig(tmp_path / "identification.png")
    comparison = microslip.compare(found, microslip.identify(hits[0], FS))
    assert list(comparison.to_pandas()["experiment"]) == ["experiment 1"]
    comparison.plot().savefig(tmp_path / "comparison.png")
