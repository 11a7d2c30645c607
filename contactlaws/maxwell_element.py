"""One Maxwell element, a spring and a damper in line, through a time step in which its length changes evenly: exact, however long the step.

The strain z of its spring obeys z' = d' - z/tau, so a step of dt that adds `added` takes it to e z + h added with e = exp(-dt/tau) and
h = (1 - e) tau/dt, the share of what was added that is still held.
"""

from __future__ import annotations

import math

from contactlaws.compiled import inlined


@inlined
def decay(x):  # type: ignore[no-untyped-def]
    """e = exp(-x) and h = (1 - e)/x for a step over relaxation time x >= 0."""
    left, held, _ = decay_and_mean(x)
    return left, held


@inlined
def decay_and_mean(x):  # type: ignore[no-untyped-def]
    """`decay`, and (1 - h)/x: the mean over the step of what is held of what has been added by then, is that times all that is added.

    In a simulation x is small, and a series costs less.
    """
    if x < 0.01:
        mean = 1.0 / 2.0 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x / 720.0)))
        held = 1.0 - x * mean
        return 1.0 - x * held, held, mean
    left = math.exp(-x)
    held = -math.expm1(-x) / x if x < 1.0 else (1.0 - left) / x
    return left, held, (1.0 - held) / x


@inlined
def damped(strain, added, left, held):  # type: ignore[no-untyped-def]
    """What the damper takes in the step, over the spring's stiffness: int z^2 dt/tau, from the spring's `strain` before the step.

    left, held: e and h of `decay`.
    """
    gone = 1.0 - left
    x = gone / held  # dt/tau
    steady = x / 3.0 if x < 1e-3 else (x - 2.0 * gone + 0.5 * gone * (1.0 + left)) / (x * x)
    return max(0.0, 0.5 * strain * strain * gone * (1.0 + left) + strain * added * held * gone + added * added * steady)
