"""Runs: numbers, threads, progress, interruption, memory and pickling."""

from __future__ import annotations

import base64
import concurrent.futures
import json
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import beam
import microslip
from conftest import QUICK, REPOSITORY

# A run of some seconds, as amplitudes have many vertices.
LONG = {"analyses.backbone.amplitudes": 200, "analyses.backbone.vertices_per_quarter": 64}


def numbers(run: microslip.Run) -> dict[str, object]:
    """All results of a run, without what depends on when and where it ran."""
    return {key: value for key, value in run.summary.items() if key not in ("timings", "peak_memory", "provenance")}


def test_a_run_is_what_the_summary_says(quick_run: microslip.Run) -> None:
    run, backbone = quick_run, quick_run.summary["backbone"]
    assert run.frequency_hz.tolist() == [b["frequency_hz"] for b in backbone]
    assert run.modal_force.tolist() == [b["modal_force"] for b in backbone]
    missing = [b["damping_ratio"] is None for b in backbone]
    assert np.isnan(run.damping_ratio).tolist() == missing
    assert run.half_frequencies_hz.shape == (8, 2) and run.converged.all() and run.failure == (None,) * 8
    assert run.iterations.tolist() == [b["iterations"] for b in backbone]
    assert run.scene == microslip.Scene.from_file(QUICK) and run.scene.to_dict() == run.summary["scene"]
    assert run.modes[0].number == 1 and run.modes[0].linear_frequency_hz == run.linear_frequencies_hz[0]
    assert run.timings["total"] > 0.0 and run.summary["provenance"]["program"]["name"] == "microslip"
    assert repr(run) == "Run('brb-quick', mode 1, 8 amplitudes, 8 converged)"
    assert {"frequency_hz", "damping_ratio", "scene"} <= set(dir(run))
    with pytest.raises(AttributeError):
        run.frequency  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match="read-only"):
        run.frequency_hz[0] = 1.0


def test_fields_balance_the_bolts(quick_run: microslip.Run) -> None:
    run, interface = quick_run, quick_run.interface
    points = interface.weights.size
    assert interface.points.shape == (points, 2) and interface.element_of_point.shape == (points,)
    assert interface.node_positions is not None and interface.node_positions.shape == (len(interface.nodes), 3)
    assert interface.elements.max() == len(interface.nodes) - 1 and interface.elements.min() >= -1
    assert interface.element_of_point.max() == len(interface.elements) - 1
    assert np.isclose(interface.weights.sum(), run.summary["model"]["interface_area"], rtol=1e-12)
    carried = interface.weights @ run.prestress.traction[:, 2]
    assert np.isclose(carried, 3 * run.summary["prestress"]["bolt_load"], rtol=1e-6)
    assert run.prestress.number == 0 and not run.prestress.flux.any()
    assert [fields.number for fields in run.fields] == [1, 4, 6, 8]
    for fields in run.fields:
        assert fields.response_displacement == run.response_displacement[fields.number - 1]
        dissipation = interface.weights @ fields.flux.sum(axis=1)
        assert np.isclose(dissipation, run.dissipation[fields.number - 1], rtol=1e-9)
        slipping = interface.weights[fields.regime == microslip.Regime.SLIP].sum() / interface.weights.sum()
        assert np.isclose(slipping, run.slip_fraction[fields.number - 1], rtol=1e-9, atol=1e-12)


def test_several_modes_methods_and_forces(beam_file: Path) -> None:
    scene = microslip.Scene.from_file(beam_file).replace(
        {
            "analyses.modes.followed": [2, 1],
            "analyses.backbone.amplitudes": 4,
            "analyses.backbone.methods": ["masing", "rqnma"],
            "analyses.epmc": {},
            "analyses.forced": {"levels": [2.0], "from_hz": 60.0, "to_hz": 90.0, "terms": [[7, 1, 0.8]], "harmonics": 5, "samples": 64},
        }
    )
    run = microslip.run(scene, cache=False)
    assert [mode.number for mode in run.modes] == [2, 1] and run.methods is run.modes[0].methods
    assert set(run.methods) == {"masing", "rqnma", "epmc"}
    assert run.methods["epmc"].harmonics.min() > 0 and run.methods["masing"].harmonics.max() == -1
    assert run.methods["masing"].frequency_hz.shape == (4,) and np.isnan(run.methods["masing"].drift).all()
    (forced,) = run.forced
    assert forced.level == 2.0 and forced.harmonics.shape == (forced.frequency_hz.size, 5) and forced.peak is not None
    assert forced.amplitude.max() == forced.peak[1]
    assert pickle.loads(pickle.dumps(run)) == run


def test_threads_and_caches_change_no_bit(beam_file: Path, tmp_path: Path) -> None:
    scene = microslip.Scene.from_file(beam_file)
    runs = [microslip.run(scene, cache=False), microslip.run(scene, threads=1, cache=tmp_path), microslip.run(scene, threads=3, cache=tmp_path)]
    assert numbers(runs[0]) == numbers(runs[1]) == numbers(runs[2])
    assert list(tmp_path.iterdir()), "nothing was kept"
    assert not list(tmp_path.glob("*.jsonl")), "finished amplitudes were kept after the run"


def test_two_threads_at_once_give_the_same_bits(quick_scene: microslip.Scene, quick_run: microslip.Run) -> None:
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        runs = list(pool.map(lambda _: microslip.run(quick_scene, threads=1), range(2)))
    assert numbers(runs[0]) == numbers(runs[1]) == numbers(quick_run)
    for run in runs:
        assert run.fields[-1] == quick_run.fields[-1] and run.prestress == quick_run.prestress


def test_other_threads_go_on_during_a_run(beam_file: Path) -> None:
    scene = microslip.Scene.from_file(beam_file).replace(LONG)
    ticks = 0
    done = threading.Event()

    def tick() -> None:
        nonlocal ticks
        while not done.wait(0.005):
            ticks += 1

    ticker = threading.Thread(target=tick)
    ticker.start()
    began = time.perf_counter()
    microslip.run(scene, threads=1, cache=False)
    seconds = time.perf_counter() - began
    done.set()
    ticker.join()
    assert ticks > 10 * seconds, f"{ticks} ticks of 5 ms in {seconds:.2f} s"


def test_progress_is_heard_in_the_calling_thread(quick_scene: microslip.Scene) -> None:
    heard: list[tuple[str, float]] = []
    threads = set()

    def listen(stage: str, fraction: float) -> None:
        heard.append((stage, fraction))
        threads.add(threading.current_thread())

    microslip.run(quick_scene, progress=listen)
    assert threads == {threading.current_thread()}
    assert all(0.0 <= fraction <= 1.0 for _, fraction in heard)
    stages = [stage for stage, fraction in heard if fraction == 0.0]
    assert stages[0] == "mesh" and {"characterise", "prestress", "modes", "backbone"} <= set(stages)
    assert heard[-1] == ("backbone", 1.0)


class Stop(Exception):
    pass


def test_what_progress_raises_stops_the_run_which_goes_on_from_there(beam_file: Path, tmp_path: Path) -> None:
    scene = microslip.Scene.from_file(beam_file).replace(LONG)

    def stop(stage: str, fraction: float) -> None:
        if stage == "backbone" and fraction > 0.1:
            raise Stop(fraction)

    whole = microslip.run(scene, cache=False)
    began = time.perf_counter()
    with pytest.raises(Stop):
        microslip.run(scene, progress=stop, cache=tmp_path)
    assert time.perf_counter() - began < 60.0
    (kept,) = tmp_path.glob("*.jsonl")
    finished = len(kept.read_bytes().splitlines())
    assert 0 < finished < 200
    fractions: list[float] = []
    again = microslip.run(scene, progress=lambda stage, done: fractions.append(done) if stage == "backbone" else None, cache=tmp_path)
    assert numbers(again) == numbers(whole)
    assert len([f for f in fractions if 0.0 < f < 1.0]) < 200


INTERRUPTED = """
import sys, microslip
scene = microslip.Scene.from_file(sys.argv[1]).replace({"analyses.backbone.amplitudes": 2000, "analyses.backbone.vertices_per_quarter": 64})
def tell(stage, done):
    if stage == "backbone" and done > 0.0:
        print("going", flush=True)
try:
    microslip.run(scene, progress=tell if sys.argv[3] == "tell" else None, cache=sys.argv[2])
except KeyboardInterrupt:
    print("stopped", flush=True)
    raise SystemExit(3)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals are sent as on POSIX")
@pytest.mark.parametrize("mode", ["tell", "silent"])
def test_ctrl_c_stops_a_run_which_goes_on_from_there(beam_file: Path, tmp_path: Path, mode: str) -> None:
    command = [sys.executable, "-c", INTERRUPTED, str(beam_file), str(tmp_path), mode]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    if mode == "tell":
        assert process.stdout.readline() == "going\n"
    else:
        deadline = time.monotonic() + 120.0
        while not [file for file in tmp_path.glob("*.jsonl") if file.stat().st_size]:
            assert time.monotonic() < deadline and process.poll() is None
            time.sleep(0.02)
    began = time.monotonic()
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=120.0)
    assert process.returncode == 3 and out.endswith("stopped\n"), out
    assert time.monotonic() - began < 30.0
    (kept,) = tmp_path.glob("*.jsonl")
    finished = len(kept.read_bytes().splitlines())
    assert finished > 0
    scene = microslip.Scene.from_file(beam_file).replace({"analyses.backbone.amplitudes": 2000, "analyses.backbone.vertices_per_quarter": 64})

    def stop(stage: str, fraction: float) -> None:
        if stage == "backbone" and fraction > 0.0:
            raise Stop(fraction)

    # Of what was finished nothing is computed again: more lines than before, and never one twice.
    with pytest.raises(Stop):
        microslip.run(scene, progress=stop, cache=tmp_path)
    lines = [json.loads(line.split(b" ", 1)[1])["index"] for line in kept.read_bytes().splitlines()]
    assert len(lines) > finished and len(set(lines)) == len(lines)


MEMORY = """
import os, sys, microslip
def resident():
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
scene = microslip.Scene.from_file(sys.argv[1]).replace({"analyses.backbone.amplitudes": 3})
for _ in range(50):
    microslip.run(scene, cache=False, progress=lambda stage, done: None)
before = resident()
for _ in range(200):
    microslip.run(scene, cache=False, progress=lambda stage, done: None)
print(before, resident() - before)
"""


def test_memory_is_stable_over_200_runs(beam_file: Path) -> None:
    if not Path("/proc/self/statm").exists():
        pytest.skip("the system does not tell how much memory a process has")
    # In a process of its own, in which no earlier test has left memory to be used again.
    done = subprocess.run([sys.executable, "-c", MEMORY, str(beam_file)], check=True, capture_output=True, text=True)
    before, grown = (int(number) for number in done.stdout.split())
    print(f"200 runs: {grown / 2**20:.2f} MiB more than {before / 2**20:.0f} MiB")
    assert grown < 8 * 2**20


def test_runs_survive_pickling(quick_run: microslip.Run) -> None:
    again = pickle.loads(pickle.dumps(quick_run))
    assert again == quick_run and again.fields == quick_run.fields and again.interface == quick_run.interface
    assert not again.frequency_hz.flags.writeable and not again.prestress.jump.flags.writeable
    with pytest.raises(microslip.InputError, match="unpickled"):
        again.save("nowhere")
    assert again != 3 and quick_run != again.modes


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_scenes_and_runs_go_through_process_pools(method: str, beam_file: Path, beam_run: microslip.Run) -> None:
    scene = microslip.Scene.from_file(beam_file)
    # The threads of this process are not there in a fork of it.
    context = multiprocessing.get_context(method)
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        futures = [pool.submit(microslip.run, scene, cache=False) for _ in range(3)]
        runs = [future.result(timeout=120.0) for future in futures]
        refused = pool.submit(microslip.Scene.from_file, "nowhere.json")
        with pytest.raises(microslip.FileError, match="nowhere.json"):
            refused.result(timeout=120.0)
    for run in runs:
        assert numbers(run) == numbers(beam_run)


def test_results_are_saved_loaded_and_protected(beam_file: Path, tmp_path: Path) -> None:
    scene = microslip.Scene.from_file(beam_file)
    run = microslip.run(scene, cache=False, out=tmp_path / "a")
    run.save(tmp_path / "b")
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert {"summary.json", "report.html", "backbone.csv", "manifest.json"} <= set(names)
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    assert json.loads((tmp_path / "a" / "summary.json").read_text()) == run.summary
    run.save(tmp_path / "b")

    loaded = microslip.load(tmp_path / "a")
    assert loaded.summary == run.summary and loaded.scene == run.scene and loaded.backbone == run.backbone
    assert loaded.fields == () and pickle.loads(pickle.dumps(loaded)) == loaded
    assert microslip.load(tmp_path / "a" / "summary.json") == loaded
    with pytest.raises(microslip.InputError, match="no fields"):
        _ = loaded.prestress
    with pytest.raises(microslip.InputError):
        loaded.save(tmp_path / "c")

    other = scene.replace(name="other")
    heard: list[str] = []
    with pytest.raises(microslip.FileError, match="overwrite=True") as caught:
        microslip.run(other, cache=False, out=tmp_path / "a", progress=lambda stage, _: heard.append(stage))
    assert not heard, "it was refused after the computation"
    assert caught.value.path == str(tmp_path / "a") and "--" not in caught.value.message
    microslip.run(other, cache=False, out=tmp_path / "a", overwrite=True)
    assert microslip.load(tmp_path / "a").scene.name == "other"


def test_tables_and_pictures(quick_run: microslip.Run, beam_file: Path, tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("matplotlib")
    scene = microslip.Scene.from_file(beam_file).replace({"analyses.backbone.methods": ["masing"], "analyses.backbone.amplitudes": 5})
    run = microslip.run(scene, cache=False)
    table = run.to_pandas()
    assert isinstance(table, pandas.DataFrame) and table["method"].tolist() == ["cqsma"] * 5 + ["masing"] * 5
    assert table["frequency_hz"][:5].tolist() == run.frequency_hz.tolist()
    for amplitude in ("response_displacement", "response_acceleration", "modal_amplitude"):
        figure = run.plot(amplitude)
        above, below = figure.axes
        assert above.get_xscale() == below.get_xscale() == below.get_yscale() == "log" and above.get_yscale() == "linear"
        assert len(above.lines) == (1 if amplitude == "response_acceleration" else 2)
        figure.savefig(tmp_path / f"{amplitude}.png")
    assert above.lines[0].get_ydata().tolist() == run.frequency_hz.tolist()
    with pytest.raises(microslip.InputError, match="no amplitude 'speed'"):
        run.plot("speed")


def test_pictures_for_papers_have_the_names_of_the_program(quick_run: microslip.Run, beam_run: microslip.Run, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    run = quick_run
    one, two = microslip.plot(run), microslip.plot([run, run])
    assert [len(figure.axes[0].lines) for figure in (one, two)] == [1, 2]
    assert one.axes[1].get_legend() is None and two.axes[1].get_legend() is not None
    assert one.axes[0].lines[0].get_ydata().tolist() == run.backbone.frequency_first_harmonic_hz.tolist()
    assert round(25.4 * one.get_figwidth()) == 85
    flux = microslip.plot(run, kind="flux")
    (cells,) = flux.axes[0].collections
    total = float(run.interface.weights @ run.fields[-1].flux.sum(axis=1))
    areas = np.bincount(run.interface.element_of_point, weights=run.interface.weights)
    assert float(areas @ cells.get_array()) == pytest.approx(total, rel=1e-12)
    for number, figure in enumerate((one, two, flux)):
        figure.savefig(tmp_path / f"{number}.pdf")
    for kind, match in (("bands", "no bands"), ("modes", "path of a folder"), ("trade", "path of a folder"), ("speed", "no kind 'speed'")):
        with pytest.raises(microslip.InputError, match=match):
            microslip.plot(run, kind=kind)
    with pytest.raises(microslip.InputError, match="a map shows one run"):
        microslip.plot([run, run], kind="flux")
    with pytest.raises(microslip.InputError, match="points of contact" if beam_run.fields else "output.fields_at"):
        microslip.plot(beam_run, kind="flux")
    run.save(tmp_path / "run")
    with pytest.raises(microslip.InputError, match="output.fields_at"):
        microslip.plot(microslip.load(tmp_path / "run"), kind="flux")


def test_shapes_and_errors_are_drawn_from_their_folders(quick_run: microslip.Run, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    rungs = [
        {"dial": "mesh", "seconds": 1.0, "errors": {"linear_frequency": 0.01, "frequency_shift": [0.002, None], "damping_ln": [0.1, -0.2]}},
        {"dial": "mesh", "seconds": 3.0, "errors": {"linear_frequency": 0.004, "frequency_shift": [-0.001], "damping_ln": [None]}},
        {"dial": "radii", "seconds": None, "errors": None},
    ]
    (tmp_path / "trade.json").write_text(json.dumps({"rungs": rungs}))
    above, below = microslip.plot(tmp_path, kind="trade").axes
    assert [line.get_ydata().tolist() for line in above.lines] == [[0.012, 0.004]]
    assert below.lines[0].get_ydata()[0] == 0.2 and np.isnan(below.lines[0].get_ydata()[1])

    # Two hexahedra upon one another: ten outer faces of twelve, and a third of them that moves.
    corners = np.array([[x, y, z] for z in (0.0, 1.0, 2.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float)
    shape = np.where(corners[:, 2:] == 2.0, [[0.0, 0.0, 3.0]], 0.0)
    cells = {"connectivity": np.r_[0:8, 4:12].astype("<i8"), "offsets": np.array([8, 16], "<i8"), "types": np.array([12, 12], "u1")}

    def array(name: str, kind: str, values: np.ndarray, columns: int = 1) -> str:
        raw = values.tobytes()
        text = base64.b64encode(np.array([len(raw)], "<u8").tobytes() + raw).decode()
        return f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{columns}" format="binary">{text}</DataArray>'

    arrays = array("stuck 01 [1/sqrt(kg)]", "Float64", shape, 3) + array("Points", "Float64", corners, 3)
    arrays += "".join(array(name, "UInt8" if name == "types" else "Int64", values) for name, values in cells.items())
    (tmp_path / "modes.vtu").write_text(f"<VTKFile>{arrays}</VTKFile>")
    modes = {"axes": np.eye(3).tolist(), "contacts": [{"contact": "stuck", "modes": [{"number": 1, "frequency_hz": 12.3}]}]}
    (tmp_path / "summary.json").write_text(json.dumps({"modes": modes}))
    figure = microslip.plot(str(tmp_path), kind="modes")
    (axes,) = figure.axes
    (drawn,) = axes.collections
    assert axes.get_title() == "1. 12.3 Hz" and len(drawn.get_paths()) == 10
    assert sorted(drawn.get_array())[-5:] == pytest.approx([1.5, 1.5, 1.5, 1.5, 3.0])
    figure.savefig(tmp_path / "modes.pdf")
    for kind in ("modes", "trade"):
        with pytest.raises(microslip.InputError, match="cannot be read"):
            microslip.plot(tmp_path / "nowhere", kind=kind)
    (tmp_path / "summary.json").write_text("{}")
    with pytest.raises(microslip.InputError, match="there are no mode shapes"):
        microslip.plot(tmp_path, kind="modes")
    with pytest.raises(microslip.InputError, match="give a Run"):
        microslip.plot(tmp_path)


def test_what_is_missing_is_asked_for(beam_run: microslip.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("pandas", "matplotlib", "matplotlib.figure"):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.delitem(sys.modules, "microslip._figure", raising=False)
    with pytest.raises(ImportError, match=r"pip install microslip\[pandas\]"):
        beam_run.to_pandas()
    with pytest.raises(ImportError, match=r"pip install microslip\[plot\]"):
        beam_run.plot()


def program() -> Path | None:
    """The program of the same sources, if it was built."""
    named = os.environ.get("MICROSLIP_PROGRAM")
    folder = os.environ.get("CARGO_TARGET_DIR", str(REPOSITORY / "target"))
    path = Path(named) if named else Path(folder) / "release" / "microslip"
    return path if path.exists() else None


def test_numbers_are_those_of_the_program(quick_run: microslip.Run, tmp_path: Path) -> None:
    path = program()
    if path is None:
        pytest.skip("the program is not built: cargo build --release -p microslip")
    subprocess.run([path, "run", QUICK, "--out", tmp_path / "run", "--no-cache"], check=True, capture_output=True)
    theirs = microslip.load(tmp_path / "run")
    assert numbers(theirs) == numbers(quick_run)
    # And the program finds in the package's results what it wrote itself.
    quick_run.save(tmp_path / "run")
    subprocess.run([path, "verify", tmp_path / "run", "--rerun"], check=True, capture_output=True)
