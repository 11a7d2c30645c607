"""Continuum reference curves: a body of revolution pressed against a rigid flat, by finite elements at finite strain."""

from fem.press import press

__all__ = ["press"]
