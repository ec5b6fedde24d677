"""Time of a run by the package against that of the program, on the same scene without a cache.

``python overhead.py [PROGRAM] [SCENE]``; by default the program in ``target/release`` and the flat Brake-Reuss beam. Both are timed
by their own account of the run (``timings`` of the summary), by turns, and the least of three counts: starting processes and Python
is in neither. What the package adds around the run is printed beside it.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import microslip

REPOSITORY = Path(__file__).parents[3]


def main() -> None:
    folder = Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target")) / "release"
    program = Path(sys.argv[1]) if len(sys.argv) > 1 else folder / "microslip"
    path = Path(sys.argv[2]) if len(sys.argv) > 2 else REPOSITORY / "fixtures" / "scenes" / "brb-flat.json"
    scene = microslip.Scene.from_file(path)
    rust, own, around = [], [], []
    for _ in range(3):
        with tempfile.TemporaryDirectory() as out:
            subprocess.run([program, "run", path, "--no-cache", "--out", out], check=True, capture_output=True)
            rust.append(microslip.load(out).timings["total"])
        began = time.perf_counter()
        run = microslip.run(scene, cache=False, progress=lambda stage, done: None)
        around.append(time.perf_counter() - began - run.timings["total"])
        own.append(run.timings["total"])
    print(f"program {min(rust):.3f} s, package {min(own):.3f} s ({100 * (min(own) / min(rust) - 1):+.1f} %)")
    print(f"around the run: {1e3 * min(around):.1f} ms ({100 * min(around) / min(own):.2f} %)")


if __name__ == "__main__":
    main()
