"""Continuum reference curves: a body of revolution pressed against a rigid flat, by finite elements at finite strain."""

from fem.cycle import press_cycle
from fem.press import press
from fem.press_in_time import press_in_time
from fem.profile import press_profile

__all__ = ["press", "press_cycle", "press_in_time", "press_profile"]
