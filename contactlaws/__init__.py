"""Contact laws: parameter records, the scalar compiled functions on them, and the reference curves they are held against.

Importing this package makes the laws of this project known to `contactlaws.dispatch`.
"""

from contactlaws import edmans_sinka, elastic, elastoplastic, rivals, tabulated, whole_range

__all__ = ["edmans_sinka", "elastic", "elastoplastic", "rivals", "tabulated", "whole_range"]
