"""Files of matrices and meshes."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import microslip

sparse = pytest.importorskip("scipy.sparse")
io = pytest.importorskip("scipy.io")


def arrays() -> dict[str, Any]:
    rng = np.random.default_rng(1)
    stiffness = sparse.random(30, 30, density=0.1, random_state=2, format="coo")
    return {"K": stiffness, "M": rng.normal(size=(3, 5)), "dofs": np.arange(12).reshape(6, 2), "x": rng.normal(size=7), "about": "springs, µ = 0.3"}


def check(found: dict[str, Any], given: dict[str, Any]) -> None:
    assert set(found) == set(given)
    assert sparse.issparse(found["K"]) and (found["K"] != given["K"].tocsr()).nnz == 0
    np.testing.assert_array_equal(found["M"], given["M"])
    np.testing.assert_array_equal(found["dofs"], given["dofs"])
    assert found["dofs"].dtype == np.int64 and found["x"].shape == (7, 1)
    np.testing.assert_array_equal(found["x"][:, 0], given["x"])
    assert found["about"] == given["about"]


@pytest.mark.parametrize("extension", ["npz", "mat"])
def test_arrays_survive_their_files(extension: str, tmp_path: Path) -> None:
    path = tmp_path / f"model.{extension}"
    microslip.write_matrices(path, arrays())
    check(microslip.read_matrices(path), arrays())


def test_other_programs_read_what_is_written(tmp_path: Path) -> None:
    given = arrays()
    microslip.write_matrices(tmp_path / "model.npz", given)
    with np.load(tmp_path / "model.npz") as found:
        np.testing.assert_array_equal(found["M"], given["M"])
        np.testing.assert_array_equal(found["dofs"], given["dofs"])
    microslip.write_matrices(tmp_path / "model.mat", given)
    theirs = io.loadmat(tmp_path / "model.mat")
    assert (theirs["K"] != given["K"]).nnz == 0 and theirs["about"][0] == given["about"]
    microslip.write_matrices(tmp_path / "K.mtx", {"K": given["K"]})
    assert abs(io.mmread(tmp_path / "K.mtx") - given["K"]).max() == 0.0


def test_what_other_programs_write_is_read(tmp_path: Path) -> None:
    given = arrays()
    io.savemat(tmp_path / "model.mat", {"K": given["K"].tocsc(), "M": given["M"], "about": "springs"})
    found = microslip.read_matrices(tmp_path / "model.mat")
    assert (found["K"] != given["K"]).nnz == 0 and found["about"] == "springs"
    sparse.save_npz(tmp_path / "K.npz", given["K"].tocsr())
    (only,) = microslip.read_matrices(tmp_path / "K.npz").values()
    assert (only != given["K"]).nnz == 0
    io.mmwrite(tmp_path / "K.mtx", given["K"])
    assert abs(microslip.read_matrices(tmp_path / "K.mtx")["matrix"] - given["K"]).max() < 1e-15
    (tmp_path / "job.sti").write_text("1 1 2.0\n1 2 -1.0\n2 2 3.0\n")
    (tmp_path / "job.mas").write_text("1 1 1.0\n2 2 1.0\n")
    (tmp_path / "job.dof").write_text("7.1\n7.2\n")
    found = microslip.read_matrices(tmp_path / "job.sti")
    np.testing.assert_array_equal(found["STIFFNESS"].toarray(), [[2.0, -1.0], [-1.0, 3.0]])
    np.testing.assert_array_equal(found["dofs"], [[7, 1], [7, 2]])
    fixtures = Path(__file__).parents[2] / "matrix-files" / "tests" / "fixtures"
    found = microslip.read_matrices(fixtures / "small.full")
    assert found["STIFFNESS"].diagonal().tolist() == [4.0, 3.0, 2.5e9, 9.0, 5.0] and found["dofs"].tolist()[3] == [3, 1]
    found = microslip.read_matrices(fixtures / "tables.op2")
    assert found["KAAX"].diagonal().tolist() == [4.0, 3.0, 2.5e9] and found["dofs"].tolist() == [[11, 1], [12, 3], [101, 0]]
    assert set(microslip.read_matrices(fixtures / "blocks_le.op2")) == {"K", "M", "S"}


def test_wrong_matrices_are_named(tmp_path: Path) -> None:
    with pytest.raises(microslip.FileError, match="nowhere.npz") as caught:
        microslip.read_matrices(tmp_path / "nowhere.npz")
    assert caught.value.path == str(tmp_path / "nowhere.npz")
    (tmp_path / "bad.mat").write_bytes(b"nonsense" * 40)
    with pytest.raises(microslip.FileError, match="bad.mat"):
        microslip.read_matrices(tmp_path / "bad.mat")
    with pytest.raises(microslip.InputError, match="`.csv`"):
        microslip.read_matrices(tmp_path / "K.csv")
    wrong: list[tuple[str, dict[str, Any], str]] = [
        ("K.npz", {"K": np.array([[np.nan]])}, "NaN"),
        ("K.mat", {"1K": np.eye(2)}, "no such name"),
        ("K.mtx", {"K": np.eye(2), "M": np.eye(2)}, "there are 2"),
        ("K.mtx", {"K": "text"}, "text"),
        ("K.txt", {"K": np.eye(2)}, "npz, .mat, .mtx or .op4"),
        ("K.npz", {"K": np.zeros((2, 2, 2))}, "two dimensions"),
        ("K.npz", {"K": np.array([1j])}, "cannot be written"),
        ("K.npz", {"K": object()}, "cannot be written"),
    ]
    for name, given, message in wrong:
        with pytest.raises(microslip.InputError, match=message):
            microslip.write_matrices(tmp_path / name, given)
        assert not (tmp_path / name).exists()


def box(n: int = 2) -> microslip.SolidMesh:
    """A row of unit cubes with a tetrahedron on top of the first."""
    x = np.array([(i, j, k) for i in range(n + 1) for j in (0, 1) for k in (0, 1)], dtype=float)
    cubes = np.array([[4 * i, 4 * i + 4, 4 * i + 6, 4 * i + 2, 4 * i + 1, 4 * i + 5, 4 * i + 7, 4 * i + 3] for i in range(n)])
    nodes = np.vstack([x, [[0.5, 0.5, 2.0]]])
    return microslip.SolidMesh(
        nodes,
        {"hex8": cubes, "tet4": np.array([[1, 5, 7, len(x)]])},
        volumes={"bar": np.arange(n), "cap": [n]},
        surfaces={"left end": [[0, 1, 3, 2]], "sides": [[0, 4, 5, 1], [1, 5, 12, -1]]},
        points={"tip": [len(x)]},
    )


def test_meshes_survive_gmsh(tmp_path: Path) -> None:
    mesh = box()
    microslip.write_mesh(tmp_path / "box.msh", mesh)
    found = microslip.read_mesh(tmp_path / "box.msh")
    np.testing.assert_array_equal(found.nodes, mesh.nodes)
    assert found.cells.keys() == mesh.cells.keys()
    for name in mesh.cells:
        np.testing.assert_array_equal(found.cells[name], mesh.cells[name])
        np.testing.assert_array_equal(found.cell_numbers[name], mesh.cell_numbers[name])
    for name in mesh.volumes:
        np.testing.assert_array_equal(found.volumes[name], mesh.volumes[name])
    assert found.points["tip"].tolist() == [12]
    # Faces are turned outward.
    assert {frozenset(row) for row in found.surfaces["sides"].tolist()} == {frozenset({0, 1, 4, 5}), frozenset({-1, 1, 5, 12})}
    assert found.bodies is not None and found.bodies.tolist() == [0, 0, 0]
    assert pickle.loads(pickle.dumps(found)) == found and found != mesh


def test_meshes_and_fields_go_to_vtk(tmp_path: Path) -> None:
    mesh = box()
    rng = np.random.default_rng(3)
    microslip.write_mesh(
        tmp_path / "box.vtu", mesh, point_fields={"u (m)": rng.normal(size=(13, 3))}, cell_fields={"energy": rng.normal(size=3)}
    )
    text = (tmp_path / "box.vtu").read_text()
    assert 'Name="u (m)" NumberOfComponents="3"' in text and 'Name="energy" NumberOfComponents="1"' in text
    found = microslip.read_mesh(tmp_path / "box.vtu")
    np.testing.assert_array_equal(found.nodes, mesh.nodes)
    assert found.volumes["material=0"].tolist() == [0, 1] and found.volumes["material=1"].tolist() == [2]


def test_decks_are_read(tmp_path: Path) -> None:
    (tmp_path / "one.inp").write_text(
        "*NODE\n10, 0, 0, 0\n20, 1, 0, 0\n30, 0, 1, 0\n40, 0, 0, 1\n*ELEMENT, TYPE=C3D4, ELSET=BODY\n5, 10, 20, 30, 40\n"
        "*NSET, NSET=TIP\n40\n"
    )
    found = microslip.read_mesh(tmp_path / "one.inp")
    assert found.cells["tet4"].tolist() == [[0, 1, 2, 3]] and found.labels is not None
    assert found.labels.tolist() == [10, 20, 30, 40] and found.points["TIP"].tolist() == [3]
    assert found.volumes["BODY"].tolist() == [0]


def test_wrong_meshes_are_named(tmp_path: Path) -> None:
    mesh = box()
    with pytest.raises(microslip.FileError, match="nowhere.msh"):
        microslip.read_mesh(tmp_path / "nowhere.msh")
    with pytest.raises(microslip.FileError, match="mesh of Gmsh"):
        microslip.read_mesh(tmp_path / "mesh.txt")
    (tmp_path / "bad.msh").write_text("$MeshFormat\nnonsense\n")
    with pytest.raises(microslip.FileError, match="bad.msh"):
        microslip.read_mesh(tmp_path / "bad.msh")
    with pytest.raises(microslip.InputError, match="columns"):
        microslip.SolidMesh(np.zeros((3, 2)), {})
    wrong: list[tuple[str, dict[str, Any], dict[str, Any], str]] = [
        ("a.msh", {"cells": {"hex9": [[0]]}}, {}, "hex27"),
        ("a.msh", {"cells": {"tet4": [[0, 1, 2]]}}, {}, "tet4 has 4"),
        ("a.msh", {"cells": {"tet4": [[0, 1, 2, 99]]}, "volumes": {}}, {}, "99"),
        ("a.msh", {"cells": {"tet4": [[0, 1, 2, -7]]}, "volumes": {}}, {}, "node"),
        ("a.msh", {"cell_numbers": {"hex8": [0, 1], "tet4": [1]}}, {}, "cell 1"),
        ("a.msh", {"volumes": {"a": [0], "b": [0]}}, {}, "in another one"),
        ("a.msh", {"volumes": {"a": [77]}}, {}, "no cell 77"),
        ("a.msh", {"surfaces": {"s": [[0, 1]]}}, {}, "2 nodes"),
        ("a.msh", {"points": {"p": [99]}}, {}, "99"),
        ("a.msh", {}, {"point_fields": {"u": np.zeros(13)}}, ".vtu"),
        ("a.vtu", {}, {"point_fields": {"u": np.zeros(5)}}, "13 points"),
        ("a.vtu", {}, {"cell_fields": {"u": np.zeros((3, 3, 3))}}, "shape"),
        ("a.stl", {}, {}, ".msh or .vtu"),
    ]
    for name, changes, arguments, message in wrong:
        parts = {"cells": mesh.cells, "volumes": mesh.volumes, **changes}
        with pytest.raises(microslip.InputError, match=message):
            microslip.write_mesh(tmp_path / name, microslip.SolidMesh(mesh.nodes, **parts), **arguments)
        assert not (tmp_path / name).exists()


def test_reduced_models_run_as_matrices(quick_scene: microslip.Scene, quick_run: microslip.Run, tmp_path: Path) -> None:
    stages: list[str] = []
    model = microslip.reduced_model(quick_scene, progress=lambda stage, _: stages.append(stage), cache=tmp_path)
    n = len(model["dofs"])
    assert model["K"].shape == model["M"].shape == (n, n) and model["R"].shape == (1, n) and stages
    np.testing.assert_array_equal(model["K"], model["K"].T)
    np.testing.assert_allclose(model["interface_nodes"], quick_run.interface.nodes, atol=1e-12)
    assert "SI units" in model["about"]
    microslip.write_matrices(tmp_path / "reduced.npz", model)
    fields = quick_scene.to_dict()
    fields["structure"] = {"matrices": {"path": str(tmp_path / "reduced.npz"), "coordinates": "jump", "response": {"number": 1}}}
    material = fields["model"]["material"]
    fields["model"] = {"material": {name: material[name] for name in ("youngs_modulus", "poisson_ratio")}}
    fields["interfaces"]["surface"] = {"benchmark": "brake-reuss-beam"}
    if fields["interfaces"].get("gap") == "measured":
        fields["interfaces"]["gap"] = {"benchmark": "brake-reuss-beam"}
    again = microslip.run(microslip.Scene.from_dict(fields), cache=False)
    np.testing.assert_allclose(again.frequency_hz, quick_run.frequency_hz, rtol=1e-6)


def test_half_models_are_refused(quick_scene: microslip.Scene) -> None:
    with pytest.raises(microslip.Error, match="half"):
        microslip.reduced_model(quick_scene.replace({"model.symmetry": "half"}))
    with pytest.raises(microslip.InputError, match="the scene is a int"):
        microslip.reduced_model(3)  # type: ignore[arg-type]
