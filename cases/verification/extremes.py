"""How far the continuum solver goes: stiff, soft and nearly incompressible bodies, from 1e-5 of the radius to where the mesh ends.

Each case runs in a process of its own with a time limit. It ends with a curve (whole, or up to where the solver stopped, with the reason)
or with a refusal that says why; a case that does neither in its time is killed and breaks the claim of this table. Where a run on a
finer mesh is affordable, the force along the last four fifths of the path is held against it.

What ends a run early, as seen in the deformed meshes:

* A plastic body, at some .82 R with the default tolerance (.9 R with .005): all surface nodes of the coarser mesh but two rest on the flat,
  and the free surface that is left is a single folded element. The mesh ends, not the body: finer meshes go on to .93 R (8 divisions
  alone) and .96 R (12).
* An elastic body that keeps its volume (nu of .45 and more), at .6 to .7 R: in its centre the logarithms of the principal stretches differ
  by 2.6, and the elastic law, quadratic in them, loses ellipticity at 2.4 (Hill & Hutchinson 1975, for incompressible bodies in plane
  deformation). No mesh helps: that elastic law ends there. Yielding keeps elastic strains far below.

    python -m cases.verification.extremes [--jobs N] [--only TEXT]

Exit code 1 if a case neither ends in time nor says why it stopped.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

import fem
from contactlaws.curve import Curve, FloatArray
from contactlaws.errors import InputError
from contactlaws.material import Material

#: CPU seconds for one run; the slowest takes a quarter of it. On the clock it may take ten times that: the machine may be busy
TIME_LIMIT, PATIENCE = 240, 10
#: Young's modulus of the bodies that never yield; their forces scale with it
ELASTIC_MODULUS = 1000.0
#: tolerance of the run that is held against a finer one, and of that one
USUAL, FINER = 0.01, 0.005
#: of the table, with their widths
COLUMNS = (
    ("reached", 9),
    ("unloads", 8),
    ("balance", 9),
    ("force", 8),
    ("radius", 8),
    ("stiffn.", 8),
    ("force by", 9),
    ("reached", 9),
    ("s", 8),
)


class Case(NamedTuple):
    """One body and how far it is to be pressed; overlaps over the radius."""

    ratio: float | None  # Young's modulus over yield stress; None: never yields
    nu: float
    unload_from: tuple[float, ...]
    largest: float
    finer: bool = False  # whether it is computed on a finer mesh too

    @property
    def material(self) -> Material:
        """Yield stress 1."""
        return Material(ELASTIC_MODULUS, self.nu) if self.ratio is None else Material(self.ratio, self.nu, 1.0)

    @property
    def name(self) -> str:
        """As in the table."""
        body = "elastic" if self.ratio is None else f"E/Y {self.ratio:.6g}"
        return f"{body}, nu {self.nu:g}, to {self.largest:g} R"


CASES = (
    # small overlaps: round-off of the coordinates, contacts of a thousandth of the radius
    Case(1e3, 0.3, (1e-4,), 1e-4, True),
    Case(1e4, 0.3, (1e-4,), 1e-4),
    Case(1e4, 0.4999, (1e-4,), 1e-4),
    Case(1e4, 0.3, (1e-5,), 1e-5),
    Case(1e5, 0.3, (1e-5,), 1e-5),
    Case(1e2, 0.4999, (1e-5,), 1e-5),
    # four to five decades of overlap in one mesh
    Case(1e4, 0.3, (1e-4, 0.1, 0.6), 0.6, True),
    Case(1e3, 0.3, (1e-5, 0.6), 0.6),
    # stiff
    Case(1e4, 0.0, (0.1, 0.6), 0.6),
    Case(1e5, 0.3, (0.1, 0.6), 0.6),
    # nearly incompressible
    Case(1e4, 0.4999, (0.1, 0.3), 0.6),
    Case(1e3, 0.4999, (0.1, 0.6), 0.6, True),
    Case(1e2, 0.4999, (0.1, 0.6), 0.6),
    Case(1.0, 0.4999, (0.1, 0.4), 0.6),
    Case(None, 0.4999, (0.1, 0.4), 0.6, True),
    # until it truly ends
    Case(1e3, 0.0, (0.6, 0.7, 0.8), 0.9),
    Case(1e3, 0.3, (0.6, 0.7, 0.8), 0.9, True),
    Case(1e2, 0.3, (0.6, 0.7, 0.8), 0.9, True),
    Case(1e1, 0.3, (0.6, 0.7, 0.8), 0.9, True),
    Case(1.0, 0.3, (0.6, 0.7, 0.8), 0.9, True),
    Case(None, 0.3, (0.6, 0.7, 0.8), 0.9),
    Case(None, 0.45, (0.4, 0.6), 0.9),
)


class Outcome(NamedTuple):
    """What came of a case: a curve up to `reached`, or None and a reason."""

    reached: float | None  # overlap over the radius
    unloadings: int
    reason: str | None  # why it ends before its programme does
    balance: float | None  # work over stored and dissipated energy, less 1
    errors: Mapping[str, float]  # estimated
    overlap: FloatArray | None  # loading
    force: FloatArray | None
    cpu_seconds: float


class Result(NamedTuple):
    """An outcome with what became of the process."""

    case: Case
    outcome: Outcome | None  # None: no answer
    silence: str | None  # why there is no answer
    finer: Outcome | None

    @property
    def sound(self) -> bool:
        """It ended with a curve or a reason."""
        return self.outcome is not None and (self.outcome.reached is not None or self.outcome.reason is not None)

    def difference(self) -> float | None:
        """Mean relative difference of the force from that of the finer mesh, beyond a fifth of the overlap that both reached."""
        if self.outcome is None or self.finer is None or self.outcome.overlap is None or self.finer.overlap is None:
            return None
        assert self.outcome.force is not None
        assert self.finer.force is not None
        x, y, finer = self.outcome.overlap, self.outcome.force, self.finer.overlap
        inside = (x >= max(0.2 * x[-1], finer[0])) & (x <= finer[-1])
        expected = np.exp(CubicSpline(np.log(finer), np.log(self.finer.force))(np.log(x[inside])))
        return float(np.abs(y[inside] / expected - 1.0).mean())


def outcome_of(curve: Curve) -> Outcome:
    """The figures of a curve."""
    rows = curve.rows(0)
    overlap, force = curve.overlap[rows][1:], curve.force[rows][1:]
    facts = curve.provenance
    return Outcome(
        float(overlap[-1]), len(curve.unloadings), curve.stopped, facts["balance"], curve.errors, overlap, force, facts["cpu_seconds"]
    )


def compute(case: Case, tolerance: float) -> Outcome:
    """Press the body; a refusal is an outcome too."""
    began = time.process_time()
    try:
        return outcome_of(fem.press(case.material, unload_from=case.unload_from, max_overlap=case.largest, tolerance=tolerance))
    except InputError as refusal:
        return Outcome(None, 0, str(refusal), None, {}, None, None, time.process_time() - began)


def _answer(case: Case, tolerance: float, limit: int, to: Connection) -> None:
    with contextlib.suppress(ImportError):  # not on Windows: there the clock alone counts
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
    to.send(compute(case, tolerance))
    to.close()


def in_process(case: Case, tolerance: float, limit: int = TIME_LIMIT) -> tuple[Outcome | None, str | None]:
    """`compute` in a process of its own, which is killed after `limit` CPU seconds; an outcome, or why there is none."""
    ours, theirs = get_context("spawn").Pipe(duplex=False)
    process = get_context("spawn").Process(target=_answer, args=(case, tolerance, limit, theirs), daemon=True)
    process.start()
    theirs.close()
    try:
        if not ours.poll(PATIENCE * limit):
            process.kill()
            return None, f"killed after {PATIENCE * limit} s without an answer"
        return ours.recv(), None
    except EOFError:
        process.join()
        return None, f"no answer: ended with exit code {process.exitcode} ({limit} CPU seconds are allowed)"
    finally:
        process.join()


def run(case: Case) -> Result:
    """A case with its finer run."""
    outcome, silence = in_process(case, USUAL)
    worth = case.finer and outcome is not None and outcome.reached is not None
    return Result(case, outcome, silence, in_process(case, FINER)[0] if worth else None)


def lines(result: Result) -> Iterator[str]:
    """The rows of the table for one case."""
    found = result.outcome
    if found is None:
        yield f"{result.case.name:34s}   NO ANSWER: {result.silence}"
        return

    def text(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    wanted = len(result.case.unload_from)
    cpu = found.cpu_seconds + (result.finer.cpu_seconds if result.finer else 0.0)
    yield (
        f"{result.case.name:34s}{text(found.reached, '.4g'):>9s}{f'{found.unloadings} of {wanted}':>8s}{text(found.balance, '+.2%'):>9s}"
        f"{text(found.errors.get('force'), '.2%'):>8s}{text(found.errors.get('contact_radius'), '.2%'):>8s}"
        f"{text(found.errors.get('unloading_stiffness'), '.2%'):>8s}{text(result.difference(), '.2%'):>9s}"
        f"{text(result.finer and result.finer.reached, '.4g'):>9s}{cpu:8.1f}"
    )
    if found.reason:
        yield f"    stopped: {found.reason}"
    if result.case.finer and result.finer is None:
        yield "    the finer run gave no answer"


def main(arguments: list[str] | None = None) -> int:
    """Run the table; 0, or 1 if a case hangs or ends without a result or a reason."""
    parser = argparse.ArgumentParser(prog="python -m cases.verification.extremes", description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--jobs", type=int, default=1, help="cases at a time; default 1")
    parser.add_argument("--only", default="", help="only cases whose name contains this text")
    given = parser.parse_args(arguments)
    cases = [case for case in CASES if given.only in case.name]
    print(f"{len(cases)} cases, about {MINUTES:g} minutes on one core; each run has {TIME_LIMIT} CPU seconds")
    print(f"{'':51s}{'energy':>9s}{'estimated error of':>24s}{'finer mesh':>18s}{'CPU':>8s}")
    print(f"{'case':34s}" + "".join(f"{name:>{width}s}" for name, width in COLUMNS))
    results, began = [], time.perf_counter()
    with ThreadPoolExecutor(max(1, given.jobs)) as pool:
        for result in pool.map(run, cases):
            results.append(result)
            print("\n".join(lines(result)), flush=True)
    silent = [result for result in results if not result.sound or (result.case.finer and result.finer is None and result.outcome.reached)]  # type: ignore[union-attr]
    cpu = sum(each.cpu_seconds for result in results for each in (result.outcome, result.finer) if each)
    print(f"{cpu:.0f} CPU seconds, {time.perf_counter() - began:.0f} s; {len(silent)} of {len(results)} without a result or a reason")
    return 1 if silent else 0


#: what the whole table takes
MINUTES = 8.0

if __name__ == "__main__":
    sys.exit(main())
