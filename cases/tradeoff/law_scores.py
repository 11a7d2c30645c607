"""From a tournament to the table that `--tolerance` chooses laws by."""

from __future__ import annotations

from pathlib import Path

from calibration import law_choice
from calibration.tournament_entrants import entrants
from cases.tournament.run import read_scores
from contactlaws.version import code_version


def save_scores(folder: Path, path: Path) -> Path:
    """Write `path` from what `fe2dem tournament` wrote to `folder`: the entrants that a fit by the law's name alone gives."""
    plain = {entrant.name: entrant.law for entrant in entrants() if not entrant.free and not entrant.fixed and entrant.deepest is None}
    scores, nanoseconds = read_scores(folder)
    kept = [score._replace(entrant=score.law) for score in scores if score.entrant in plain]
    costs = {plain[name]: cost for name, cost in nanoseconds.items() if name in plain}
    return law_choice.save(path, kept, {law: costs[law] for law in sorted(costs)}, code_version())
