"""Contact laws: parameter records, the scalar compiled functions on them, and the reference curves they are held against.

`contactlaws.dispatch` knows the laws of this project without anybody having imported them. They are loaded when they are asked for, since
compiled code takes a second to load, and most of what needs this package (errors, files, curves) needs none of it.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # what computes with any law depends on all of these, and is found to do so by reading imports
    from contactlaws import edmans_sinka, elastic, elastoplastic, maxwell_zener, maxwell_zener_ting, rivals, tabulated, whole_range

__all__ = ["edmans_sinka", "elastic", "elastoplastic", "maxwell_zener", "maxwell_zener_ting", "rivals", "tabulated", "whole_range"]


def __getattr__(name: str) -> Any:
    if name in __all__:
        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
