"""A profile of a real camera from its own flats and darks."""

from camsim.measure.calibrate.calibration import Calibration, Setting, calibrate
from camsim.measure.calibrate.folder import Shot, ShotsOfCamera, read_folder

__all__ = ["Calibration", "Setting", "Shot", "ShotsOfCamera", "calibrate", "read_folder"]
