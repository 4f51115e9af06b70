"""Studies of many captures: points in parameter space, engines that take them, and the manifest."""

from camsim.study.dataset import Made, check_dataset, dataset, read_pair
from camsim.study.forecasting import Forecast, forecast, forecast_dataset
from camsim.study.study import Point, Study, read_dataset, read_study
from camsim.study.sweep import Swept, check_study, sweep

__all__ = [
    "Forecast",
    "Made",
    "Point",
    "Study",
    "Swept",
    "check_dataset",
    "check_study",
    "dataset",
    "forecast",
    "forecast_dataset",
    "read_dataset",
    "read_pair",
    "read_study",
    "sweep",
]
