"""A profile of a real camera from its own flats and darks."""

from camsim.measure.calibrate.calibration import Calibration, calibrate
from camsim.measure.calibrate.folder import Shot, ShotsOfCamera, read_folder
from camsim.measure.calibrate.setting import Setting

__all__ = ["Calibration", "Setting", "Shot", "ShotsOfCamera", "calibrate", "read_folder"]
