"""Many captures of one study: points among the keys, engines that take them, the manifest of what there is."""

from camsim.sweeping.dataset import Made, dataset, read_pair
from camsim.sweeping.study import Point, Study, read_dataset, read_study
from camsim.sweeping.sweep import Forecast, Swept, forecast, sweep

__all__ = [
    "Forecast",
    "Made",
    "Point",
    "Study",
    "Swept",
    "dataset",
    "forecast",
    "read_dataset",
    "read_pair",
    "read_study",
    "sweep",
]
