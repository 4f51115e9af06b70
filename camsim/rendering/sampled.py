"""The paper's methods, kept by name: what people used before, and what the boundary engine is measured against.

F. van den Bergh, "On the rendering of synthetic images with specific point spread functions". All of them place a
fixed set of samples of the lens's pattern around every photosite and weigh the footprint's share of each region there;
``strips`` integrates a Gaussian pattern instead, in closed form along x and adaptively along y.

area           the footprint alone, clipped exactly: no lens at all
uniform-pixel  11 × 11 samples on whole pixels, weighted by the pattern
uniform        11 × 11 samples that reach as far as the pattern does (3 σ, or the third dark ring)
importance     N samples (default 2025) of the Halton sequence (2, 3), distributed as the pattern (Airy cut at 18 λN)
strips         Gaussian pattern of any covariance, point photosite

One difference from the paper is deliberate: a photosite's rectangle and the OLPF's spots are clipped exactly at every
sample, for all methods.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numba as nb
import numpy as np
from scipy import special

from camsim.arrays import F64
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.optics import Airy, EllipticalGaussian, Gaussian, OpticalSystem
from camsim.rendering.footprint import Footprint
from camsim.rendering.kernels import ONE_AT_A_TIME
from camsim.rendering.patterns import pattern_of

GRID = 11
IMPORTANCE_SAMPLES = 2025
AIRY_CUT = 18.0  # λN, as in the paper
THIRD_DARK_RING = 3.2383  # λN


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rule:
    """A method made ready for one lens and footprint; lengths in pitches.

    places, shares : (m, 2) centres of the footprint's rectangles about a photosite, and (m,) what each counts
    width, height  : of the rectangles
    whiten         : (2, 2) makes the Gaussian that ``strips`` integrates instead round, σ = 1; None for all others
    random         : whether the samples may be taken for random draws of the pattern
    """

    places: F64
    shares: F64
    width: float = 0.0
    height: float = 0.0
    whiten: F64 | None = None
    random: bool = False

    @property
    def samples(self) -> int:
        """How many samples a photosite takes."""
        return len(self.shares)

    def image(
        self,
        start: F64,
        end: F64,
        contrast: F64,
        background: float,
        *,
        origin: tuple[float, float],
        shape: tuple[int, int],
    ) -> F64:
        """Render at one wavelength.

        start, end : (n, 2) edges;  contrast: (n,) left minus right;  origin: of the first photosite
        """
        (x0, y0), (rows, cols) = origin, shape
        with ONE_AT_A_TIME:
            if self.whiten is not None:
                ends = start @ self.whiten.T, end @ self.whiten.T
                return _strips(x0, y0, rows, cols, *ends, contrast, background, self.whiten)
            return _weighted(
                x0,
                y0,
                rows,
                cols,
                start,
                end,
                contrast,
                background,
                self.width,
                self.height,
                self.places,
                self.shares,
            )

    def standard_error(self, start: F64, end: F64, contrast: F64, points: F64) -> float | None:
        """Return the largest standard error of the samples' mean at ``points`` (m, 2); None where nothing is random."""
        if not self.random or self.samples < 2:
            return None
        worst = 0.0
        for x, y in points:
            values = _each_sample(x, y, start, end, contrast, self.width, self.height, self.places)
            worst = max(worst, float(values.std(ddof=1)) / math.sqrt(self.samples))
        return worst


def rule_of(method: str, system: OpticalSystem, *, blur: float, footprint: Footprint, samples: int | None) -> Rule:
    """Make a method ready.

    blur    : the pattern's own length, pitches
    samples : number of samples of ``importance``; None for its default
    """
    lens, spots = system.lens, footprint.spots
    if samples is not None and method != "importance":
        raise UnsupportedError(f"samples: {method} has a fixed set of samples; only importance takes a number")
    if method == "strips":
        if not isinstance(lens, Gaussian | EllipticalGaussian) or footprint.side > 0.0 or len(spots) > 1:
            raise UnsupportedError(
                "strips needs a Gaussian lens and a point photosite (side_um 0, no OLPF); "
                f"this is {type(lens).__name__} on {footprint.side:g} pitches: use boundary"
            )
        return Rule(places=np.zeros((1, 2)), shares=np.ones(1), whiten=_whitening(lens, blur))
    if not isinstance(lens, Airy | Gaussian):
        raise UnsupportedError(f"{method} knows Airy and Gaussian lenses; this is {type(lens).__name__}: use boundary")
    offsets, weights = SAMPLES[method](lens, blur, samples)
    return Rule(
        places=(offsets[:, None, :] + spots[None]).reshape(-1, 2),
        shares=np.repeat(weights, len(spots)) / len(spots),
        width=footprint.width,
        height=footprint.height,
        random=method == "importance",
    )


def _whitening(lens: Gaussian | EllipticalGaussian, blur: float) -> F64:
    """Return the map from pitches to a plane in which the pattern is round, σ = 1: the covariance to the power −½."""
    if isinstance(lens, Gaussian):
        return np.eye(2) / blur
    size, axes = np.linalg.eigh(np.array(lens.covariance_um2) * (blur / lens.blur_um(0.0)) ** 2)
    matrix: F64 = (axes / np.sqrt(size)) @ axes.T
    return matrix


def _area(lens: Airy | Gaussian, blur: float, samples: int | None) -> tuple[F64, F64]:
    return np.zeros((1, 2)), np.ones(1)


def _uniform(lens: Airy | Gaussian, blur: float, samples: int | None) -> tuple[F64, F64]:
    reach = blur * (3.0 if isinstance(lens, Gaussian) else THIRD_DARK_RING)
    return _weigh_grid(lens, blur, np.linspace(-reach, reach, GRID, dtype=np.float64))


def _uniform_pixel(lens: Airy | Gaussian, blur: float, samples: int | None) -> tuple[F64, F64]:
    return _weigh_grid(lens, blur, np.arange(GRID, dtype=np.float64) - (GRID - 1) / 2.0)


def _weigh_grid(lens: Airy | Gaussian, blur: float, along: F64) -> tuple[F64, F64]:
    offsets = np.stack(np.meshgrid(along, along, indexing="xy"), axis=-1).reshape(-1, 2)
    rho = np.hypot(offsets[:, 0], offsets[:, 1]) / blur
    if isinstance(lens, Gaussian):
        weights = np.exp(-0.5 * rho * rho)
    else:
        x = np.pi * np.where(rho == 0.0, 1.0, rho)
        weights = np.where(rho == 0.0, 1.0, (2.0 * special.j1(x) / x) ** 2)
    shares: F64 = weights / weights.sum()
    return offsets, shares


def _importance(lens: Airy | Gaussian, blur: float, samples: int | None, cut: float = AIRY_CUT) -> tuple[F64, F64]:
    count = IMPORTANCE_SAMPLES if samples is None else samples
    if count < 1:
        raise InvalidValueError(f"samples: {count} samples show nothing; give 1 or more")
    from scipy.stats import qmc  # half a second and 30 MB

    u = qmc.Halton(2, scramble=False).random(count + 1)[1:]  # its first point is the origin, which has no inverse
    if isinstance(lens, Gaussian):
        offsets = blur * special.ndtri(u)
    else:
        rho = np.linspace(0.0, cut, 1 << 16)
        energy = pattern_of(lens).energy(rho)
        radius = blur * np.interp(u[:, 0] * energy[-1], energy, rho)
        offsets = radius[:, None] * np.stack([np.cos(2 * np.pi * u[:, 1]), np.sin(2 * np.pi * u[:, 1])], axis=1)
    return offsets, np.full(count, 1.0 / count)


SAMPLES: dict[str, Callable[[Any, float, int | None], tuple[F64, F64]]] = {
    "area": _area,
    "uniform-pixel": _uniform_pixel,
    "uniform": _uniform,
    "importance": _importance,
}
METHODS = (*SAMPLES, "strips")


@nb.njit(cache=True, inline="always")
def _ramp(q: float, side: float) -> float:
    """Integral of min(max(q, 0), side)."""
    if q <= 0.0:
        return 0.0
    return 0.5 * q * q if q < side else side * (q - 0.5 * side)


@nb.njit(cache=True)
def _covered(left: float, top: float, width: float, height: float, start: F64, end: F64, contrast: F64) -> float:
    """Return the scene's mean over a rectangle, clipped against every edge exactly; at a point for no width or height.

    An edge that runs upwards in y adds its contrast to everything on its lower-x side within its span of y (a region is
    the sum of such bands over its outline), so its share of a rectangle is ∫ min(max(x_edge(y) − left, 0), width) dy.
    """
    inside = 0.0
    for e in range(len(contrast)):
        ya, yb = start[e, 1], end[e, 1]
        low, high = min(ya, yb), max(ya, yb)
        sign = contrast[e] if yb > ya else -contrast[e]
        if high <= top or low > top + height or low == high:
            continue
        slope = (end[e, 0] - start[e, 0]) / (yb - ya)
        if width == 0.0 or height == 0.0:
            if low <= top < high and start[e, 0] + slope * (top - ya) > left:
                inside += sign
            continue
        from_y, to_y = max(low, top), min(high, top + height)
        q1 = start[e, 0] + slope * (from_y - ya) - left
        q2 = start[e, 0] + slope * (to_y - ya) - left
        if abs(q2 - q1) < 1e-7 * width:
            area = (to_y - from_y) * min(max(0.5 * (q1 + q2), 0.0), width)
        else:
            area = (to_y - from_y) * (_ramp(q2, width) - _ramp(q1, width)) / (q2 - q1)
        inside += sign * area / (width * height)
    return inside


@nb.njit(cache=True, parallel=True)
def _weighted(
    x0: float,
    y0: float,
    rows: int,
    cols: int,
    start: F64,
    end: F64,
    contrast: F64,
    background: float,
    width: float,
    height: float,
    places: F64,
    shares: F64,
) -> F64:
    """Sum the samples of every photosite."""
    image = np.empty((rows, cols))
    for r in nb.prange(rows):
        for c in range(cols):
            total = 0.0
            for k in range(len(shares)):
                left = x0 + c + places[k, 0] - 0.5 * width
                top = y0 + r + places[k, 1] - 0.5 * height
                total += shares[k] * _covered(left, top, width, height, start, end, contrast)
            image[r, c] = background + total
    return image


@nb.njit(cache=True)
def _each_sample(
    x: float, y: float, start: F64, end: F64, contrast: F64, width: float, height: float, places: F64
) -> F64:
    """Return what every sample of the photosite at (x, y) sees, less the background."""
    values = np.empty(len(places))
    for k in range(len(places)):
        left, top = x + places[k, 0] - 0.5 * width, y + places[k, 1] - 0.5 * height
        values[k] = _covered(left, top, width, height, start, end, contrast)
    return values


@nb.njit(cache=True, inline="always")
def _strip(y: float, x_edge: float) -> float:
    """Density of a Gaussian with σ = 1 at height y, integrated over everything on the lower-x side of x_edge."""
    return math.exp(-0.5 * y * y) / math.sqrt(2.0 * math.pi) * 0.5 * math.erfc(-x_edge / math.sqrt(2.0))


@nb.njit(cache=True, parallel=True)
def _strips(
    x0: float, y0: float, rows: int, cols: int, start: F64, end: F64, contrast: F64, background: float, whiten: F64
) -> F64:
    """Integrate a Gaussian pattern over the bands of every edge: erf along x, adaptive Simpson along y.

    start, end : in the plane that ``whiten`` leads to, where σ = 1 in every direction; the photosites are taken there
    """
    image = np.empty((rows, cols))
    depth = 24
    allowed = 1e-10
    for r in nb.prange(rows):
        a_stack, b_stack = np.empty(depth + 2), np.empty(depth + 2)
        for c in range(cols):
            total = background
            x = whiten[0, 0] * (x0 + c) + whiten[0, 1] * (y0 + r)
            y = whiten[1, 0] * (x0 + c) + whiten[1, 1] * (y0 + r)
            for e in range(len(contrast)):
                xa, ya = start[e, 0] - x, start[e, 1] - y
                xb, yb = end[e, 0] - x, end[e, 1] - y
                if ya == yb:
                    continue
                slope = (xb - xa) / (yb - ya)
                low, high = max(min(ya, yb), -9.0), min(max(ya, yb), 9.0)
                if low >= high:
                    continue
                # Start from pieces of one σ, so that no narrow bell is missed; then halve where Simpson disagrees.
                pieces = math.ceil(high - low)
                band = 0.0
                for p in range(pieces):
                    a_stack[0] = low + (high - low) * p / pieces
                    b_stack[0] = low + (high - low) * (p + 1) / pieces
                    top = 1
                    while top > 0:
                        top -= 1
                        a, b = a_stack[top], b_stack[top]
                        m = 0.5 * (a + b)
                        fa, fb = _strip(a, xa + slope * (a - ya)), _strip(b, xa + slope * (b - ya))
                        fm = _strip(m, xa + slope * (m - ya))
                        f1 = _strip(0.5 * (a + m), xa + slope * (0.5 * (a + m) - ya))
                        f2 = _strip(0.5 * (m + b), xa + slope * (0.5 * (m + b) - ya))
                        coarse = (b - a) / 6.0 * (fa + 4.0 * fm + fb)
                        fine = (b - a) / 12.0 * (fa + 4.0 * f1 + 2.0 * fm + 4.0 * f2 + fb)
                        if abs(fine - coarse) <= 15.0 * allowed or top >= depth:
                            band += fine + (fine - coarse) / 15.0
                        else:
                            a_stack[top], b_stack[top] = a, m
                            a_stack[top + 1], b_stack[top + 1] = m, b
                            top += 2
                total += contrast[e] * band if yb > ya else -contrast[e] * band
            image[r, c] = total
    return image
