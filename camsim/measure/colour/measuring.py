"""Measured colours of the patches in a picture of a known scene."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from camsim.camera.capture import Capture
from camsim.core.arrays import F32, F64
from camsim.errors import UnsupportedError
from camsim.files.preview import demosaic
from camsim.measure.colour.areas import PatchArea, margin_pixel, patch_areas
from camsim.measure.colour.chart import Chart, Corner, read_chart, reflectance_names
from camsim.measure.colour.development import GREYS, Development, development_of
from camsim.measure.colour.matrix import PatchColours
from camsim.measure.colour.reference import expected_channels, reference_xyz
from camsim.measure.colour.result import ColourReport, PatchColour, WhiteBalance
from camsim.measure.demosaic.artefacts import delta_e_2000
from camsim.measure.demosaic.develop import lab, lab_of
from camsim.measure.demosaic.subject import CHANNELS
from camsim.measure.given import check_given
from camsim.measure.picture import Picture
from camsim.measure.straight import straightened
from camsim.measure.truth.spaces import balanced, full_scale_e, neutral_of
from camsim.sensor.colour_matrix import fit_for_development
from camsim.spectra.light import Light

_DEVELOPMENT = (
    "black level, white balance of {}, bilinear demosaicing, forward matrix to XYZ under D50; scale: {}; no tone curve"
)
"""Development for noise figures; mean colours use each channel's photosites, without demosaicing."""

_CLIPPED = 0.002
_GREY_CHROMA = 3.0


def measure_colour(picture: Picture, capture: Capture) -> ColourReport:
    """Measure the patches of a capture's scene.

    picture : mosaic or electrons of the capture, as read from a file
    capture : scene and camera (``camsim.load``; for a file: restored from its description)

    Raises UnsupportedError in one sentence for a camera without R, G and B, a picture of another size, or a scene
    without patches.
    """
    check_given(picture=picture, capture=capture)
    picture = straightened(picture, capture)
    camera = capture.camera
    if sorted(camera.cfa.channels) != sorted(CHANNELS):
        raise UnsupportedError(
            f"the camera has the channels {', '.join(camera.cfa.channels)}; colours need R, G and B", stage=picture.name
        )
    areas, small = patch_areas(capture)
    if not areas:
        raise UnsupportedError(
            f"the scene shows no patch: an even area in one piece, without holes, of 64 photosites or more that lie "
            f"{margin_pixel(capture):.0f} px from its outline; capture a chart such as colorchecker, larger",
            stage=picture.name,
        )
    light, order = linear_light(picture, capture), [camera.cfa.channels.index(letter) for letter in CHANNELS]
    to_xyz = fit_for_development(camera.colour_response(capture.light, capture.colour_matrix)).forward[:, order]
    reference = lab_of(reference_xyz(capture.light, [area.reflectance for area in areas]))
    whole = developed_light(light)
    left_out = [f"{small} shapes show too little, or hollow areas"] if small else []
    patches, means, used = [], [], []
    for number, area in enumerate(areas):
        if _clipped(picture, area):
            left_out.append(f"{area.name}: clipped; expose less")
            continue
        rows, cols = _slices(area)
        mean, error = _means(light[rows, cols], area)
        if not np.isfinite(mean).all():
            left_out.append(f"{area.name}: a channel has no photosite there, or one that is no number")
            continue
        patches.append(_patch(area, whole[rows, cols][area.inside], mean, error, reference[number], to_xyz))
        means.append(mean)
        used.append(number)
    if not patches:
        raise UnsupportedError(f"no patch can be measured ({left_out[-1]})", stage=picture.name)
    expected = expected_channels(capture, [areas[k].reflectance for k in used])[:, order]
    return ColourReport(
        file=picture.name,
        patches=tuple(patches),
        white_balance=_white_balance(patches, np.array(means), expected),
        left_out=tuple(left_out),
        development=_DEVELOPMENT.format("the file", "a perfect diffuser is 1"),
    )


def measure_chart(
    picture: Picture, light: Light, *, corners: Sequence[Corner] | None = None, chart: str = "ISO 17321-1"
) -> ColourReport:
    """Measure the patches of a ColorChecker in any raw file, developed as the file states.

    light   : on the chart
    corners : (row, col) of the centres of the patches dark skin, bluish green, black and white; None: detected
    chart   : measured reflectances: "ISO 17321-1" or "BabelColor Average"

    A file without a white balance is balanced on the chart's greys. Raises UnsupportedError if there is no
    chart, or if the file states no matrix.
    """
    return developed_chart(picture, light, corners=corners, chart=chart)[0]


def developed_chart(
    picture: Picture, light: Light, *, corners: Sequence[Corner] | None, chart: str
) -> tuple[ColourReport, Chart, Development]:
    """Return the report, the chart as read, and the development of the picture."""
    check_given(picture=picture)
    colours = PatchColours.of(reflectance_names(chart), light)
    seen = read_chart(picture, colours, corners=corners, chart=chart)
    one = development_of(picture, seen.mean)
    if one is None:
        message = "states no colour matrix; camsim calibrate colour measures one of such a chart"
        raise UnsupportedError(message, stage=picture.name)
    one = one.scaled(seen.mean, colours.xyz[GREYS, 1])
    light_seen = (seen.light / one.neutral).astype(np.float32)
    whole = developed_light(light_seen)
    unclipped = [k for k, full in enumerate(seen.clipped) if not full]
    patches = [
        _patch(
            seen.areas[k],
            whole[seen.displayed(seen.areas[k])][seen.areas[k].inside],
            seen.mean[k] / one.neutral,
            seen.error[k] / one.neutral,
            colours.lab[k],
            one.to_xyz,
        )
        for k in unclipped
    ]
    if not patches:
        raise UnsupportedError("all patches are clipped; expose less", stage=picture.name)
    report = ColourReport(
        file=picture.name,
        patches=tuple(patches),
        # Greys have flat spectra, so their deviations are the white balance's.
        white_balance=None
        if one.by_greys
        else _white_balance(patches, seen.mean[unclipped] / one.neutral, colours.xyz[unclipped, 1:2] * np.ones(3)),
        left_out=tuple(
            f"{area.name}: clipped; expose less" for area, full in zip(seen.areas, seen.clipped, strict=True) if full
        ),
        development=_DEVELOPMENT.format(
            "the chart's greys" if one.by_greys else "the file", "the chart's greys are as bright as they reflect"
        ),
    )
    return report, seen, one


def linear_light(picture: Picture, capture: Capture) -> F32:
    """Return (rows, cols, 3) balanced light, 1 for a perfect diffuser; NaN where a channel has no photosite.

    picture : ``straightened``, so that codes are proportional to charge
    """
    order = [capture.camera.cfa.channels.index(letter) for letter in CHANNELS]
    diffuser_e = capture.camera.diffuser_electrons(capture.light, capture.time_s).astype(np.float32)
    level = float(balanced(diffuser_e, capture)[order[1]])
    neutral = neutral_of(capture)[order]
    light = np.full((*picture.shape, 3), np.nan, np.float32)
    for plane in picture.planes:
        if plane.name[0] not in CHANNELS:
            continue
        k = CHANNELS.index(plane.name[0])
        # Codes have a white level, electrons do not.
        span = full_scale_e(capture) if plane.white is None else _span_dn(capture)
        where = slice(plane.first[0], None, plane.step[0]), slice(plane.first[1], None, plane.step[1])
        light[(*where, k)] = (plane.samples - plane.black) / (span * neutral[k] * level)
    return light


def _span_dn(capture: Capture) -> float:
    """Return the span in codes from black to clipping, after linearisation of the read-out."""
    adc = capture.camera.converter
    if capture.camera.nonlinearity is None:
        return float(capture.white_level_dn - adc.black_level_dn)
    return full_scale_e(capture) / adc.electrons_per_dn_at(capture.exposure.iso)


def developed_light(light: F32) -> F32:
    """Return (rows, cols, 3) with all channels at every photosite, by bilinear demosaicing of mosaics."""
    known = np.isfinite(light)
    if known.all():
        return light
    index = np.argmax(known, axis=2).astype(np.uint8)
    mosaic = np.take_along_axis(light, index[..., None].astype(np.intp), axis=2)[..., 0]
    whole: F32 = np.moveaxis(demosaic(np.nan_to_num(mosaic), index, 3), 0, 2)
    return whole


def _slices(area: PatchArea) -> tuple[slice, slice]:
    roi = area.roi
    return slice(roi.row, roi.row + roi.rows), slice(roi.col, roi.col + roi.cols)


def _clipped(picture: Picture, area: PatchArea) -> bool:
    """Whether any plane has clipped photosites in a patch's rectangle."""
    for plane in picture.planes:
        samples, _, _ = plane.cut(area.roi)
        if plane.white is not None and samples.size and float(np.mean(samples >= plane.white)) > _CLIPPED:
            return True
    return False


def _means(light: F32, area: PatchArea) -> tuple[F64, F64]:
    """Return the mean over each channel's photosites and its standard error, (3,) each."""
    mean, error = np.full(3, np.nan), np.zeros(3)
    for k in range(3):
        one = light[..., k][area.inside]
        one = one[np.isfinite(one)].astype(np.float64)
        if one.size > 1:
            mean[k], error[k] = one.mean(), one.std(ddof=1) / math.sqrt(one.size)
    return mean, error


def _patch(area: PatchArea, displayed: F32, mean: F64, error: F64, reference: F64, to_xyz: F64) -> PatchColour:
    # The mean, and the mean shifted by ± one standard error in each channel.
    moves = np.concatenate([np.zeros((1, 3)), np.diag(error), -np.diag(error)])
    colours = lab((mean + moves)[None].astype(np.float32), to_xyz)[0]
    difference = delta_e_2000(colours, np.broadcast_to(reference, colours.shape))
    each = lab(displayed[None], to_xyz)[0]
    luminance = np.einsum("c,nc->n", to_xyz[1], displayed.astype(np.float64))
    scatter = float(luminance.std(ddof=1))
    return PatchColour(
        name=area.name,
        roi=area.roi,
        photosites=int(np.count_nonzero(area.inside)),
        lab=_three(colours[0]),
        reference_lab=_three(reference),
        delta_e_2000=float(difference[0]),
        delta_e_error=float(np.linalg.norm(0.5 * (difference[1:4] - difference[4:]))),
        noise_lab=_three(each.std(axis=0, ddof=1)),
        snr_db=20.0 * math.log10(float(luminance.mean()) / scatter) if scatter > 0.0 < luminance.mean() else math.inf,
    )


def _three(values: F64) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])


def _white_balance(patches: Sequence[PatchColour], means: F64, expected: F64) -> WhiteBalance | None:
    grey = [k for k, p in enumerate(patches) if math.hypot(*p.reference_lab[1:]) < _GREY_CHROMA]
    if not grey:
        return None
    gain = means[grey].sum(axis=0) / expected[grey].sum(axis=0)
    off = [np.subtract(patches[k].lab, patches[k].reference_lab) for k in grey]
    return WhiteBalance(
        patches=tuple(patches[k].name for k in grey),
        r_over_g=float(gain[0] / gain[1]),
        b_over_g=float(gain[2] / gain[1]),
        chroma=float(np.mean([math.hypot(each[1], each[2]) for each in off])),
    )
