"""Many captures of one study: points among the keys, engines that take them, the manifest of what there is."""

from camsim.sweeping.study import Point, Study, read_study
from camsim.sweeping.sweep import Forecast, Swept, forecast, sweep

__all__ = ["Forecast", "Point", "Study", "Swept", "forecast", "read_study", "sweep"]
