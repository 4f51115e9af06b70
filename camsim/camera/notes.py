"""Notes of a report on unexpected results: not errors, but worth a sentence with a remedy."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.camera.body import Body
from camsim.camera.frame import ChannelSignal
from camsim.core.arrays import F64
from camsim.core.custom import custom_stages, is_custom
from camsim.core.note import Note
from camsim.core.words import both, percent
from camsim.optics.protocols import KnowsSplits, Round
from camsim.rendering.auto import Choice
from camsim.rendering.edges import shares_within
from camsim.rendering.grid import Grid
from camsim.scene import PointSource, Scene
from camsim.scene.primitives import flattened
from camsim.scene.raster import Field
from camsim.sensor.exposure import Exposure
from camsim.spectra.curve import Curve
from camsim.spectra.light import Light

# A full well within a percent above the last code is taken to coincide with it.
_WORTH_A_NOTE = 1.01
# Splits of low-pass filters are between half and one pitch; up to a quarter more is accepted as intended.
_LEAST_SPLIT, _MOST_SPLIT = 0.4, 1.25
# In codes: a smaller effect is not visible in a picture.
_SEEN_DN = 0.5
_MUCH_CLIPPED = 0.05
# Sheets give PRNU in per cent, mostly about 1, and K in codes per electron: a slip is off by far more than these.
_MUCH_PRNU, _MANY_TIMES = 0.1, 2.0
_LOOKED_AT = 100  # most shapes whose tables are examined
# An error of 1/100 of the noise increases it by 5e-5; 1/1000 is finer than needed.
_ENOUGH, _FAR_FINER = 1e-2, 1e-3
_WORTH_SECONDS, _WORTH_WAITING = 1.0, 20.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """What is known of a picture before it is taken.

    time_s      : exposure time, with "auto" resolved
    veil_e      : (channels,) electrons of veiling glare on the axis
    noise       : whether the picture has noise
    mean_wanted : whether the noise-free mean is a product, such as truth
    """

    camera: Body
    scene: Scene
    light: Light
    exposure: Exposure
    time_s: float
    veil_e: F64
    noise: bool
    mean_wanted: bool = False


def notes_before(setting: Setting, choice: Choice) -> Iterator[Note]:
    """Yield notes known before the picture is taken; ``choice``: the rendering method."""
    yield from _of_custom_stages(setting.camera)
    yield from _of_the_optics(setting.camera)
    yield from _of_one_line(setting.camera, setting.light)
    yield from _of_curves_outside_the_light(setting)
    yield from _of_glare(setting)
    yield from _of_the_converter(setting.camera, setting.exposure.iso)
    yield from _of_a_low_iso(setting.camera, setting.exposure.iso)
    yield from _of_prnu(setting.camera)
    if choice.plan.job.response.any():
        yield from _of_edges(setting.scene, choice)
    elif not setting.veil_e.any():
        yield from _of_no_light(setting.light)
    yield from _of_slow_stages(setting.camera, choice)
    if setting.noise:
        yield from _of_dark_current(setting)
        if not setting.mean_wanted:
            yield from _of_the_tolerance(setting, choice)


def notes_of_exposed(camera: Body, iso: float, below: int, *, encoded: bool) -> Iterator[Note]:
    """Yield notes on given light; ``below``: photosites with negative light; ``encoded``: it may not be linear."""
    yield from _of_custom_stages(camera)
    yield from _of_the_converter(camera, iso)
    yield from _of_a_low_iso(camera, iso)
    yield from _of_prnu(camera)
    if encoded:
        text = (
            "the reflectances are codes of a picture, taken as linear; those of a PNG or a JPEG are not: with unit "
            "srgb (--as srgb) they become light"
        )
        yield Note("codes-as-light", text, "light")
    if below:
        text = (
            f"{below} photosites would get less light than none (colours outside sRGB have parts below 0): 0 is taken"
        )
        yield Note("negative-light", text, "light")


def notes_of_sensor(camera: Body) -> Iterator[Note]:
    """Yield likely errors in copying a data sheet; not refused, as such sensors are possible."""
    adc = camera.converter
    yield from _of_the_converter(camera, adc.base_iso)
    yield from _of_prnu(camera)
    well_e, reach_e = camera.well_as_read_e(adc.base_iso), _reach_e(camera, adc.base_iso)
    if well_e is not None and not 1.0 / _MANY_TIMES < reach_e / well_e < _MANY_TIMES:
        per_dn = adc.electrons_per_dn
        yield Note(
            "gain-or-its-inverse",
            f"the converter's codes reach to {percent(reach_e / well_e)} of the full well; electrons_per_dn is 1/K: "
            f"if {per_dn:.4g} is the gain K in DN/e⁻, electrons_per_dn is {1.0 / per_dn:.4g}",
            "sensor.readout.electrons_per_dn",
        )


_AUTO = "exposure.time_s: auto (time_s='auto') puts white at 80 %"


def notes_after(signal: Sequence[ChannelSignal], camera: Body, iso: float, way_out: str = _AUTO) -> Iterator[Note]:
    """Yield notes on the picture's signal at an ISO setting, each with a remedy."""
    electrons_per_dn = camera.converter.electrons_per_dn_at(iso)
    # By the mean: read-out noise scatters codes around white.
    if all(channel.min_e >= camera.charge_at_e(1.0, iso) for channel in signal):
        white_dn = camera.converter.white_level_dn(iso, camera.well_as_read_e(iso))
        text = f"every photosite is clipped at {white_dn} DN: nothing is left of the scene; {way_out}"
        yield Note("all-clipped", text, "exposure.time_s")
        return
    for channel in signal:
        share = channel.clipped_photosites / channel.photosites
        if share > _MUCH_CLIPPED:
            yield Note("clipped", f"{percent(share)} of {channel.name} is clipped; {way_out}", "exposure.time_s")
    most_dn = max(channel.max_e for channel in signal) / electrons_per_dn
    if 0.0 < most_dn < 1.0:
        yield Note(
            "less-than-a-code",
            f"the brightest photosite is {most_dn:.2g} DN above black, less than one code: the picture is all noise; "
            f"more light, a longer exposure or a higher ISO would show the scene, or {way_out}",
            "exposure.time_s",
        )


def _of_custom_stages(camera: Body) -> Iterator[Note]:
    if each := custom_stages((*camera.optics.stages, *camera.stages)):
        text = f"not reproducible by camsim alone: {both(each)} {'is' if len(each) == 1 else 'are'} custom"
        yield Note("custom-stages", text, ", ".join(each))


def _of_the_optics(camera: Body) -> Iterator[Note]:
    olpf = camera.olpf
    if isinstance(olpf, KnowsSplits):
        for split_um in dict.fromkeys(split for split in olpf.splits_um if split):
            pitches = split_um / camera.pitch_um
            if not _LEAST_SPLIT <= pitches <= _MOST_SPLIT:
                yield Note(
                    "unusual-split",
                    f"the OLPF's split of {split_um:g} µm is {pitches:.2g} pitches of {camera.pitch_um:g} µm; low-pass "
                    "filters split by half a pitch to a whole one, and split_pitches (from_pitches) goes with "
                    "the pitch",
                    "sensor.olpf",
                )


def _of_one_line(camera: Body, light: Light) -> Iterator[Note]:
    channels = camera.cfa.channels
    if light.line_nm is None or light.width_nm or len(channels) == 1:
        return
    seen = camera.diffuser_electrons(light, 1.0)
    if seen.max() > 0.0:
        shares = ", ".join(f"{name} {percent(e / seen.max())}" for name, e in zip(channels, seen, strict=True))
        yield Note(
            "one-line",
            f"a colour sensor in light of one line at {light.line_nm:g} nm: every surface has one colour, and channels "
            f"get {shares} of the most; light={{illuminant: D65, illuminance_lux: 2000}} shows colours",
            "light",
        )


def _of_curves_outside_the_light(setting: Setting) -> Iterator[Note]:
    low_nm, high_nm = setting.light.ends_nm
    transmission = getattr(setting.camera.lens, "transmission", 1.0)
    some = Scene(background=setting.scene.background, shapes=setting.scene.shapes[:_LOOKED_AT])
    held = [("scene", "a reflectance", one) for one in some.spectra]
    for where, what, curve in (*held, ("lens.transmission", "the lens's transmission", transmission)):
        if not isinstance(curve, Curve) or curve.outside == "zero":
            continue
        begin_nm, end_nm = curve.wavelength_nm[0], curve.wavelength_nm[-1]
        if begin_nm > high_nm or end_nm < low_nm:
            value = curve.values[0 if begin_nm > high_nm else -1]
            yield Note(
                "curve-outside-light",
                f"{what} is known from {begin_nm:g} to {end_nm:g} nm, and this light has nothing there, but from "
                f"{low_nm:g} to {high_nm:g} nm: it is taken for {value:g} all over; tables are in nm, 4000 Å are 400",
                where,
            )
            return


def _of_no_light(light: Light) -> Iterator[Note]:
    low_nm, high_nm = light.ends_nm
    where = "" if low_nm == high_nm else f", {low_nm:g} to {high_nm:g} nm"
    yield Note(
        "no-light",
        f"nothing of the light ({light.name}{where}) reaches a channel of the sensor: the picture is black; take a "
        "light, a lens, filters and a sensor that meet",
        "light",
    )


def _of_glare(setting: Setting) -> Iterator[Note]:
    most_e = float(setting.veil_e.max())
    if most_e > 0.0:
        most_dn = most_e / setting.camera.converter.electrons_per_dn_at(setting.exposure.iso)
        yield Note(
            "veiling-glare",
            f"veiling glare gives every photosite up to {most_e:.3g} e⁻ ({most_dn:.3g} DN), black ones too, in the "
            "mosaic, mean_electrons and truth; veiling_glare 0 shows the scene without it",
            "lens.veiling_glare",
        )


def _of_slow_stages(camera: Body, choice: Choice) -> Iterator[Note]:
    """Yield why rendering is slow if the cause is a custom optical stage without declared capabilities."""
    more = tuple(camera.extra_optics)
    slow = [stage for stage in more or (camera.lens,) if is_custom(stage) and not isinstance(stage, Round)]
    if not slow or choice.cost.seconds < _WORTH_WAITING:
        return
    names = [type(stage).__name__ for stage in slow]
    way_out = "with a lens that is all of it and has" if more else "with"
    yield Note(
        "slow-stage",
        f"about {choice.cost.seconds:.2g} s of one core are expected: the pattern is summed from the transfer of "
        f"{both(names)} at each wavelength; it is quicker {way_out} "
        "point_spread(r_um, wavelength_nm), a larger tolerance or a smaller region",
        ", ".join(names),
    )


def _of_the_converter(camera: Body, iso: float) -> Iterator[Note]:
    adc, well_e = camera.converter, camera.well_as_read_e(iso)
    reach_e = _reach_e(camera, iso)
    if well_e is not None and iso <= adc.base_iso and well_e > reach_e * _WORTH_A_NOTE:
        yield Note(
            "well-not-reached",
            f"the converter ends at {reach_e:.0f} e⁻, below the full well of {well_e:.0f} e⁻: the well is never "
            "seen full; more electrons_per_dn or bits would show it",
            "sensor.readout.electrons_per_dn",
        )


def _of_a_low_iso(camera: Body, iso: float) -> Iterator[Note]:
    adc, well_e = camera.converter, camera.well_as_read_e(iso)
    if iso >= adc.base_iso:
        return
    stated = (
        f"ISO {iso:g} is below the base of {adc.base_iso:g}: a code stands for {adc.electrons_per_dn_at(iso):.4g} e⁻"
    )
    if well_e is None:
        yield Note(
            "iso-below-base",
            f"{stated}, and white for {_reach_e(camera, iso):.0f} e⁻, more than at the base, as no full well ends it; "
            "cameras have no such setting, give full_well_e or the base",
            "exposure.iso",
        )
    else:
        white_dn = adc.white_level_dn(iso, well_e)
        yield Note(
            "iso-below-base",
            f"{stated}, the well holds no more than at the base, and white is {white_dn} DN of {adc.largest_dn}; "
            "cameras "
            f"that offer it expose as at ISO {adc.base_iso:g} and let raw programs darken the picture",
            "exposure.iso",
        )


def _reach_e(camera: Body, iso: float) -> float:
    return (camera.converter.largest_dn - camera.converter.black_level_dn) * camera.converter.electrons_per_dn_at(iso)


def _of_prnu(camera: Body) -> Iterator[Note]:
    if camera.prnu is not None and camera.prnu.fraction > _MUCH_PRNU:
        given = camera.prnu.fraction
        yield Note(
            "large-prnu",
            f"a PRNU of {given:g} is {percent(given)} of the signal; sensors have about 1 %, and prnu is a fraction: "
            f"{given:g} % is {given / 100.0:g}",
            "sensor.charge.prnu",
        )


def _of_edges(scene: Scene, choice: Choice) -> Iterator[Note]:
    job = choice.plan.job
    if _any_field_within(scene, job.grid):
        return  # a picture or gradient has detail everywhere, so an absent edge needs no note
    if scene.shapes and not _any_edge_within(job.edges.start, job.edges.end, job.grid):
        left, top = (job.grid.pitch_um * (first - 0.5) for first in job.grid.first_centre)
        right, bottom = left + job.grid.pitch_um * job.grid.cols, top + job.grid.pitch_um * job.grid.rows
        yield Note(
            "no-edge",
            f"no edge in the window, x from {left:.6g} to {right:.6g} µm and y from {top:.6g} to {bottom:.6g} µm of "
            "the optical axis: no outline of the scene runs through it, or only between surfaces that are equal; move "
            "the region or the shapes",
            "region",
        )


def _any_field_within(scene: Scene, grid: Grid) -> bool:
    """Whether the bounding box of a picture or gradient meets the window, or a point lies in it."""
    low = (np.array(grid.first_centre) - 0.5) * grid.pitch_um
    high = low + np.array([grid.cols, grid.rows]) * grid.pitch_um
    points = np.array([shape.centre_um for shape in scene.shapes if isinstance(shape, PointSource)]).reshape(-1, 2)
    if ((points >= low) & (points <= high)).all(axis=1).any():
        return True
    outlines = flattened(shape for shape in scene.shapes if isinstance(shape, Field))
    boxes = [fill.curves.boxes for one in outlines for fill in one.fills]
    return any(bool(((box[:, :2].min(axis=0) < high) & (box[:, 2:].max(axis=0) > low)).all()) for box in boxes)


def _any_edge_within(start: np.ndarray, end: np.ndarray, grid: Grid) -> bool:
    """Whether a piece of any edge lies in the window; all in pitches."""
    low = np.array(grid.first_centre) - 0.5
    high = low + np.array([grid.cols, grid.rows])
    enters, leaves = shares_within(start, end, low, high)
    return bool((enters <= leaves).any())


def _of_dark_current(setting: Setting) -> Iterator[Note]:
    camera, exposure = setting.camera, setting.exposure
    if camera.dark_current is None:
        return
    dark_e = camera.dark_current.e_per_s * setting.time_s * camera.dark_current.warming(exposure.temperature_c)
    dark_dn = dark_e / camera.converter.electrons_per_dn_at(exposure.iso)
    if dark_dn >= _SEEN_DN:
        yield Note(
            "dark-current",
            f"the mosaic holds {dark_e:.3g} e⁻ ({dark_dn:.3g} DN) of dark current in the mean, which mean_electrons "
            "and truth, of light alone, do not: take it off before you compare them",
            "sensor.charge.dark_current_e_per_s",
        )


def _of_the_tolerance(setting: Setting, choice: Choice) -> Iterator[Note]:
    camera, iso, job = setting.camera, setting.exposure.iso, choice.plan.job
    diffuser_e = float(job.response.sum(axis=1).max())
    noise_e = math.hypot(camera.dark_noise_e(iso), camera.converter.electrons_per_dn_at(iso) / math.sqrt(12.0))
    error_e = job.tolerance * diffuser_e
    if not 0.0 < error_e < _FAR_FINER * noise_e:
        return
    enough = min(10.0 ** math.floor(math.log10(_ENOUGH * noise_e / diffuser_e)), 1e-2)
    seconds = choice.plan.cost.seconds
    if enough > job.tolerance and seconds >= _WORTH_SECONDS:
        yield Note(
            "tolerance-below-noise",
            f"the tolerance of {job.tolerance:g} is {error_e:.2g} e⁻, far below the noise of {noise_e:.2g} e⁻ that the "
            f"darkest photosite has, and takes about {seconds:.2g} s of one core; {enough:g} would do",
            "render.tolerance",
        )
