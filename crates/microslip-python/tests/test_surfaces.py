"""Scans, and what follows from two of them."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
import pickle
from pathlib import Path

import numpy as np
import pytest

import microslip

STEEL = (192.85e9, 0.29)


def ridges(amplitude: float, wavelength: float, shape: tuple[int, int] = (121, 601), step: float = 10e-6) -> microslip.HeightMap:
    """Waves along x, of the same height along y."""
    x = step * np.arange(shape[1])
    return microslip.HeightMap(np.tile(amplitude * np.cos(2 * np.pi * x / wavelength), (shape[0], 1)), (step, step))


def egg_box(amplitude: float, wavelength: float, tilt: float = 0.0) -> microslip.HeightMap:
    """Hills in rows and columns, whole periods of them, on a slope along x."""
    step, n = wavelength / 40, (161, 321)
    y, x = (step * np.arange(count) for count in n)
    k = 2 * np.pi / wavelength
    heights = amplitude * np.cos(k * x) * np.cos(k * y)[:, None] + tilt * x
    return microslip.HeightMap(heights, (step, step))


@pytest.fixture(scope="module")
def gaussian() -> list[microslip.HeightMap]:
    """Two rough faces, 6 mm by 4 mm."""
    return [
        microslip.synthetic_face((601, 401), 10e-6, rms=1.5e-6, correlation_length=(60e-6, 60e-6), seed=seed) for seed in (1, 2)
    ]


@pytest.fixture(scope="module")
def found(gaussian: list[microslip.HeightMap]) -> microslip.Characterisation:
    """Over six elements."""
    return microslip.characterise(*gaussian, (3, 2), material=STEEL, bootstrap=40)


def test_gaussian_faces_have_their_statistics(found: microslip.Characterisation) -> None:
    # 2000 correlated patches of an element: moments are known to a few percent.
    for face in (found.top, found.bottom):
        np.testing.assert_allclose(face.sq, 1.5e-6, rtol=0.05)
        np.testing.assert_allclose(face.sa, np.sqrt(2 / np.pi) * face.sq, rtol=0.03)
        assert (abs(face.ssk) < 0.25).all() and (abs(face.sku - 3.0) < 0.5).all()
        # The mean square difference of neighbours is 2 sq^2 (1 - exp(-step^2 / l^2)), along x and along y.
        slope = 2 * 1.5e-6 * np.sqrt(1 - np.exp(-((10e-6 / 60e-6) ** 2))) / 10e-6
        np.testing.assert_allclose(face.sdq, slope, rtol=0.05)
        assert (face.missing == 0).all()
    # Every point is one of an element's.
    assert sum(found.top.points) == 601 * 401
    np.testing.assert_allclose(found.area, 2e-3 * 2e-3, rtol=1e-12)
    np.testing.assert_allclose(found.density, found.count / found.area, rtol=1e-12)
    np.testing.assert_allclose(found.effective_radius, np.sqrt(found.radius.prod(axis=1)), rtol=1e-12)
    np.testing.assert_allclose(found.total_roughness, 0.5 * (found.top.sz + found.bottom.sz), rtol=1e-12)


def test_curves_are_sums_over_the_heights(found: microslip.Characterisation) -> None:
    youngs_modulus, poisson_ratio = STEEL
    for e, heights in enumerate(found.heights):
        assert heights[0] == found.contact_height[e] == heights.max()
        # Hertz contacts of equal bodies, t = (N/A) (2/3) E/(1 - nu^2) sqrt(R) <max(z - z_p + u, 0)^(3/2)>.
        deep = np.maximum(heights - heights[0] + found.interference[:, None], 0.0)
        factor = found.density[e] * 2 / 3 * youngs_modulus / (1 - poisson_ratio**2) * np.sqrt(found.effective_radius[e])
        np.testing.assert_allclose(found.normal_traction[e], factor * (deep**1.5).mean(axis=1), rtol=1e-10)
    # The fit of eq. (28), within what its residuals say.
    a, b, c, d, e = found.normal_fit.T[:, :, None]
    ln = np.log(found.interference / found.options["u_ref"])
    residual = a + b * ln + c * np.exp(-0.5 * ((ln + d) / e) ** 2) - np.log(found.normal_traction)
    np.testing.assert_allclose(np.sqrt((residual**2).mean(axis=1)), found.normal_fit_rms, rtol=1e-6)
    assert found.normal_band is not None and found.normal_band.shape == (6, 2, 64)
    assert (found.normal_band[:, 0] <= found.normal_band[:, 1]).all()
    without = microslip.characterise(*[ridges(1e-6, 200e-6)] * 2, material=STEEL, bootstrap=0)
    assert without.normal_band is None


def test_radii_of_waves_are_those_of_their_crests() -> None:
    amplitude, wavelength, step = 1e-6, 200e-6, 10e-6
    face = ridges(amplitude, wavelength)
    found = microslip.characterise(face, face, (2, 1), material=STEEL)
    # The three-point kernel sees 2 A (1 - cos(k h)) / h^2 of a crest that lies on a point.
    curvature = 2 * amplitude * (1 - np.cos(2 * np.pi * step / wavelength)) / step**2
    np.testing.assert_allclose(found.top.radius[:, 0], 1 / curvature, rtol=5e-3)
    assert np.isnan(found.top.radius[:, 1]).all() and (found.top.peaks[:, 1] == 0).all()
    # Two equal faces: half the radius; without peaks along y that of x serves both.
    np.testing.assert_allclose(found.radius, 0.5 * found.top.radius[:, :1].repeat(2, axis=1), rtol=1e-12)
    literal = microslip.characterise(face, face, (2, 1), material=STEEL, pair_radius="eq6-literal")
    np.testing.assert_allclose(literal.effective_radius, 0.5 * found.effective_radius, rtol=1e-12)


def test_the_gap_follows_a_tilt() -> None:
    wavelength, tilt = 400e-6, 2e-3
    top, bottom = egg_box(1e-6, wavelength), egg_box(1e-6, wavelength, -tilt)
    found = microslip.characterise(top, bottom, (8, 4), material=STEEL, detrend="registered")
    middles = found.gap_centre[:, 0]
    # The same roughness in every element, so that the gap is the slope alone; at the edges of the grid hills are cut.
    inner = (middles > wavelength) & (middles < 7 * wavelength)
    slope = np.polyfit(middles[inner], found.gap[inner], 1)[0]
    assert slope == pytest.approx(tilt, rel=1e-3)
    corners = found.gap_coefficients @ [[1, 1, 1, 1], [-1, 1, 1, -1], [-1, -1, 1, 1], [1, -1, 1, -1]]
    np.testing.assert_allclose(found.gap_range, np.column_stack([corners.min(axis=1), corners.max(axis=1)]), atol=1e-15)
    np.testing.assert_array_equal(found.gap, found.gap_coefficients[:, 0])
    moved = microslip.characterise(top, bottom, (8, 4), material=STEEL, detrend="registered", tilt=(tilt, 0.0))
    assert np.ptp(moved.gap[inner]) < 1e-9
    # With its plane taken off, nothing of the tilt is left.
    level = microslip.characterise(top, bottom, (8, 4), material=STEEL, detrend="whole-face")
    assert np.ptp(level.gap[inner]) < 2e-8


def test_faces_are_brought_together() -> None:
    face = microslip.synthetic_face((201, 101), 10e-6, rms=1e-6, correlation_length=60e-6, seed=4)
    turned = microslip.HeightMap(face.heights[:, ::-1], face.step, (7.0, -3.0))
    mesh = microslip.rectangular_mesh((2e-3, 1e-3), (1, 1), (0.1, 0.2))
    here = microslip.HeightMap(face.heights, face.step, (0.1, 0.2))
    straight = microslip.characterise(here, here, mesh, material=STEEL)
    found = microslip.characterise(face, turned, mesh, material=STEEL, centred=True, mirror_bottom=True)
    np.testing.assert_allclose(found.bottom.sq, straight.bottom.sq, rtol=1e-9)
    assert found.alignments == (None, None)


def test_the_interface_of_a_run_is_a_mesh(quick_run: microslip.Run) -> None:
    nodes = quick_run.interface.nodes
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    step = 100e-6
    points = tuple(int(n) for n in np.ceil((high - low) / step) + 1)
    faces = [
        microslip.synthetic_face(points, step, rms=1e-6, correlation_length=400e-6, origin=tuple(low), seed=seed) for seed in (1, 2)
    ]
    found = microslip.characterise(*faces, quick_run.interface, material=STEEL, bootstrap=0)
    assert len(found.gap) == len(quick_run.interface.elements)
    assert found.area.sum() == pytest.approx(quick_run.interface.weights.sum(), rel=1e-9)


def test_scans_survive_their_files(gaussian: list[microslip.HeightMap], tmp_path: Path) -> None:
    heights = gaussian[0].heights[:50, :70].copy()
    heights[3, 4] = np.nan
    scan = microslip.HeightMap(heights, (10e-6, 12e-6), (1e-3, -2e-3))
    for name in ("face.x3p", "face.csv"):
        microslip.write_scan(tmp_path / name, scan)
        again = microslip.read_scan(tmp_path / name)
        np.testing.assert_array_equal(again.heights, heights)
        assert again.step == scan.step and again.origin == scan.origin
        assert again.source is not None and again.source["lateral_unit"] == "m"
        assert pickle.loads(pickle.dumps(again)) == again and not again.heights.flags.writeable
    np.save(tmp_path / "face.npy", 1e6 * heights)
    read = microslip.read_scan(tmp_path / "face.npy", lateral_unit="mm", height_unit="um", lateral_step=(0.010, 0.012))
    np.testing.assert_allclose(read.heights, heights, rtol=1e-14)
    assert read.step == pytest.approx((10e-6, 12e-6))
    turned = microslip.read_scan(tmp_path / "face.npy", lateral_unit="mm", height_unit="um", lateral_step=(0.010, 0.012), first_row="highest-y")
    np.testing.assert_array_equal(turned.heights, read.heights[::-1])


def test_arrays_and_files_give_the_same(gaussian: list[microslip.HeightMap], found: microslip.Characterisation, tmp_path: Path) -> None:
    paths = [tmp_path / "top.x3p", tmp_path / "bottom.x3p"]
    for path, face in zip(paths, gaussian):
        microslip.write_scan(path, face)
    again = microslip.characterise(*paths, (3, 2), material=STEEL, bootstrap=40)
    assert again == found and pickle.loads(pickle.dumps(found)) == found


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_faces_go_through_process_pools(method: str) -> None:
    # The threads of this process, which worked on the same faces, are not there in a fork of it.
    here = characterised(SMALL)
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=multiprocessing.get_context(method)) as pool:
        assert pool.submit(characterised, SMALL).result(timeout=120.0) == here


def characterised(face: microslip.HeightMap) -> microslip.Characterisation:
    return microslip.characterise(face, face, material=STEEL)


def test_tables_and_pictures_of_faces(found: microslip.Characterisation, tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("matplotlib")
    assert len(found.to_pandas()) == 6
    for quantity in ("gap", "total_roughness", "count", "density", "effective_radius"):
        found.plot(quantity).savefig(tmp_path / f"{quantity}.png")
    with pytest.raises(microslip.InputError, match="no quantity 'colour'"):
        found.plot("colour")


SMALL = ridges(1e-6, 200e-6, (31, 61))

WRONG = [
    ({"material": (-1.0, 0.3)}, "youngs_modulus", "youngs_modulus = -1 Pa"),
    ({"material": (2e11, 0.7)}, "poisson_ratio", "poisson_ratio = 0.7"),
    ({"radius": "largest"}, "radius", "unknown variant `largest`"),
    ({"samples": 3}, "interference samples", "at least 8"),
    ({"samples": -3}, "samples", "samples"),
    ({"interference": (2e-6, 1e-6)}, "greatest interference", "above the least"),
    ({"detrend": 0.7}, "detrend width", "at most 0.5"),
    ({"tallest": 2.0}, None, "in \\(0, 1\\)"),
    ({"samples": 10**15}, "samples", "at most 10000"),
    ({"bootstrap": 10**7}, "bootstrap", "at most 100000"),
    ({"material": (2e11,)}, "material", "Young's modulus"),
    ({"seed": -1}, "seed", "seed"),
    ({"interface": ("a", 1)}, "divisions", "at least one element"),
    ({"s_filter": 1e-9}, None, "cut-off"),
    ({"outliers": (0, 6.0)}, None, "reach"),
    ({"align": -1.0}, None, "reach"),
    ({"shift": (np.nan, 0.0)}, None, "finite"),
    ({"interface": (0, 1)}, "divisions", "at least one element"),
    ({"interface": (40, 40)}, None, "points with data"),
    ({"interface": 3}, "interface", "interface is a int"),
    ({"interface": microslip.PlaneMesh([[0, 0], [1e-3, 0], [0, 1e-3]], [[0, 1, 7]])}, None, "node 7"),
    ({"interface": microslip.PlaneMesh([[5, 5], [6, 5], [5, 6]], [[0, 1, 2]])}, None, "points with data"),
]


@pytest.mark.parametrize(("arguments", "field", "message"), WRONG)
def test_wrong_arguments_of_faces_are_named(arguments: dict[str, object], field: str | None, message: str) -> None:
    given = {"material": STEEL, **arguments}
    with pytest.raises(microslip.InputError, match=message) as caught:
        microslip.characterise(SMALL, SMALL, **given)  # type: ignore[arg-type]
    if field is not None:
        assert caught.value.field == field
    assert pickle.loads(pickle.dumps(caught.value)).message == caught.value.message


def test_wrong_scans_are_named(tmp_path: Path) -> None:
    with pytest.raises(microslip.FileError, match="nowhere.x3p") as caught:
        microslip.read_scan(tmp_path / "nowhere.x3p")
    assert caught.value.path == str(tmp_path / "nowhere.x3p")
    (tmp_path / "face.x3p").write_bytes(b"nonsense")
    with pytest.raises(microslip.FileError):
        microslip.read_scan(tmp_path / "face.x3p")
    np.save(tmp_path / "face.npy", np.zeros((5, 5)))
    with pytest.raises(microslip.FileError, match="unit"):
        microslip.read_scan(tmp_path / "face.npy")
    with pytest.raises(microslip.InputError, match="unit of length") as caught:  # type: ignore[assignment]
        microslip.read_scan(tmp_path / "face.npy", lateral_unit="furlong")
    assert caught.value.field == "lateral_unit"
    with pytest.raises(microslip.InputError, match="unknown variant"):
        microslip.read_scan(tmp_path / "face.npy", format="jpeg")  # type: ignore[arg-type]
    with pytest.raises(microslip.InputError, match="layer"):
        microslip.read_scan(tmp_path / "face.npy", layer=-1)
    with pytest.raises(microslip.InputError, match="x3p or .csv"):
        microslip.write_scan(tmp_path / "face.png", SMALL)
    with pytest.raises(microslip.InputError, match="shape"):
        microslip.HeightMap(np.zeros(7), (1e-6, 1e-6))
    with pytest.raises(microslip.InputError, match="numbers"):
        microslip.HeightMap([["a"] * 4] * 4, (1e-6, 1e-6))
    with pytest.raises(microslip.InputError, match="dx"):
        microslip.characterise(microslip.HeightMap(np.zeros((9, 9)), (-1e-6, 1e-6)), SMALL, microslip.rectangular_mesh((1e-4, 1e-4), (1, 1)), material=STEEL)
    with pytest.raises(microslip.InputError, match="points"):
        microslip.synthetic_face((2, 2), 1e-6, rms=1e-6, correlation_length=1e-6)
    with pytest.raises(microslip.InputError, match="seed"):
        microslip.synthetic_face((20, 20), 1e-6, rms=1e-6, correlation_length=5e-6, seed=-1)
    with pytest.raises(microslip.InputError, match="waviness"):
        microslip.synthetic_face((20, 20), 1e-6, rms=1e-6, correlation_length=5e-6, waviness=[(1e-6, 2.0)])  # type: ignore[list-item]
    with pytest.raises(microslip.InputError, match="200 million in all"):
        microslip.synthetic_face((100_000, 100_000), 1e-6, rms=1e-6, correlation_length=1e-6)
    with pytest.raises(microslip.InputError, match="correlation_length"):
        microslip.synthetic_face((20, 20), 1e-6, rms=1e-6, correlation_length=1.0)


def test_waves_touch_as_westergaard_found() -> None:
    n, height, length = 256, 1e-6, 1e-3
    x = (np.arange(n) + 0.5) / n
    wave = microslip.HeightMap(np.tile(height * np.cos(2 * np.pi * x), (4, 1)), step=(length / n, length / n))
    shares = np.array([0.1, 0.3, 0.6])
    separation, _, touching = microslip.press(wave, shares * np.pi * height / length)
    assert np.allclose(np.array(touching) / (4 * n), 2 / np.pi * np.arcsin(np.sqrt(shares)), atol=1 / n)
    assert np.allclose(separation, height * (1 - shares + shares * np.log(shares)), atol=2e-3 * height)
    curves = microslip.laws.SampledCurves(
        interferences=[0.0, *(height - separation)], tractions=[0.0, *(1e11 * shares)], areas=[0.0, *shares], tangential_ratio=0.8
    )
    law = microslip.laws.FoundationLaw(curves, 0.2, tangential_ratio=0.8, n_springs=64, reach=1.2e-6)
    traction, _, _ = law.evaluate(np.array([[0.0], [0.0], [height - separation[1]]]))
    assert abs(traction[2, 0] / 0.3e11 - 1) < 0.2
    with pytest.raises(microslip.InputError, match="pressure"):
        microslip.press(wave, [-1.0])
