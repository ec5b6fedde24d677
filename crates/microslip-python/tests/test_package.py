"""The package: what it offers, how it is described, how fast it is imported."""

from __future__ import annotations

import doctest
import inspect
import os
import pkgutil
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import microslip

HERE = Path(__file__).parent
MODULES = ["microslip", *(f"microslip.{m.name}" for m in pkgutil.iter_modules(microslip.__path__) if not m.name.startswith("_"))]


def public() -> dict[str, object]:
    """Every public name of every module, with the methods and properties of classes."""
    found: dict[str, object] = {}
    for name in MODULES:
        module = import_module(name)
        for own in getattr(module, "__all__", []):
            value = getattr(module, own)
            if inspect.ismodule(value):
                continue
            found[f"{name}.{own}"] = value
            for member, of in vars(value).items() if inspect.isclass(value) else ():
                if not member.startswith("_") and (callable(of) or isinstance(of, (property, classmethod, staticmethod))):
                    found[f"{name}.{own}.{member}"] = of
    return found


@pytest.mark.parametrize("name", sorted(public()))
def test_every_public_name_has_a_description_with_an_example(name: str) -> None:
    text = inspect.getdoc(public()[name]) or ""
    assert len(text.splitlines()[0]) > 10 if text else False, f"{name} has no description"
    assert ">>> " in text, f"{name} has no example"


EXAMPLES = {
    test.name: test for name in MODULES for test in doctest.DocTestFinder().find(import_module(name)) if test.examples
}


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_examples_run(name: str) -> None:
    for optional in ("matplotlib", "pandas", "scipy"):
        if optional in (EXAMPLES[name].docstring or ""):
            pytest.importorskip(optional)
    said: list[str] = []
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    result = runner.run(EXAMPLES[name], out=said.append)
    assert result.attempted and not result.failed, "".join(said)


def test_every_public_name_is_exported_once() -> None:
    for name in MODULES:
        names = getattr(import_module(name), "__all__", [])
        assert sorted(names) == list(names) and len(set(names)) == len(names), name


def test_importing_takes_little_time() -> None:
    # Of NumPy, which every user has loaded anyway, and of the package on top of it.
    seconds = []
    for _ in range(5):
        command = [sys.executable, "-X", "importtime", "-c", "import microslip"]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        lines = [line.removeprefix("import time:").split("|") for line in done.stderr.splitlines()]
        totals = {name.strip(): int(total) for _, total, name in lines if total.strip().isdigit()}
        seconds.append(1e-6 * totals["microslip"])
    print(f"import microslip: {1e3 * min(seconds):.0f} ms")
    # Below 0.3 s on an idle machine; the bound is for a busy one.
    assert min(seconds) < 1.5


def test_importing_loads_nothing_that_it_does_not_need() -> None:
    code = "import sys, microslip; print([m for m in ('pandas', 'matplotlib', 'scipy') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout == "[]\n" and done.stderr == ""


def test_nothing_is_printed(beam_file: Path) -> None:
    code = f"import microslip; microslip.run(microslip.Scene.from_file({str(beam_file)!r}), cache=False)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("", "")


@pytest.mark.parametrize("document", ["README.md", "../../docs/guide/python.md", "../../docs/guide/python-data.md", "../../README.md"])
def test_examples_of_documents_run(document: str, tmp_path: Path, beam_file: Path) -> None:
    text = (HERE.parent / document).read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    assert blocks or document == "../../README.md"
    (tmp_path / "fixtures").symlink_to(HERE.parents[2] / "fixtures")
    done = subprocess.run([sys.executable, "-c", "\n".join(blocks)], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_the_command_that_scripts_use(quick_run: microslip.Run) -> None:
    code = (
        "import microslip; r = microslip.run(microslip.Scene.from_file('fixtures/scenes/brb-quick.json')); "
        "print(r.frequency_hz[0], r.damping_ratio[-1])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=HERE.parents[2], check=True, capture_output=True, text=True)
    first, last = done.stdout.split()
    backbone = quick_run.summary["backbone"]
    assert (float(first), float(last)) == (backbone[0]["frequency_hz"], backbone[-1]["damping_ratio"])


CONFIGURATION = str(HERE.parent / "pyproject.toml")


@pytest.mark.parametrize(
    "arguments",
    [
        ["mypy", "--config-file", CONFIGURATION, "-p", "microslip"],
        ["mypy.stubtest", "microslip._native", "--mypy-config-file", CONFIGURATION],
    ],
    ids=["mypy", "stubtest"],
)
def test_types_are_as_declared(arguments: list[str], tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    # Where the package is not installed but lies in a folder, types are looked for there.
    place = Path(microslip.__file__).parents[1]
    environment = dict(os.environ) if place.name == "site-packages" else {**os.environ, "MYPYPATH": str(place)}
    command = [sys.executable, "-m", *arguments]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
