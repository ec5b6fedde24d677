"""What several tests need."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import beam
import microslip

REPOSITORY = Path(__file__).parents[3]
QUICK = REPOSITORY / "fixtures" / "scenes" / "brb-quick.json"


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A cache of the tests' own in the place of the user's, for processes that they start too."""
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("cache")
        patch.setenv("XDG_CACHE_HOME", str(folder))
        yield folder


@pytest.fixture(scope="session")
def beam_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene of a beam on two contacts, which runs in milliseconds."""
    return beam.write(tmp_path_factory.mktemp("beam"))


@pytest.fixture(scope="session")
def beam_run(beam_file: Path) -> microslip.Run:
    """Its run."""
    return microslip.run(microslip.Scene.from_file(beam_file), cache=False)


@pytest.fixture(scope="session")
def quick_scene() -> microslip.Scene:
    """The scaled-down benchmark."""
    return microslip.Scene.from_file(QUICK)


@pytest.fixture(scope="session")
def quick_run(quick_scene: microslip.Scene) -> microslip.Run:
    """Its run."""
    return microslip.run(quick_scene)
