"""A gradient as splines, sampled finely enough for a lens and a tolerance.

Splines of step h with coefficients c have the transform C(k)·sinc⁴(kh), where C has the period 1/h. Samples of a field
with frequencies below f, filtered by 1/sinc⁴, give a field that is right at all |k| < f; its aliases lie beyond
1/h − f and are not passed by a lens with a lower cut-off. Only where the rim cuts the field do some of them contribute.
"""

from __future__ import annotations

import functools
import math
import re
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.core.arrays import F64
from camsim.errors import InvalidValueError
from camsim.scene.gradients import Gradient, SineStar
from camsim.scene.raster import Interpolation, Raster
from camsim.spectra.curve import Spectrum

MOST_SAMPLES = 64_000_000
TAPS, BAND = 16, 0.25  # of the filter, and its highest frequency, cycles per sample; accurate to 2e-14
MARGIN = 24  # samples beyond the rim: the influence of those farther out on splines is 0.27²⁴
PER_PITCHES = 1, 2, 3, 4, 5, 10, 16, 25  # samples in a whole number of pitches
FEWEST = 8  # smallest number of samples along a field's extent
# A star's waves run along its rim: where an axis is perpendicular to the rim they have no aliases along that axis, and
# elsewhere the line of light varies nearly as fast as the lens can pass. At most a hundredth of the bound remains.
ALONG_RIM = 10.0  # factor of the error that the bound allows then
OF_SMALLEST = 48  # samples along the smallest length over which a field changes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sampled(Raster):
    """A gradient's samples, which extend beyond its rim."""

    planes: F64
    spectra: tuple[Spectrum, ...]
    width_um: float
    centre_um: tuple[float, float]
    rotate_deg: float
    gradient: Gradient
    interpolation: Interpolation = "cubic"

    @property
    def kind(self) -> str:
        """The class name of the gradient, in words."""
        return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(self.gradient).__name__).lower()


def sampled(gradient: Gradient, cutoff_per_um: float, allowed: float, pitch_um: float, hidden: bool) -> Sampled:
    """Return a gradient's samples.

    cutoff_per_um : cut-off of the lens at its shortest wavelength;  allowed: error relative to black to white
    pitch_um      : pitch of the photosites;  hidden: whether later shapes may cut it
    """
    step_um = _step_um(gradient, cutoff_per_um, allowed, hidden)
    # A simple fraction of a pitch, or whole pitches: transforms along rows are FFTs then.
    part = step_um / pitch_um
    parts = (math.floor(part * whole) / whole for whole in PER_PITCHES)
    step_um = pitch_um * (max(parts) or 1.0 / math.ceil(1.0 / part) if part < 1.0 else math.floor(part))
    more = MARGIN + TAPS if gradient.cycles_per_um() else MARGIN
    counts = [2 * (math.ceil(half / step_um) + more) for half in gradient.half_um]
    if counts[0] * counts[1] > MOST_SAMPLES:
        raise InvalidValueError(
            f"{type(gradient).__name__} would take {counts[0] * counts[1]:.2g} samples, and the most is "
            f"{MOST_SAMPLES:.2g}; make it smaller or coarser, or allow a larger tolerance",
            key="shapes",
        )
    x, y = (step_um * (np.arange(count) - 0.5 * (count - 1)).astype(np.float64) for count in counts)
    planes = gradient.planes_at(x[None, :], y[:, None])
    if gradient.cycles_per_um():
        taps = _filter()
        for axis in (1, 2):
            planes = scipy.ndimage.correlate1d(planes, taps, axis=axis, mode="nearest")
    return Sampled(
        planes=planes,
        spectra=gradient.spectra,
        width_um=step_um * counts[0],
        centre_um=gradient.centre_um,
        rotate_deg=gradient.rotate_deg,
        gradient=gradient,
    )


def _step_um(gradient: Gradient, cutoff_per_um: float, allowed: float, hidden: bool) -> float:
    """Return the spacing of samples, µm."""
    f = float(gradient.cycles_per_um())
    step = min(*(2.0 * half / FEWEST for half in gradient.half_um), gradient.smallest_um / OF_SMALLEST)
    if not f:
        return step
    step = min(step, BAND / f, 0.98 / (cutoff_per_um + f))
    # Two aliases along either axis, of (f/(1/h − f))⁴ of the wave's amplitude, meet a rim. A wave of frequency k that
    # is cut leaves a line of light of 1/2πk, and the peak of a line's image is at most the cut-off.
    allowed *= ALONG_RIM if isinstance(gradient, SineStar) and not hidden else 1.0
    while 2.0 * (f * step / (1.0 - f * step)) ** 4 * cutoff_per_um / (2.0 * math.pi * (1.0 / step - f)) > allowed:
        step *= 0.9
    return step


@functools.cache
def _filter() -> F64:
    """Return taps (2·TAPS − 1,) of the filter (2 + cos 2πk)/3 / sinc⁴ k, to be applied before interpolation."""
    k = BAND * np.cos(np.pi * (np.arange(4 * TAPS) + 0.5) / (4 * TAPS))
    waves = np.cos(2.0 * np.pi * np.outer(k, np.arange(TAPS)))
    taps = np.linalg.lstsq(waves, (2.0 + np.cos(2.0 * np.pi * k)) / 3.0 / np.sinc(k) ** 4, rcond=None)[0]
    both: F64 = np.concatenate([0.5 * taps[:0:-1], taps[:1], 0.5 * taps[1:]])
    both.flags.writeable = False
    return both
