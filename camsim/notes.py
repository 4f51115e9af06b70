"""What a report says where a picture would surprise: no mistakes, but worth a sentence with a way out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.body import Body
from camsim.frame import ChannelSignal
from camsim.optics.own import own_stages
from camsim.optics.protocols import KnowsSplits
from camsim.rendering.auto import Choice
from camsim.rendering.edges import shares_within
from camsim.rendering.grid import Grid
from camsim.scene import Picture, Scene
from camsim.sensor.exposure import Exposure
from camsim.spectra.light import Light
from camsim.words import percent

# A full well that ends a percent beyond the last code is meant to end there.
_WORTH_A_NOTE = 1.01
# Splits of low-pass filters lie between half a pitch and a whole one; a quarter beyond is somebody's own choice.
_LEAST_SPLIT, _MOST_SPLIT = 0.4, 1.25
_FASTEST = 0.5
# Of codes: less is not seen in a picture.
_SEEN_DN = 0.5
_MUCH_CLIPPED = 0.05
# An error of a hundredth of the noise makes it 5e-5 larger; a thousandth is far finer.
_ENOUGH, _FAR_FINER = 1e-2, 1e-3
_WORTH_SECONDS = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """What is known of a picture before it is taken.

    time_s      : of the exposure, "auto" found
    noise       : whether the picture has noise
    mean_wanted : whether the mean is wanted for itself, as a truth
    """

    camera: Body
    scene: Scene
    light: Light
    exposure: Exposure
    time_s: float
    noise: bool
    mean_wanted: bool = False


def notes_before(setting: Setting, choice: Choice) -> Iterator[str]:
    """Yield what can be said before the picture is taken; ``choice``: how it will be rendered."""
    yield from _of_own_stages(setting.camera)
    yield from _of_the_optics(setting.camera)
    yield from _of_one_line(setting.camera, setting.light)
    yield from _of_the_converter(setting.camera, setting.exposure.iso)
    yield from _of_edges(setting.scene, choice)
    if setting.noise:
        yield from _of_dark_current(setting)
        if not setting.mean_wanted:
            yield from _of_the_tolerance(setting, choice)


def notes_after(signal: Sequence[ChannelSignal], camera: Body, iso: float) -> Iterator[str]:
    """Yield what the picture's signal at an ISO setting has to say."""
    well_e, electrons_per_dn = camera.well_as_read_e(iso), camera.adc.electrons_per_dn_at(iso)
    way_out = "exposure.time_s: auto (time_s='auto') puts white at 80 %"
    # By the mean: noise of the read-out scatters codes about white.
    if all(channel.min_e >= camera.adc.saturation_e(iso, well_e) for channel in signal):
        white_dn = camera.adc.white_level_dn(iso, well_e)
        yield f"every photosite is clipped at {white_dn} DN: nothing is left of the scene; {way_out}"
        return
    for channel in signal:
        share = channel.clipped_photosites / channel.photosites
        if share > _MUCH_CLIPPED:
            yield f"{percent(share)} of {channel.name} is clipped; {way_out}"
    most_dn = max(channel.max_e for channel in signal) / electrons_per_dn
    if 0.0 < most_dn < 1.0:
        yield (
            f"the brightest photosite is {most_dn:.2g} DN above black, less than one code: the picture is all noise; "
            f"more light, a longer exposure or a higher ISO would show the scene, or {way_out}"
        )


def _of_own_stages(camera: Body) -> Iterator[str]:
    if own := own_stages((*camera.optics.stages, *camera.stages)):
        yield f"not reproducible by camsim alone: {', '.join(own)} {'is' if len(own) == 1 else 'are'} of your own"


def _of_the_optics(camera: Body) -> Iterator[str]:
    n, olpf = camera.lens.f_number, camera.olpf
    if n < _FASTEST:
        yield (
            f"f/{n:g} is faster than physics allows: in air no lens is beyond f/{_FASTEST:g}, where rays come from the "
            "whole half-space; brightness and blur are what the formulas say there, of no lens that can be"
        )
    if isinstance(olpf, KnowsSplits):
        for split_um in dict.fromkeys(split for split in olpf.splits_um if split):
            pitches = split_um / camera.pitch_um
            if not _LEAST_SPLIT <= pitches <= _MOST_SPLIT:
                yield (
                    f"the OLPF's split of {split_um:g} µm is {pitches:.2g} pitches of {camera.pitch_um:g} µm; low-pass "
                    "filters split by half a pitch to a whole one, and split_pitches (from_pitches) goes with the pitch"
                )


def _of_one_line(camera: Body, light: Light) -> Iterator[str]:
    channels = camera.cfa.channels
    if light.line_nm is None or light.width_nm or len(channels) == 1:
        return
    seen = camera.diffuser_electrons(light, 1.0)
    if seen.max() > 0.0:
        shares = ", ".join(f"{name} {percent(e / seen.max())}" for name, e in zip(channels, seen, strict=True))
        yield (
            f"a colour sensor in light of one line at {light.line_nm:g} nm: every surface has one colour, and channels "
            f"get {shares} of the most; light={{illuminant: D65, illuminance_lux: 2000}} shows colours"
        )


def _of_the_converter(camera: Body, iso: float) -> Iterator[str]:
    adc, well_e = camera.adc, camera.well_as_read_e(iso)
    reach_e = (adc.largest_dn - adc.black_level_dn) * adc.electrons_per_dn_at(iso)
    if well_e is not None and iso <= adc.base_iso and well_e > reach_e * _WORTH_A_NOTE:
        yield (
            f"the converter ends at {reach_e:.0f} e⁻, below the full well of {well_e:.0f} e⁻: the well is never "
            "seen full; more electrons_per_dn or bits would show it"
        )


def _of_edges(scene: Scene, choice: Choice) -> Iterator[str]:
    if any(isinstance(shape, Picture) for shape in scene.shapes):
        return  # a picture is all detail, and where it lies nobody misses an edge
    job = choice.plan.job
    if scene.shapes and not _any_edge_within(job.edges.start, job.edges.end, job.grid):
        left, top = (job.grid.pitch_um * (first - 0.5) for first in job.grid.first_centre)
        right, bottom = left + job.grid.pitch_um * job.grid.cols, top + job.grid.pitch_um * job.grid.rows
        yield (
            f"no edge in the window, x from {left:.6g} to {right:.6g} µm and y from {top:.6g} to {bottom:.6g} µm of "
            "the optical axis: no outline of the scene runs through it, or only between surfaces that are equal; move "
            "the region or the shapes"
        )


def _any_edge_within(start: np.ndarray, end: np.ndarray, grid: Grid) -> bool:
    """Whether a piece of any edge lies in the window; all in pitches."""
    low = np.array(grid.first_centre) - 0.5
    high = low + np.array([grid.cols, grid.rows])
    enters, leaves = shares_within(start, end, low, high)
    return bool((enters <= leaves).any())


def _of_dark_current(setting: Setting) -> Iterator[str]:
    camera, exposure = setting.camera, setting.exposure
    if camera.dark_current is None:
        return
    dark_e = camera.dark_current.e_per_s * setting.time_s * camera.dark_current.warming(exposure.temperature_c)
    dark_dn = dark_e / camera.adc.electrons_per_dn_at(exposure.iso)
    if dark_dn >= _SEEN_DN:
        yield (
            f"the mosaic holds {dark_e:.3g} e⁻ ({dark_dn:.3g} DN) of dark current in the mean, which mean_electrons "
            "and truth, of light alone, do not: take it off before you compare them"
        )


def _of_the_tolerance(setting: Setting, choice: Choice) -> Iterator[str]:
    camera, iso, job = setting.camera, setting.exposure.iso, choice.plan.job
    diffuser_e = float(job.response.sum(axis=1).max())
    noise_e = math.hypot(camera.dark_noise_e(iso), camera.adc.electrons_per_dn_at(iso) / math.sqrt(12.0))
    error_e = job.tolerance * diffuser_e
    if not 0.0 < error_e < _FAR_FINER * noise_e:
        return
    enough = min(10.0 ** math.floor(math.log10(_ENOUGH * noise_e / diffuser_e)), 1e-2)
    seconds = choice.plan.cost.seconds
    if enough > job.tolerance and seconds >= _WORTH_SECONDS:
        yield (
            f"the tolerance of {job.tolerance:g} is {error_e:.2g} e⁻, far below the noise of {noise_e:.2g} e⁻ that the "
            f"darkest photosite has, and takes about {seconds:.2g} s of one core; {enough:g} would do"
        )
