"""Moiré of a zone plate: contrast of its aliased second centres, where the rings meet the sampling lattice.

At radius r a zone plate has the frequency k·r, k = rim frequency / rim radius. About the point where this is a
channel's sampling frequency f_s along an axis, sampled rings look like the centre of another plate:

    cos(π·k·|p|²)  at photosites of the lattice  =  cos(π·k·|p − p_s|² + φ),  p_s = f_s/k,

with the transfer function at f_s as its contrast. That is what an optical low-pass filter is for.

Only at the centre of the ghost is this the transfer function at f_s: at p it is T(k·p), which a low-pass filter varies
along and across. It is fitted as a polynomial. The added noise is offset by knowledge of φ from the lattice: for a
symmetric transfer function only the cosine contributes, plus, a quarter period aside, the change of the rings over
the blur, k·∇²T/4π, which also follows from the polynomial.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from camsim.camera.capture import Capture
from camsim.core.arrays import F64
from camsim.core.typed import Number, Positive, check
from camsim.errors import UnsupportedError
from camsim.measure.given import check_given
from camsim.measure.lens_places import refuse_distortion
from camsim.measure.picture import Picture, Plane
from camsim.measure.straight import straightened
from camsim.measure.target.plates import Rings, aligned, rings_of
from camsim.measure.target.star import FUNDAMENTAL, surface_contrast
from camsim.measure.theory import CameraOtf
from camsim.scene.charts import Chart

_NEAR = 0.2
"""Highest frequency of a ghost's rings within the fit, relative to the sampling frequency."""

_DEGREE, _HIGHER, _ASIDE, _HARD = 3, 4, 1, 2
"""Degrees of polynomials in frequency: the ghost's cosine, one to estimate its residual, its sine, third harmonics."""

_ALIKE = 3.0
"""Largest phase error of a ghost relative to its lattice, in standard errors."""

_LEAST_PHOTOSITES = 100
_ROUNDED = 1.0 + 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Ghost:
    """One second centre.

    fx_cycles_per_pixel, fy_cycles_per_pixel : the sampling frequency that causes it
    x_pixel, y_pixel : position relative to the centre of the plate
    contrast  : contrast of the ghost's rings, relative to that of the plate's rings in the scene
    contrast_error : standard error of that, from noise and from the residual of the polynomial
    theory    : absolute value of the transfer function at that frequency; NaN if unknown
    """

    channel: str
    fx_cycles_per_pixel: float
    fy_cycles_per_pixel: float
    x_pixel: float
    y_pixel: float
    contrast: float
    contrast_error: float
    theory: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MoireReport:
    """All ghosts of one picture.

    middle_pixel, rim_pixel : centre (x, y) and assumed radius of a plate that was detected in a picture
    """

    file: str
    ghosts: tuple[Ghost, ...]
    middle_pixel: tuple[float, float] | None = None
    rim_pixel: float | None = None

    def moire(self, channel: str) -> float:
        """Return the moiré figure of a channel: the root mean square of its ghosts' contrasts."""
        return float(np.sqrt(np.mean([g.contrast**2 for g in self.ghosts if g.channel == channel])))

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON."""
        channels = dict.fromkeys(ghost.channel for ghost in self.ghosts)
        return {
            "file": self.file,
            "moire": {channel: self.moire(channel) for channel in channels},
            "ghosts": [asdict(g) | {"theory": g.theory if math.isfinite(g.theory) else None} for g in self.ghosts],
            **({} if self.middle_pixel is None else {"middle_pixel": self.middle_pixel, "rim_pixel": self.rim_pixel}),
        }


def measure_moire(picture: Picture, capture: Capture) -> MoireReport:
    """Measure the ghosts of the zone plate of a capture's scene along both axes, in every channel.

    Raises UnsupportedError for a scene without a zone plate, or if its rings are coarser than all lattices.
    """
    check_given(picture=picture, capture=capture)
    picture = straightened(picture, capture)
    plates = [shape for shape in capture.scene.shapes if isinstance(shape, Chart) and shape.name == "zone-plate"]
    if not plates:
        raise UnsupportedError("the scene has no chart zone-plate", stage=picture.name)
    refuse_distortion(capture, picture.name, "a zone plate is")
    plate = plates[-1].parameters
    # A channel on several lattices has no single sampling frequency.
    lattices = [channel.planes[0] for channel in picture.select("all") if len(channel.planes) == 1]
    ghosts = tuple(ghost for plane in lattices for ghost in _ghosts(plane, capture, plate))
    if not ghosts:
        raise UnsupportedError(_why_none(lattices, capture, plate), stage=picture.name)
    return MoireReport(file=picture.name, ghosts=ghosts)


def measure_plate(picture: Picture, *, rim_pixel: Number | None = None) -> MoireReport:
    """Measure the ghosts of a zone plate that anybody photographed, in every channel; no theory is known.

    rim_pixel : radius of the plate in the picture; None: the whole picture

    The plate is searched near the picture's centre, possibly tilted. Contrast is relative to that of its coarse rings,
    at the centre. Raises UnsupportedError if no plate is found, or no ghost within it.
    """
    check_given(picture=picture)
    rim = check(rim_pixel, Positive | None, "rim_pixel")
    lattices = [channel.planes[0] for channel in picture.select("all") if len(channel.planes) == 1]
    lattices = [plane for plane in lattices if plane.step == lattices[0].step]
    if not lattices or lattices[0].step[0] != lattices[0].step[1]:
        message = "no channel lies on one even lattice of one black level, which alone has one sampling frequency"
        raise UnsupportedError(message, stage=picture.name)
    rings = rings_of(lattices, picture.name)
    step = lattices[0].step[0]
    ghosts, reach = [], 0.0
    for plane, each in zip(lattices, rings, strict=True):
        for ghost, far in _of_rings(plane, each, math.inf if rim is None else rim / step):
            ghosts.append(ghost)
            reach = max(reach, far * step)
    if not ghosts:
        farthest = step / math.sqrt(float(np.linalg.det(rings[0].growth)))
        message = f"the rings are as fine as the lattice of {lattices[0].name} {farthest:.4g} px from their middle"
        way_out = "where the plate, with a fifth of that about it, does not lie in the picture; show more of it"
        raise UnsupportedError(f"{message}, {way_out}", stage=picture.name)
    row, col = lattices[0].first + step * rings[0].centre + 0.5
    return MoireReport(
        file=picture.name, ghosts=tuple(ghosts), middle_pixel=(float(col), float(row)),
        rim_pixel=reach if rim is None else rim,
    )  # fmt: skip


def _of_rings(plane: Plane, rings: Rings, rim: float) -> Iterator[tuple[Ghost, float]]:
    """Yield the ghosts of rings, and the radius of each, samples."""
    light = plane.samples.astype(np.float64) - plane.black
    size = np.array(light.shape) - 1.0
    growth = rings.growth
    for axis, sign in ((1, 1.0), (1, -1.0), (0, 1.0), (0, -1.0)):
        sampling = np.where(np.arange(2) == axis, sign, 0.0)
        off = np.linalg.solve(growth, sampling)
        radius = _NEAR * float(np.hypot(*off))
        at = rings.centre + off
        if (at < radius).any() or (at > size - radius).any() or float(np.hypot(*off)) + radius > rim:
            continue
        phase = rings.phase - 2.0 * math.pi * float(sampling @ rings.centre) - math.pi * float(off @ sampling)
        ghost = aligned(light, Rings(centre=at, growth=growth, phase=phase), _NEAR)
        places, offset, frequency = ghost.about(light.shape, _NEAR)
        if len(places) < _LEAST_PHOTOSITES:
            continue
        seen = light[places[:, 0], places[:, 1]]
        even = np.stack([np.ones(len(seen)), *offset.T], axis=1)
        uneven = np.linalg.lstsq(even, seen, rcond=None)[0]
        across = sampling[::-1] * (-1.0, 1.0)
        photosites = _Near(
            along=frequency @ sampling / _NEAR,
            across=frequency @ across / _NEAR,
            turn=ghost.turn(offset),
            signal=seen - offset @ uneven[1:],
            aside=math.sqrt(float(np.linalg.det(growth))) / (2.0 * math.pi * _NEAR**2),
        )
        found, error = photosites.contrast(ghost.phase)
        contrast = found / rings.contrast
        yield (
            Ghost(
                channel=plane.name,
                fx_cycles_per_pixel=float(sampling[1]) / plane.step[1],
                fy_cycles_per_pixel=float(sampling[0]) / plane.step[0],
                x_pixel=float(ghost.centre[1] - rings.centre[1]) * plane.step[1],
                y_pixel=float(ghost.centre[0] - rings.centre[0]) * plane.step[0],
                contrast=contrast,
                contrast_error=math.hypot(error / rings.contrast, contrast * rings.error / rings.contrast),
                theory=math.nan,
            ),
            float(np.hypot(*off)) + radius,
        )


def _rim(capture: Capture, plate: Mapping[str, Any]) -> tuple[float, float]:
    """Return the rim's radius, pixels, and the frequency there, line pairs per pixel."""
    pitch_um = capture.camera.pitch_um
    period_um = plate["rim_period_um"]
    rim_per_um = plate["rim_lp_per_mm"] / 1e3 if period_um is None else 1.0 / period_um
    return plate["radius_um"] / pitch_um, rim_per_um * pitch_um


def _why_none(lattices: list[Plane], capture: Capture, plate: Mapping[str, Any]) -> str:
    """A ghost lies at R/q, with q line pairs per sample of its lattice at the rim R, and is fitted within 0.2·R/q."""
    if not lattices:
        return "no channel lies on one even lattice of one black level, which alone has one sampling frequency"
    radius, rim_per_pixel = _rim(capture, plate)
    step, name = max(lattices[0].step), lattices[0].name
    least_place = step * math.sqrt(_LEAST_PHOTOSITES / math.pi) / _NEAR
    least, most = 1.0 + _NEAR, radius / least_place
    has = f"the plate has {rim_per_pixel * step:.3g} line pairs per sample of {name} at a rim of {radius:.4g} px"
    if most < least:
        return f"{has}: too small for any ghost to be fitted; make it {math.ceil(least * least_place)} px or more"
    return f"{has}; ghosts can be fitted from {least:.3g} to {most:.3g}, where the picture shows all of the plate"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Near:
    """The photosites around a ghost.

    along, across : frequency relative to the sampling one, along and across it, in units of the fitted range
    turn          : the phase of the rings from the centre of the ghost;  signal: above black
    aside         : factor from the sum of both second coefficients to k·∇²T/4π
    """

    along: F64
    across: F64
    turn: F64
    signal: F64
    aside: float

    def rings(self, phase: float, degree: int) -> tuple[F64, F64, float]:
        """Return cosine and sine of the ghost, their covariance, and the mean, for rings with an initial phase."""
        wave = self.turn + phase
        cosine, sine = self._polynomial(degree), self._polynomial(_ASIDE)
        columns = [np.ones((1, wave.size)), cosine * np.cos(wave), sine * np.sin(wave)]
        # The third harmonic of hard rings has a ghost too, in phase as well.
        columns += [self._polynomial(_HARD) * np.cos(3.0 * wave), np.sin(3.0 * wave)[None]]
        basis = np.concatenate(columns).T
        inverse = np.linalg.inv(np.einsum("ni,nj->ij", basis, basis))
        fitted = np.einsum("ij,nj,n->i", inverse, basis, self.signal)
        rest = self.signal - np.einsum("ni,i->n", basis, fitted)
        variance = float(np.einsum("n,n->", rest, rest)) / (rest.size - fitted.size)
        pick = np.zeros((2, fitted.size))
        pick[0, 1] = pick[1, 1 + len(cosine)] = 1.0
        # The squares are the fourth and sixth columns.
        pick[1, [4, 6]] = -self.aside
        covariance = variance * np.einsum("ai,ij,bj->ab", pick, inverse, pick)
        return np.einsum("ai,i->a", pick, fitted), covariance, float(fitted[0])

    def _polynomial(self, degree: int) -> F64:
        """Return the powers of along and across up to a degree, by increasing degree."""
        powers = [self.along ** (n - j) * self.across**j for n in range(degree + 1) for j in range(n + 1)]
        return np.stack(powers)

    def contrast(self, phase: float) -> tuple[float, float]:
        """Return the ghost's contrast with its standard error.

        phase : phase of the rings at the centre, by the lattice; an asymmetric PSF may change it
        """
        ghost, covariance, _ = self.rings(phase, _DEGREE)
        if abs(ghost[1]) > _ALIKE * math.sqrt(covariance[1, 1]):
            phase += math.atan2(-ghost[1], ghost[0])
        ghost, covariance, mean = self.rings(phase, _DEGREE)
        finer, more, _ = self.rings(phase, _HIGHER)
        # For nested fits, the variance of the difference is the difference of the variances.
        left = max(float(finer[0] - ghost[0]) ** 2 - max(float(more[0, 0] - covariance[0, 0]), 0.0), 0.0)
        return math.hypot(*ghost) / mean, math.sqrt(float(covariance[0, 0]) + left) / mean


def _ghosts(plane: Plane, capture: Capture, plate: Mapping[str, Any]) -> Iterator[Ghost]:
    pitch_um = capture.camera.pitch_um
    contrast = surface_contrast(plane, capture, plate["dark"], plate["light"])
    if contrast is None:
        return
    rim, rim_per_pixel = _rim(capture, plate)
    k = rim_per_pixel / rim
    left, top = capture.grid.first_centre
    x0, y0 = (centre_um / pitch_um for centre_um in plate["centre_um"])
    rows, cols = (
        first + step * np.arange(n) for first, step, n in zip(plane.first, plane.step, plane.samples.shape, strict=True)
    )
    x, y = np.meshgrid(left + cols - x0, top + rows - y0)
    theory = CameraOtf.of(capture)
    for fx, fy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        ghost = fx / plane.step[1], fy / plane.step[0]
        at, frequency = (ghost[0] / k, ghost[1] / k), math.hypot(*ghost)
        reach = _NEAR * frequency / k
        distance = np.hypot(x - at[0], y - at[1])
        near = distance < reach
        whole = x.min() <= at[0] - reach and x.max() >= at[0] + reach
        whole = whole and y.min() <= at[1] - reach and y.max() >= at[1] + reach
        if math.hypot(*at) + reach > rim * _ROUNDED or not whole or np.count_nonzero(near) < _LEAST_PHOTOSITES:
            continue
        along = (x[near] * at[0] + y[near] * at[1]) * k / frequency - frequency / k
        across = (y[near] * at[0] - x[near] * at[1]) * k / frequency
        photosites = _Near(
            along=along / reach,
            across=across / reach,
            turn=np.pi * k * distance[near] ** 2,
            signal=plane.samples[near].astype(np.float64) - plane.black,
            aside=k / (2.0 * math.pi * (_NEAR * frequency) ** 2),
        )
        begins = 2.0 * math.pi * (ghost[0] * x[0, 0] + ghost[1] * y[0, 0]) - math.pi * k * (at[0] ** 2 + at[1] ** 2)
        found, error = photosites.contrast(begins)
        place_um = (x0 + at[0]) * pitch_um, (y0 + at[1]) * pitch_um
        frequencies = np.array([ghost[0]]), np.array([ghost[1]])
        otf = theory.at(*frequencies, plane.name, plate["dark"], plate["light"], place_um=place_um)
        one = abs(contrast) * FUNDAMENTAL
        yield Ghost(
            channel=plane.name,
            fx_cycles_per_pixel=ghost[0],
            fy_cycles_per_pixel=ghost[1],
            x_pixel=at[0],
            y_pixel=at[1],
            contrast=found / one,
            contrast_error=error / one,
            theory=math.nan if otf is None else float(np.abs(otf[0])),
        )
