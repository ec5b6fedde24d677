"""Scenes, and what is refused."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beam
import microslip
from conftest import QUICK, REPOSITORY

UNITS = {"length": "m", "mass": "kg", "time": "s"}
BENCHMARK = {"units": UNITS, "structure": {"benchmark": "brake-reuss-beam"}}


def changed(**fields: Any) -> dict[str, Any]:
    return {**BENCHMARK, **fields}


# What is wrong, the class, the field, the value, part of the message and of the remedy.
WRONG = [
    ({"structure": {"benchmark": "brake-reuss-beam"}}, "units", None, "`units` is missing", None),
    ({"units": UNITS}, "structure", None, "`structure` is missing", None),
    (changed(interfaces={"mu": -0.5}), "interfaces.mu", -0.5, "interfaces.mu = -0.5 is not admissible", "finite and not negative"),
    (changed(mu=0.3), "mu", None, "mu is now interfaces.mu", None),
    (changed(colour="red"), "colour", None, "unknown field `colour`", None),
    (changed(bolts={"load": "12 parsec"}), "bolts.load", None, "12 parsec", None),
    (changed(structure={"benchmark": "no-such-beam"}), "structure.benchmark", None, "no benchmark `no-such-beam`", "brake-reuss-beam"),
    (
        changed(analyses={"backbone": {"amplitude_from": -1e-6}}),
        "analyses.backbone.amplitude_from",
        -1e-6,
        "analyses.backbone.amplitude_from = -0.000001 m",
        "positive",
    ),
    (changed(bolts={"load": 1.0, "loads": [1.0, 2.0, 3.0]}), "bolts.load", None, "bolts.loads has one for each", "leave one of them out"),
    (changed(interfaces={"law": {"radii": "measured", "friction": "lumped", "bins": {"error": 1e-3}}}), None, None, "law", None),
    (changed(accuracy={"damping": 1e-9}), "accuracy", None, "no measured mesh", None),
    (changed(background_damping=-0.01), "background_damping", -0.01, "background_damping = -0.01", "it must be"),
    (changed(interfaces={"mu": "rough"}), "interfaces.mu", None, "mu", None),
]


@pytest.mark.parametrize(("fields", "field", "value", "message", "remedy"), WRONG)
def test_wrong_scenes_name_field_value_and_remedy(
    fields: dict[str, Any], field: str | None, value: float | None, message: str, remedy: str | None
) -> None:
    with pytest.raises(microslip.SceneError) as caught:
        microslip.Scene.from_dict(fields)
    error = caught.value
    assert message in error.message and str(error) == error.message
    if field is not None:
        assert error.field == field
    assert error.value == value
    if remedy is not None:
        assert error.remedy is not None and remedy in error.remedy
    assert isinstance(error, ValueError) and isinstance(error, microslip.Error)
    again = pickle.loads(pickle.dumps(error))
    assert vars(again) == vars(error) and str(again) == str(error) and type(again) is type(error)


def test_wrong_arguments_are_input_errors(beam_file: Path, tmp_path: Path) -> None:
    scene = microslip.Scene.from_file(beam_file)
    for arguments, field in [({"threads": 0}, "threads"), ({"threads": -1}, "threads"), ({"threads": 5000}, "threads"), ({"ensemble": 0}, "ensemble"), ({"progress": 3}, "progress")]:
        with pytest.raises(microslip.InputError) as caught:
            microslip.run(scene, **arguments)
        assert caught.value.field == field and caught.value.message
    with pytest.raises(microslip.InputError):
        microslip.run("brb-quick")  # type: ignore[arg-type]
    with pytest.raises(microslip.InputError):
        microslip.Scene({})  # type: ignore[arg-type]
    with pytest.raises(microslip.InputError):
        microslip.Scene.from_dict({"units": object()})
    with pytest.raises(microslip.InputError):
        scene.replace({"interfaces.mu.x": 1.0})
    with pytest.raises(TypeError):
        microslip.Scene.from_file(3)  # type: ignore[arg-type]
    with pytest.raises(microslip.SceneError, match="no samples of heights"):
        microslip.run(scene, ensemble=3)
    with pytest.raises(microslip.SceneError) as unknown:
        microslip.Scene.benchmark("brake-reuss-beam/no-such-scene")
    assert unknown.value.value == "no-such-scene" and "brb-quick" in str(unknown.value.remedy)


def test_files_that_cannot_be_used_are_file_errors(tmp_path: Path, beam_file: Path) -> None:
    with pytest.raises(microslip.FileError, match="nowhere.json") as caught:
        microslip.Scene.from_file(tmp_path / "nowhere.json")
    assert caught.value.path == str(tmp_path / "nowhere.json") and isinstance(caught.value, OSError)
    assert pickle.loads(pickle.dumps(caught.value)).path == caught.value.path
    with pytest.raises(microslip.FileError):
        microslip.Scene.from_file(tmp_path)
    with pytest.raises(microslip.Error):
        microslip.run(microslip.Scene.from_dict(beam.SCENE, tmp_path))
    (tmp_path / "summary.json").write_text("{}")
    with pytest.raises(microslip.FileError, match="not the summary of a run"):
        microslip.load(tmp_path)
    with pytest.raises(microslip.FileError):
        microslip.load(tmp_path / "nowhere")


def test_a_prestress_that_does_not_exist_is_a_convergence_error(tmp_path: Path) -> None:
    # Nothing holds a node without stiffness against its preload.
    np.savez(tmp_path / "beam.npz", K=np.diag([1e4, 1e4, 0.0]), M=np.eye(3), dofs=np.array([[10, 1], [10, 2], [10, 3]]))
    fields = copy.deepcopy(beam.SCENE)
    fields["structure"]["matrices"]["points"] = [{"node": 10}]
    del fields["interfaces"]["surface"]["parameters"]["sets"][1]
    with pytest.raises(microslip.ConvergenceError, match="nothing is in contact") as caught:
        microslip.run(microslip.Scene.from_dict(fields, tmp_path), cache=False)
    assert caught.value.remedy == "give a structure that does, or bolts with a load"
    assert isinstance(caught.value, ArithmeticError)


def test_matrices_that_cannot_be_solved_are_a_solver_error(tmp_path: Path) -> None:
    np.savez(tmp_path / "beam.npz", K=np.diag([1e4, 1e4, 1e-13]), M=np.eye(3), dofs=np.array([[10, 1], [10, 2], [10, 3]]))
    fields = copy.deepcopy(beam.SCENE)
    fields["structure"]["matrices"]["points"] = [{"node": 10}]
    del fields["interfaces"]["surface"]["parameters"]["sets"][1]
    with pytest.raises(microslip.SolverError):
        microslip.run(microslip.Scene.from_dict(fields, tmp_path), cache=False)


@pytest.mark.parametrize("path", sorted((REPOSITORY / "fixtures" / "scenes").glob("*.json")), ids=lambda path: path.stem)
def test_scenes_survive_dictionaries_and_pickling(path: Path) -> None:
    scene = microslip.Scene.from_file(path)
    assert scene.name == path.stem and repr(scene) == f"Scene({path.stem!r})"
    assert microslip.Scene.from_dict(scene.to_dict()) == scene
    for same in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
        assert same == scene and hash(same) == hash(scene) and same is not scene
    other = scene.replace(name="other")
    assert other != scene and other.name == "other" and other != 3


def test_scenes_take_numpy_values_paths_and_folders(beam_file: Path) -> None:
    fields = copy.deepcopy(beam.SCENE)
    fields["interfaces"]["mu"] = np.float64(0.3)
    fields["structure"]["matrices"]["path"] = beam_file.parent / "beam.npz"
    fields["structure"]["matrices"]["response"]["terms"] = [[np.int64(10), 1, np.float32(1.0)]]
    fields["interfaces"]["surface"]["parameters"]["sets"][0]["curves"]["elastic"]["tangential_stiffness"] = np.array([1e5, 1e5])
    here = microslip.Scene.from_dict(fields)
    there = microslip.Scene.from_dict(beam.SCENE, beam_file.parent)
    assert here.to_dict() == there.to_dict()
    text = beam_file.read_text()
    assert microslip.Scene.from_json(text, beam_file.parent) == there


def test_fields_are_replaced_and_reset() -> None:
    scene = microslip.Scene.from_file(QUICK)
    other = scene.replace({"analyses.backbone.amplitudes": 7, "bolts.load": "9 kN"})
    assert other.to_dict()["analyses"]["backbone"]["amplitudes"] == 7 and other.to_dict()["bolts"]["load"] == 9e3
    default = other.replace({"analyses.backbone.amplitudes": None})
    assert default.to_dict()["analyses"]["backbone"]["amplitudes"] == 20
    with pytest.raises(microslip.SceneError) as caught:
        scene.replace({"bolts.lod": 1.0})
    assert "lod" in caught.value.message
