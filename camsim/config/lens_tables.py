"""The numbers of a lens file from rays: wavefronts, distortion, lateral colour, illumination, and residuals."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from camsim.config import yaml_source
from camsim.config.lens_check import CHECKED_NM, CYCLES_PER_MM, compared, even_disc, least_squares
from camsim.config.lens_files import lens_of
from camsim.config.lens_rays import NEAR_AXIS, Beam, Lens, Prescription, or_aim
from camsim.core.arrays import F64
from camsim.core.cores import one_blas_thread
from camsim.core.note import Note
from camsim.errors import InputError
from camsim.numerics.zernike import cosines, orders
from camsim.optics.field_lens import FieldLens
from camsim.optics.wavefront import MOST_WAVES

WAVELENGTHS_NM = (380.0, 410.0, 440.0, 470.0, 500.0, 530.0, 560.0, 590.0, 620.0, 650.0, 690.0, 740.0, 780.0)
STEPS = (12, 24, 48)  # of the radius: as required by wavefronts in between
BETWEEN = 0.01  # waves rms: largest error of wavefronts between heights
ORDERS = (8, 10, 12, 14, 16, 18, 20)  # of Zernikes: as required by the rays
LEFT = 0.005  # waves rms: largest residual
DROPPED = 0.002  # waves rms of all omitted coefficients together
CLOSED = 0.1  # weight of a ray that a rim stops: without light, but it keeps the wavefront bounded
RAYS = 720  # over the pupil, of equal areas; one half of them is traced
EXPOSED_STEP = 2e-4  # of the field, over which the sky is compared with where it falls
BRIGHTER = 1e-3  # of the light on the axis: a larger excess off the axis is refused, a smaller one is rounding
DRAWN = 1e-5  # of a height: largest error of distortion between heights
DRAWN_STEPS = (16, 32, 64, 128, 256)
BALANCED = 0.1  # of the squared blur: if less remains at the best focus, the sensor is misplaced


QUARTER = even_disc(RAYS)[:, (even_disc(RAYS) > 0.0).all(axis=0)]
HALF_DISC = np.concatenate([QUARTER, QUARTER * [[-1.0], [1.0]]], axis=1)  # even along the radius, as a disc is


class Traced(NamedTuple):
    """A lens file's text, and its residuals against the rays.

    largest : the largest coefficient, waves
    zernikes : number of Zernike polynomials
    left  : rms residual of the Zernikes at the worst place, waves
    mtf   : differences of transfers (fields, wavelengths, 2 directions: along the radius and across, frequencies)
    places_um : distances of these fields from the axis
    notes : on the prescription
    """

    text: str
    largest: float
    zernikes: int
    left: float
    mtf: F64
    places_um: tuple[float, ...]
    notes: tuple[Note, ...]

    @property
    def stated(self) -> str:
        """The residuals of the file as one line of text."""
        each = ", ".join(f"{one:.4f} at {um / 1e3:.4g} mm" for um, one in zip(self.places_um, self._off, strict=True))
        return f"{self.zernikes} Zernikes leave {self.left:.4f} waves rms; MTF off the rays' by {each}"

    @property
    def _off(self) -> list[float]:
        """The largest MTF difference at each place."""
        largest: list[float] = np.abs(self.mtf).max(axis=(1, 2, 3)).tolist()
        return largest

    def check_mtf(self, within: float, name: str) -> None:
        """Raise InputError for an unreadable file, or one whose MTF differs by more than ``within`` from the rays'."""
        if self.largest > MOST_WAVES:
            raise InputError(
                f"{name!r} makes {self.largest:.3g} waves rms, and a lens file holds {MOST_WAVES:g}; give it a smaller "
                "field (--field), or a sensor in focus"
            )
        good = [one <= within for one in self._off]
        if all(good):
            return
        k = good.index(False)
        w, direction, n = np.unravel_index(int(np.abs(self.mtf[k]).argmax()), self.mtf[k].shape)
        way = ("along the radius", "across the radius")[int(direction)]
        smaller = f", or a smaller field (--field-mm {self.places_um[k - 1] / 1e3:.4g})" if k > 1 else ""
        raise InputError(
            f"{name!r} has no circle for its cone of light {self.places_um[k] / 1e3:.4g} mm from the axis, and a lens "
            f"file has: its MTF there, {way} at {CYCLES_PER_MM[int(n)]:g} cycles/mm and {CHECKED_NM[int(w)]:g} nm, "
            f"would be {self.mtf[(k, w, direction, n)]:+.4f} off the rays', {max(self._off):.4f} at the worst; take it "
            f"so with --mtf-within {math.ceil(1e3 * max(self._off)) / 1e3:g}{smaller}"
        )


@one_blas_thread()
def lens_file(
    stated: Prescription, full_rad: float, *, name: str, source: str, comment: str = "", notes: Sequence[Note] = ()
) -> Traced:
    """Trace a lens to a field, radians, and return its file; raises InputError where a file cannot hold it.

    Off the axis the cone of light is an ellipse, in a lens file a circle. The ellipse, that of the open pupil's second
    moments, is mapped to the circle, and the wavefront is the one that sends each ray to where the real ray falls.
    """
    lens, middle = stated.of_wavelengths(WAVELENGTHS_NM), stated.of_wavelengths((stated.middle_nm,))
    [axis] = middle.beams([0.0], np.concatenate([[[1.0], [0.0]], HALF_DISC], axis=1))
    aperture = float(np.abs(axis.pupil[0, 0, 0]))
    f_number = 0.5 / aperture
    spread = np.sqrt((axis.pupil[:, 0, 1:] ** 2).mean(axis=1)) / aperture  # of a disc, and of it one half
    notes = list(notes)
    if out_mm := _out_of_focus(axis, stated.middle_nm / 1e6):
        f_number = 0.5 * abs(middle.focal_mm) / (middle.radius_mm * middle.vignetted(0.0)[1])
        side_of = "behind" if out_mm > 0.0 else "before"
        text = f"the sensor lies {abs(out_mm):.3g} mm {side_of} the best focus; the f-number is that of the focus"
        notes.append(Note("out-of-focus", text, "f_number"))
    if not math.isfinite(f_number):
        raise InputError(f"{name!r} lets no ray of its pupil's rim pass on the axis; give it a smaller pupil")
    for steps in STEPS:
        angles = full_rad * np.arange(2 * steps + 1) / (2 * steps)
        # Half steps serve to check the steps.
        chief_mm = np.array([beam.chief_mm[0] for beam in middle.beams(angles, np.empty((2, 0)))])
        side = math.copysign(1.0, float(chief_mm[1]))
        _validate_heights(side * chief_mm, angles, name, aim=stated.aim)
        beams = lens.beams(angles, HALF_DISC)
        indices, waves, left = _fitted(beams, 0.5 / f_number, spread, side, angles, name)
        heights_um = 1e3 * np.abs(chief_mm)
        most = float(np.abs(waves).max())
        if most > MOST_WAVES or _between(f_number, heights_um, indices, waves) <= BETWEEN:
            break
    needed = _needed(waves)
    left = math.hypot(left, DROPPED)
    every = slice(None, None, 2)
    lateral_um = 1e3 * (side * np.array([beam.chief_mm for beam in beams[every]]).T - np.abs(chief_mm[every]))
    lateral_um[:, 0] = 0.0
    light = _light(middle, angles[every], np.abs(chief_mm[every]), name)
    drawn_um, distortion = _distortion(middle, full_rad, side)
    rows: list[tuple[str, Any]] = [
        ("wavelength_nm", list(WAVELENGTHS_NM)),
        ("height_um", _rounded(heights_um[every], 3)),
        ("zernike", [indices[k] for k in needed]),
        ("distortion_height_um", _rounded(drawn_um, 3)),
        ("distortion", _rounded(distortion, 8)),
        ("relative_illumination", _rounded(np.minimum(light, 1.0), 5)),
    ]
    head = [f"# {line}" for line in (f"{comment or name}.", *notes)]
    head += ["camsim: lens/1", f"name: {json.dumps(name)}", f"source: {json.dumps(source)}"]
    body = [f"f_number: {round(f_number, 5)}", *(f"{key}: {json.dumps(values)}" for key, values in rows)]
    body += ["lateral_colour_um:", *(f"  - {json.dumps(_rounded(row, 4))}" for row in lateral_um)]
    body += ["waves: # for each wavelength, for each height, of each Zernike"]
    for of_wavelength in waves[:, every][:, :, needed]:
        of_heights = [json.dumps(_rounded(row, 5)) for row in of_wavelength]
        body += [f"  {'- ' if k == 0 else '  '}- {row}" for k, row in enumerate(of_heights)]
    head.append(f"residual_waves: {left:.4f}")
    if most > MOST_WAVES:
        text = "\n".join([*head, *body]) + "\n"
        return Traced(text, most, len(needed), left, np.empty((0, 1, 1, 1)), (), tuple(notes))
    found = lens_of(yaml_source.parse("\n".join([*head, *body]).encode("utf-8"), f"{name}.yaml", Path()))
    mtf, places_um = compared(stated, full_rad, found, name)
    head.append(f"residual_mtf: {np.abs(mtf).max():.4f}")
    return Traced("\n".join([*head, *body]) + "\n", most, len(needed), left, mtf, places_um, tuple(notes))


def _out_of_focus(axis: Beam, wave_mm: float) -> float:
    """Return the distance of the sensor behind the focus, mm, if defocus dominates the blur on the axis; else 0.

    The cone of light from the exit pupil to a sensor that is far out of focus is not that of the lens's f-number.
    """
    fallen, pupil = axis.fallen_mm[:, 0], axis.pupil[:, 0]
    out_mm = float((fallen * pupil).sum() / (pupil**2).sum())
    rim_waves = 0.5 * abs(out_mm) * float((pupil**2).sum(axis=0).max()) / wave_mm
    left = float(((fallen - out_mm * pupil) ** 2).sum() / (fallen**2).sum())
    return -out_mm if rim_waves > 1.0 and left < BALANCED else 0.0


def _rounded(values: F64, digits: int) -> list[float]:
    return [float(v) + 0.0 for v in np.round(values, digits).tolist()]


def _validate_heights(height_mm: F64, angles: F64, name: str, *, aim: bool) -> None:
    """Raise InputError if chief rays are lost, or if image heights do not increase with the field."""
    lost = ~np.isfinite(height_mm)
    lost[1:] |= np.diff(height_mm) <= 0.0
    if lost.any():
        reached = math.degrees(angles[max(int(np.argmax(lost)) - 1, 0)])
        raise InputError(
            f"{name!r} has no chief ray past {reached:.4g}° from the axis that falls farther out; {or_aim(aim)}give it "
            f"a smaller field, such as --field {math.floor(10.0 * reached) / 10.0:g}"
        )


def _fitted(
    beams: Sequence[Beam], aperture: float, spread: F64, side: float, angles: F64, name: str
) -> tuple[tuple[int, ...], F64, float]:
    """Return Zernikes, their coefficients (w, heights, k) in waves, and the largest residual, waves rms."""
    for order in ORDERS:
        some = [(k, w) for k in (0, len(beams) // 2, len(beams) - 1) for w in (0, len(WAVELENGTHS_NM) // 2)]
        if all(_fit(beams[k], w, order, aperture, spread, side, angles[k], name)[2] <= LEFT for k, w in some):
            break
    found = [
        [_fit(beam, w, order, aperture, spread, side, angle, name) for beam, angle in zip(beams, angles, strict=True)]
        for w in range(len(WAVELENGTHS_NM))
    ]
    waves = np.array([[one[1] for one in row] for row in found])
    indices = found[0][0][0]
    # On the axis everything is rotationally symmetric.
    waves[:, 0, [k for k, index in enumerate(indices) if orders(index)[1]]] = 0.0
    return indices, waves, max(one[2] for row in found for one in row)


def _fit(
    beam: Beam, w: int, order: int, aperture: float, spread: F64, side: float, angle: float, name: str
) -> tuple[tuple[int, ...], F64, float]:
    """Return Zernikes, coefficients that direct rays to where they fall, and the residual of the path, waves rms."""
    known, passes = np.isfinite(beam.path_mm[w] + beam.pupil[0, w]), beam.passes[w]
    if passes.sum() < 0.02 * passes.size:
        raise InputError(
            f"no light of {name!r} passes {math.degrees(angle):.4g}° from the axis; give a smaller field (--field)"
        )
    seen = beam.pupil[:, w][:, passes]
    # Of both halves, so the middle lies on the radius.
    middle = np.array([seen[0].mean(), 0.0])[:, None]
    halves = np.sqrt(np.array([seen[0].var(), (seen[1] ** 2).mean()]))[:, None] / spread[:, None]
    place = (beam.pupil[:, w] - middle) / halves
    known &= np.hypot(*place) <= 1.01
    x, y = side * place[0, known], place[1, known]
    weight = np.where(passes[known], 1.0, CLOSED)
    index, values, along_x, along_y = cosines(order, x, y)
    wave_mm = WAVELENGTHS_NM[w] / 1e6
    fallen = beam.fallen_mm[:, w][:, known] - np.array([[beam.chief_mm[w]], [0.0]])
    slopes = np.concatenate([side * fallen[0], fallen[1]]) * aperture / wave_mm
    rows = np.concatenate([along_x, along_y]) * np.tile(weight, 2)[:, None]
    coefficients = least_squares(rows[:, 1:], slopes * np.tile(weight, 2))
    path = beam.path_mm[w, known] / wave_mm
    left = (path - values @ least_squares(values * weight[:, None], path * weight)) * weight
    return index[1:], coefficients, float(np.sqrt((left**2).sum() / (weight**2).sum()))


def _between(f_number: float, heights_um: F64, indices: tuple[int, ...], waves: F64) -> float:
    """Return the error, waves rms, of interpolating wavefronts from every second height."""
    coarse = FieldLens(
        f_number=f_number,
        wavelength_nm=WAVELENGTHS_NM,
        zernike=indices,
        waves=np.clip(waves[:, ::2], -MOST_WAVES, MOST_WAVES),
        height_um=heights_um[::2],
    )
    worst = 0.0
    for k in range(1, len(heights_um), 2):
        placed = coarse.at(float(heights_um[k]), 0.0)
        there = dict(zip(placed.zernike, np.array(placed.path_nm).T, strict=True))
        off = np.array([there[index] for index in indices]).T / np.array(WAVELENGTHS_NM)[:, None] - waves[:, k]
        worst = max(worst, float(np.sqrt((off[:, 1:] ** 2).sum(axis=1)).max()))  # without the tilt, which is a place
    return worst


def _needed(waves: F64) -> list[int]:
    """Return the coefficients that matter anywhere: the others together are negligible."""
    largest = np.abs(waves).max(axis=(0, 1))
    small = np.argsort(largest)
    left = np.sqrt(np.cumsum(waves[..., small] ** 2, axis=-1)).max(axis=(0, 1))
    return sorted(small[left > DROPPED].tolist())


def _light(lens: Lens, angles: F64, height_mm: F64, name: str) -> F64:
    """Return the irradiance of an even sky at heights on the flat sensor, over that on the axis.

    The light of a ring of the sky, cos θ·dΩ for each open part of the pupil, falls into a ring of the sensor. The
    radius of that ring is the centroid of the light, which coma shifts from the chief ray.
    """
    full = float(angles[-1])
    near = [
        (max(angle - EXPOSED_STEP * full, 0.0), angle, min(angle + EXPOSED_STEP * full, full))
        for angle in angles.tolist()
    ]
    beams = lens.beams([angle for each in near for angle in each], HALF_DISC)
    light, places_mm = np.empty_like(angles), np.empty_like(angles)
    for k, (inner, angle, outer) in enumerate(near):
        three = beams[3 * k : 3 * k + 3]
        passes = np.all([beam.passes[0] for beam in three], axis=0)
        area = np.where(passes, lens.entry_area(angle, three[1].entry_mm)[0], 0.0)
        if not area.any():
            raise InputError(
                f"no light of {name!r} passes {math.degrees(angle):.4g}° from the axis; give a smaller field (--field)"
            )
        from_mm, places_mm[k], to_mm = (
            abs(np.average(beam.fallen_mm[0, 0, passes], weights=area[passes]).item()) for beam in three
        )
        sky = math.sin(outer) ** 2 - math.sin(inner) ** 2
        light[k] = area.sum() * sky / (to_mm**2 - from_mm**2)
    mirrored = np.concatenate([-places_mm[:0:-1], places_mm]), np.concatenate([light[:0:-1], light])
    displayed: F64 = CubicSpline(*mirrored)(height_mm)
    relative: F64 = displayed / displayed[0]
    if relative.max() > 1.0 + BRIGHTER:
        brightest = int(relative.argmax())
        raise InputError(
            f"{name!r} gives {relative[brightest]:.4g} of the axis's light {math.degrees(angles[brightest]):.4g}° from "
            "it, and relative_illumination is at most 1; give it a smaller field (--field)"
        )
    return relative


def _distortion(lens: Lens, full_rad: float, side: float) -> tuple[F64, F64]:
    """Return heights without distortion, µm, and its fractions there; excluding scale: none near the axis.

    Off the paraxial focus the image is larger or smaller: a change of scale, not distortion.
    """
    for steps in DRAWN_STEPS:
        angles = np.concatenate([[0.0, NEAR_AXIS], full_rad * np.arange(1, 2 * steps + 1) / (2 * steps)])
        fallen = side * np.array([beam.chief_mm[0] for beam in lens.beams(angles, np.empty((2, 0)))])
        ideal = fallen[1] / math.tan(NEAR_AXIS) * np.tan(angles)
        drawn = np.concatenate([[0.0], fallen[2:] / ideal[2:] - 1.0])
        heights = np.concatenate([[0.0], ideal[2:]])
        coarse = FieldLens(
            f_number=8.0,
            wavelength_nm=(550.0,),
            zernike=(4,),
            waves=np.zeros((1, 2, 1)),
            height_um=(0.0, 1e3 * float(heights[-1])),
            distortion=drawn[::2],
            distortion_height_um=1e3 * heights[::2],
        )
        between = coarse.distorted(np.stack([1e3 * heights[1::2], 0.0 * heights[1::2]], axis=1))[:, 0]
        if np.abs(between / (1e3 * heights[1::2]) - 1.0 - drawn[1::2]).max() <= DRAWN:
            break
    return 1e3 * heights[::2], drawn[::2]
