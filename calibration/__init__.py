"""From curves to laws: fitting, how far a fit can be trusted, and tables of fits."""

from calibration import recipe_edmans_sinka, recipe_whole_range, recipes_rivals  # noqa: F401  (makes the laws fittable)
from calibration.fit import Fit, fit
from calibration.identify import Identified, identify
from calibration.identify_data import Measured, read_measured
from calibration.predict import Prediction, predict

__all__ = ["Fit", "Identified", "Measured", "Prediction", "fit", "identify", "predict", "read_measured"]
