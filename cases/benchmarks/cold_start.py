"""How long a scene takes from starting Python to its first step: with nothing compiled, and when all is found on the disk.

    python -m cases.benchmarks.cold_start [--scenes elastic,friction,...]

Each scene runs in two processes of its own, the first with an empty cache. Wall time, and the CPU time of what was compiled.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence

#: what a scene asks for; 64 spheres that touch
SCENES = {
    "elastic": "dem.Contact(hertz())",
    "friction": "dem.Contact(hertz(), mindlin(0.3, MATERIAL))",
    "whole_range": "dem.Contact(whole_range(MATERIAL._replace(yield_stress=7.9e9), RADIUS))",
    "quasi-static": "dem.Contact(hertz(), mindlin(0.3, MATERIAL))",
}
#: s; from starting Python to the first step
GOAL = 10.0
PROGRAM = """
import time
began, busy = time.time(), time.process_time()
import dem
from dem.packing import simple_cubic
from cases.benchmarks.settled_packing import MATERIAL, RADIUS, hertz
from contactlaws.tangential import mindlin
from contactlaws.whole_range import whole_range
imported = time.time()
crystal = simple_cubic((4, 4, 4), RADIUS)
box = crystal.box.stretched((0.999,) * 3)
bodies = dem.spheres(crystal.position * 0.999, RADIUS, 4750.0)
programme = (dem.isotropic_compression(1e-6, 1e-10),)
dem.run(dem.Scene(bodies, box, {contact}, programme, outputs=1, quasi_static={routine}))
print(time.time() - began, imported - began, time.process_time() - busy)
"""


def started(scene: str, cache: str) -> list[float]:
    """Seconds from the first line of Python to the end of the first steps, of them for imports, and CPU seconds."""
    routine = "dem.QuasiStatic()" if scene == "quasi-static" else "None"
    program = PROGRAM.format(contact=SCENES[scene], routine=routine)
    environment = os.environ | {"FE2DEM_CACHE_DIR": cache}
    done = subprocess.run([sys.executable, "-c", program], env=environment, check=True, capture_output=True, text=True)
    return [float(word) for word in done.stdout.split()[-3:]]


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scenes", default=",".join(SCENES))
    print(f"{'scene':14s}{'nothing compiled, s':>21s}{'of it imports':>15s}{'CPU s':>8s}{'compiled, s':>13s}{'ratio':>7s}{'goal':>6s}")
    for scene in parser.parse_args(arguments).scenes.split(","):
        with tempfile.TemporaryDirectory() as cache:
            cold, warm = started(scene, cache), started(scene, cache)
        verdict = "met" if cold[0] <= GOAL else "missed"
        print(f"{scene:14s}{cold[0]:21.1f}{cold[1]:15.1f}{cold[2]:8.1f}{warm[0]:13.1f}{cold[0] / warm[0]:7.1f}{verdict:>8s}", flush=True)


if __name__ == "__main__":
    main()
