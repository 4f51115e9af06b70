"""Expected figures of flats and darks from a camera's parameters."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from camsim.camera.camera import Camera
from camsim.core.arrays import F64
from camsim.core.typed import check
from camsim.errors import UnknownNameError
from camsim.measure.noise.photon_transfer import LEAST_LEVELS, off_the_line, within_linearity
from camsim.measure.noise.taking import DARK_TIMES_S, LEVELS, TIME_S, even_light, exposure_of
from camsim.measure.picture import channel_names, places_of

_STEP = 1e-4
"""Relative charge step for the read-out's slope."""


def expected_of(
    camera: Camera, channel: str, *, iso: float | None = None, temperature_c: float | None = None
) -> dict[str, float]:
    """Return the figures of ``PhotonTransfer`` computed from the camera's parameters; NaN where these give none.

    channel : as measured, greens of a Bayer array separate: G1 in the rows of red, G2; G is both
    iso, temperature_c : as the frames were taken
    """
    check(camera, Camera, "camera")
    if not places_of(check(channel, str, "channel"), list(camera.cfa.pattern)).any():
        raise UnknownNameError("channel", channel, _names(camera), key="channel")
    exposure = exposure_of(camera, iso=iso, temperature_c=temperature_c)
    iso, temperature_c, dark = exposure.iso, exposure.temperature_c, camera.dark_current
    dark_e_per_s = dark.e_per_s * dark.warming(temperature_c) if dark else 0.0
    dcnu_e = dark_e_per_s * dark.nonuniformity * TIME_S if dark else 0.0
    gain = camera.converter.electrons_per_dn_at(iso)
    offsets = (camera.dsnu.sigma_e if camera.dsnu else 0.0, camera.column_noise.sigma_e if camera.column_noise else 0.0)
    mapped_e = camera.offset_map.spread_e(gain) if camera.offset_map else 0.0
    linearity_error, steeper = _bend(camera, channel, iso, temperature_c)
    return {
        "gain_dn_per_e": 1.0 / gain,
        "read_noise_e": math.sqrt(camera.dark_noise_e(iso) ** 2 + dark_e_per_s * DARK_TIMES_S[0]),
        "full_well_e": _light_of_well_e(camera, iso, temperature_c),
        "dark_current_e_per_s": dark_e_per_s,
        "dsnu_e": math.hypot(*offsets, mapped_e, dcnu_e, _spread_e(camera, channel, iso)),
        "prnu": _pattern(camera, channel) * steeper,
        "linearity_error": linearity_error,
    }


def _light_of_well_e(camera: Camera, iso: float, temperature_c: float | None) -> float:
    """Return the charge of light at full well, as measured from flats, which excludes the dark charge."""
    well_e = camera.well_as_read_e(iso)
    return math.nan if well_e is None else well_e - _as_read_e(camera, camera.dark_e(TIME_S, temperature_c))


def _as_read_e(camera: Camera, charge_e: float) -> float:
    return charge_e if camera.nonlinearity is None else float(camera.nonlinearity.response(np.array([charge_e]))[0])


def _names(camera: Camera) -> set[str]:
    """Return the names of channels, with greens together and separate."""
    return {*camera.cfa.channels, *(name for row in channel_names(list(camera.cfa.pattern)) for name in row)}


def _places(camera: Camera, channel: str, period: tuple[int, int]) -> npt.NDArray[np.bool_]:
    """Return a mask of a channel's photosites within a period of whole patterns."""
    one = places_of(channel, list(camera.cfa.pattern))
    return np.tile(one, (period[0] // one.shape[0], period[1] // one.shape[1]))


def _spread_e(camera: Camera, channel: str, iso: float) -> float:
    """Standard deviation of the black offsets of a channel's photosites."""
    table = np.array(camera.converter.black_offsets_dn, np.float64)
    rows, cols = (math.lcm(*sizes) for sizes in zip(table.shape, camera.cfa.period, strict=True))
    offsets = np.tile(table, (rows // table.shape[0], cols // table.shape[1]))
    return float(offsets[_places(camera, channel, (rows, cols))].std()) * camera.converter.electrons_per_dn_at(iso)


def _flat_e(camera: Camera) -> tuple[F64, F64]:
    """Return the charge of a flat of 1 W/m² in the photosites of a period, and the sum of squares of its parts.

    Crosstalk adds light of other colours.
    """
    each_e = camera.replace(crosstalk=None).diffuser_electrons(even_light(1.0), TIME_S)
    exposed_e: F64 = each_e[camera.cfa.channel_index(*camera.cfa.period)]
    if camera.crosstalk is None:
        return exposed_e, exposed_e**2
    kernel = np.array(camera.crosstalk.kernel, np.float64)
    parts = [share * np.roll(exposed_e, (i - 1, j - 1), axis=(0, 1)) for (i, j), share in np.ndenumerate(kernel)]
    return np.sum(parts, axis=0), np.sum(np.square(parts), axis=0)


def _pattern(camera: Camera, channel: str) -> float:
    """PRNU as measured in a flat: crosstalk mixes independent gains, and light of other colours."""
    fraction = camera.prnu.fraction if camera.prnu else 0.0
    exposed_e, squares_e2 = (each[_places(camera, channel, camera.cfa.period)] for each in _flat_e(camera))
    if not exposed_e.mean() > 0.0:
        return math.nan
    return float(math.sqrt(fraction**2 * squares_e2.mean() + exposed_e.var()) / exposed_e.mean())


def _bend(camera: Camera, channel: str, iso: float, temperature_c: float | None) -> tuple[float, float]:
    """Return the effect of the profile's non-linear response on a channel's flats.

    These are the linearity error, and the factor on relative patterns of the charge where PRNU is measured, in the flat
    nearest to half of saturation. NaN if the channel has no signal, or too few levels.
    """
    if camera.nonlinearity is None:
        return 0.0, 1.0
    each_e = float(_flat_e(camera)[0][_places(camera, channel, camera.cfa.period)].mean())
    end_e = camera.converter.saturation_e(iso, camera.well_as_read_e(iso))
    dark_e = camera.dark_e(TIME_S, temperature_c)
    black_e = _as_read_e(camera, dark_e)
    if not each_e > 0.0 or black_e >= end_e:
        return math.nan, math.nan
    most_e = float(camera.diffuser_electrons(even_light(1.0), TIME_S).max())
    charge_e: F64 = np.array(LEVELS) * (each_e / most_e) * camera.charge_at_e(1.0, iso)
    low_e, read_e, high_e = (
        camera.nonlinearity.response(dark_e + step * charge_e) for step in (1.0 - _STEP, 1.0, 1.0 + _STEP)
    )
    signal_e = np.minimum(read_e, end_e) - black_e
    half = int(np.argmin(np.abs(signal_e - 0.5 * (end_e - black_e))))
    steeper = float((high_e[half] - low_e[half]) / (2.0 * _STEP * signal_e[half]))
    used = within_linearity(signal_e, end_e - black_e)
    if np.count_nonzero(used) < LEAST_LEVELS:
        return math.nan, steeper
    return off_the_line(charge_e[used], signal_e[used]), steeper
