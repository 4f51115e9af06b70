"""Noise after EMVA 1288: figures with their errors from flats and darks."""

from camsim.measure.noise.estimate import Estimate
from camsim.measure.noise.measuring import measure_noise
from camsim.measure.noise.photon_transfer import PhotonTransfer
from camsim.measure.noise.profile import expected_of
from camsim.measure.noise.result import ChannelNoise, NoiseReport
from camsim.measure.noise.shots import Group, Shots, read_shots, write_shots
from camsim.measure.noise.taking import take_shots

__all__ = [
    "ChannelNoise",
    "Estimate",
    "Group",
    "NoiseReport",
    "PhotonTransfer",
    "Shots",
    "expected_of",
    "measure_noise",
    "read_shots",
    "take_shots",
    "write_shots",
]
