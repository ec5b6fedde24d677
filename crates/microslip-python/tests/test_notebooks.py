"""The notebooks run, and show their figures."""

from __future__ import annotations

import base64
import importlib
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

NOTEBOOKS = Path(__file__).parents[1] / "notebooks"

#: Runs a notebook where there is no kernel: without a file of its own, so that worker processes do not run it again.
SCRIPT = """
import sys
from pathlib import Path
path = Path({path!r})
sys.path.insert(0, str(path.parent))
exec(compile(path.read_text(encoding="utf-8"), path.name, "exec"))
from matplotlib.figure import Figure
figures = [value for value in list(globals().values()) if isinstance(value, Figure)]
for number, figure in enumerate(figures, 1):
    figure.savefig(f"{{path.stem}}-{{number}}.png")
"""


def in_a_kernel(path: Path, folder: Path) -> str:
    """Runs the cells as a reader does, keeps the figures that are shown, and gives what is printed."""
    jupytext, nbclient = (importlib.import_module(module) for module in ("jupytext", "nbclient"))
    notebook = jupytext.read(path)
    nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(path.parent)}}).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    shown = [output["data"]["image/png"] for output in outputs if "image/png" in output.get("data", {})]
    for number, png in enumerate(shown, 1):
        (folder / f"{path.stem}-{number}.png").write_bytes(base64.b64decode(png))
    return "".join(output["text"] for output in outputs if output.output_type == "stream")


def as_a_script(path: Path, folder: Path) -> str:
    done = subprocess.run([sys.executable, "-c", SCRIPT.format(path=str(path))], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("path", sorted(path for path in NOTEBOOKS.glob("*.py") if path.stem != "sample_joint"), ids=lambda path: path.stem)
def test_notebooks_run(path: Path, tmp_path: Path, own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("matplotlib", "pandas", *(["distributed"] if "dask" in path.stem else [])):
        pytest.importorskip(module)
    # That of notebooks is chosen by their kernel.
    monkeypatch.delenv("MPLBACKEND", raising=False)
    folder = Path(os.environ.get("MICROSLIP_FIGURES", tmp_path))
    folder.mkdir(parents=True, exist_ok=True)
    kernel = all(importlib.util.find_spec(module) for module in ("jupytext", "nbclient", "ipykernel"))
    if not kernel:
        monkeypatch.setenv("MPLBACKEND", "agg")
    said = in_a_kernel(path, folder) if kernel else as_a_script(path, folder)
    assert list(folder.glob(f"{path.stem}-*.png")), "it shows no figure"
    if path.stem == "published_epmc":
        published = Path(os.environ.get("BRB_REFERENCE", ".")) / "published.json"
        assert ("skipped" in said) != published.exists()
