"""Time of a run by the package against that of the program, on the same scene without a cache.

``python overhead.py [PROGRAM [SCENE [TIMES]]]``; by default the program in ``target/release``, the scaled-down Brake-Reuss beam, and five
times by turns, of which the least counts. Both are timed by their own account of the run (``timings`` of the summary); starting a
process is in neither. What the package adds around the run is printed beside it, and the processor time of both, which counts
where others use the machine; that of the program has its start and the writing of its files in it.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import microslip

REPOSITORY = Path(__file__).parents[3]


def processor_seconds(who: int) -> float:
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def main() -> None:
    arguments = dict(enumerate(sys.argv))
    folder = Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target")) / "release"
    program = Path(arguments.get(1, folder / "microslip"))
    path = Path(arguments.get(2, REPOSITORY / "fixtures" / "scenes" / "brb-quick.json"))
    scene = microslip.Scene.from_file(path)
    rows = []
    for _ in range(int(arguments.get(3, 5))):
        with tempfile.TemporaryDirectory() as out:
            used = processor_seconds(resource.RUSAGE_CHILDREN)
            subprocess.run([program, "run", path, "--no-cache", "--out", out], check=True, capture_output=True)
            of_program = (microslip.load(out).timings["total"], processor_seconds(resource.RUSAGE_CHILDREN) - used)
        used, began = processor_seconds(resource.RUSAGE_SELF), time.perf_counter()
        run = microslip.run(scene, cache=False, progress=lambda stage, done: None)
        seconds, total = time.perf_counter() - began, run.timings["total"]
        rows.append((*of_program, total, processor_seconds(resource.RUSAGE_SELF) - used, seconds - total))
    program_total, program_used, total, used, around = (min(column) for column in zip(*rows, strict=True))
    print(f"elapsed: program {program_total:.3f} s, package {total:.3f} s ({100 * (total / program_total - 1):+.1f} %)")
    print(f"processor: program {program_used:.3f} s, package {used:.3f} s ({100 * (used / program_used - 1):+.1f} %)")
    print(f"around the run: {1e3 * around:.1f} ms ({100 * around / total:.2f} %)")


if __name__ == "__main__":
    main()
