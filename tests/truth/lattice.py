"""Exact images by Fourier sums: a road that shares nothing with camsim's. Imports nothing of camsim.

The polygon's transform is a closed form, every OTF a factor; a shift of the polygon is a phase, and the aliases of the
photosite lattice are added up before one inverse FFT. A periodic sum would wrap the Airy pattern's tail round, so the
pattern is tapered smoothly from 1 to 0 between two radii, the inner one past the largest distance from a photosite to
the polygon: within it nothing changes. The taper blurs the lens's OTF over about BAND/TAPER in frequency, which matters
only where the OTF is not smooth: at 0 and at each cut-off. Elsewhere the closed form stands. ``photosite_value`` checks
samples of all this by a road without any transform.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from scipy import fft, interpolate, special

from tests.truth.boundary import BoundaryTruth
from tests.truth.picture import Piece
from tests.truth.round_lenses import Airy, Gauss

F64: TypeAlias = npt.NDArray[np.float64]
C128: TypeAlias = npt.NDArray[np.complex128]

TAPER, BAND = 90.0, 18.0  # pitches; 1/taper beyond the cut-off that is kept: leaves 1e-13
KNOTS = 10.0  # of the spline, per cycle of the farthest ring: leaves 1e-13 (six: 1e-11)
GAUSSIAN_CUT = 1.25  # cycles per σ where exp(−2π²σ²f²) is below 1e-13
GAUSSIAN_REACH = 9.0
CHUNK = 2_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lens:
    """A round lens: Airy patterns of several wavelengths, or one Gaussian.

    blur     : (j,) λN of each, or σ, pitches
    weights  : (j,) that add up to 1
    gaussian : which of the two
    """

    blur: F64
    weights: F64
    gaussian: bool = False


def photosite_value(polygon: F64, x: float, y: float, lens: Lens, *, side: float = 0.0, split: float = 0.0) -> float:
    """Return the share of a photosite's light that comes from within a polygon, by integrals along its sides.

    polygon : (n, 2) x, y, pitches, either direction round;  side: of the square photosite;  split: of the four spots
    """
    following = np.roll(polygon, -1, axis=0)
    area = np.sum(polygon[:, 0] * following[:, 1] - following[:, 0] * polygon[:, 1])
    pieces = [Piece(tuple(a), tuple(b), 0, -1) for a, b in zip(polygon, following, strict=True) if np.any(a != b)]
    jumps = np.tile(math.copysign(1.0, float(area)) * lens.weights, (len(pieces), 1))
    lenses = [(Gauss if lens.gaussian else Airy)(float(blur)) for blur in lens.blur]
    photosite = {"kind": "square", "side": side} if side else {"kind": "point"}
    olpf = {"split": split, "split_y": split, "rotate_deg": 0.0} if split else None
    values, _ = BoundaryTruth(pieces, lenses, jumps, photosite, olpf, target=1e-12).values([[x, y]])
    return float(values[0])


def window_truths(
    polygon: F64,
    lens: Lens,
    footprints: list[tuple[float, float]],
    *,
    origin: tuple[float, float],
    shape: tuple[int, int],
    shifts: F64,
) -> F64:
    """Return the share of the light from within a polygon: (footprints, shifts, rows, cols).

    polygon    : (n, 2) x, y in pitches, positive shoelace area
    footprints : (side of the square photosite, split of the four-spot OLPF) of each
    origin     : centre (x, y) of the window's first photosite;  shifts: (k, 2) of the polygon
    """
    x0, y0 = origin
    x1, y1 = x0 + shape[1] - 1, y0 + shape[0] - 1
    margin = float(np.abs(shifts).max(initial=0.0)) + max(0.75 * (side + split) for side, split in footprints) + 1.0
    places = np.array([[x, y] for x in (x0, x1) for y in (y0, y1)])
    apart = np.abs(places[:, None, :] - polygon[None])
    reach = float(np.hypot(apart[..., 0], apart[..., 1]).max()) + margin
    if lens.gaussian:
        cut = GAUSSIAN_CUT / float(lens.blur.min())
        outer = GAUSSIAN_REACH * float(lens.blur.max())
    else:
        cut = 1.0 / float(lens.blur.min()) + BAND / TAPER
        outer = reach + TAPER
    period = fft.next_fast_len(math.ceil(outer + float(apart.max()) + margin), real=True)
    otf = _gaussian_otf(lens) if lens.gaussian else _tapered_otf(lens, reach, outer, cut, BAND / TAPER)

    base_y, base_x = fft.fftfreq(period), fft.rfftfreq(period)
    aliases = [(ay, ax) for ay in _orders(cut) for ax in _orders(cut) if _nearest(ay, ax) <= cut]
    # A shift s of the polygon is a factor exp(−2πi k·s): of the alias a number, of the base frequency a phase.
    turns = np.exp(-2j * np.pi * (np.array(aliases, float)[:, ::-1] @ shifts.T)).T
    folded = np.zeros((len(footprints), len(shifts), base_y.size, base_x.size), complex)
    rows = max(1, CHUNK // (base_x.size * len(aliases)))
    for first in range(0, base_y.size, rows):
        some = slice(first, first + rows)
        part = np.zeros((len(footprints), len(aliases), base_y[some].size * base_x.size), complex)
        for a, (ay, ax) in enumerate(aliases):
            ky, kx = base_y[some] + ay, base_x + ax
            gy, gx = (k.ravel() for k in np.meshgrid(ky, kx, indexing="ij"))
            inside = gx * gx + gy * gy <= cut * cut
            gx, gy = gx[inside], gy[inside]
            light = _polygon_transform(polygon, gx, gy) * otf(np.hypot(gx, gy))
            light *= np.exp(2j * np.pi * (gx * x0 + gy * y0))
            for f, (side, split) in enumerate(footprints):
                print_ = (
                    np.sinc(side * gx) * np.sinc(side * gy) * np.cos(np.pi * split * gx) * np.cos(np.pi * split * gy)
                )
                part[f, a, inside] = light * print_
        folded[:, :, some] = (turns @ part).reshape(len(footprints), len(shifts), -1, base_x.size)
    result = np.empty((len(footprints), len(shifts), *shape))
    for k, (sx, sy) in enumerate(shifts):
        phase = np.exp(-2j * np.pi * sy * base_y)[:, None] * np.exp(-2j * np.pi * sx * base_x)[None]
        for f in range(len(footprints)):
            # The lattice has unit pitch, so the sum over k is an integral: no factor but the inverse transform's own.
            image = fft.irfft2(folded[f, k] * phase, s=(period, period))
            # A Gaussian's period may be shorter than the window: what repeats is empty.
            result[f, k] = image[np.ix_(np.arange(shape[0]) % period, np.arange(shape[1]) % period)]
    return result


def white_with_a_black_polygon(
    polygon: F64,
    rows: int,
    cols: int,
    lambda_n: float,
    *,
    side: float = 0.0,
    split: float = 0.0,
) -> F64:
    """Return an image (rows, cols) under an Airy pattern, pitch 1, the origin in the middle of the grid."""
    covered = window_truths(
        np.asarray(polygon, float),
        Lens(blur=np.array([lambda_n]), weights=np.ones(1)),
        [(side, split)],
        origin=(0.5 - 0.5 * cols, 0.5 - 0.5 * rows),
        shape=(rows, cols),
        shifts=np.zeros((1, 2)),
    )
    image: F64 = 1.0 - covered[0, 0]
    return image


def _orders(cut: float) -> range:
    return range(-math.ceil(cut + 0.5), math.ceil(cut + 0.5) + 1)


def _nearest(ay: int, ax: int) -> float:
    """Distance from zero to the nearest frequency of an alias; the base is −½ … ½ by 0 … ½."""
    x = max(0.0, ax, -ax - 0.5)
    return math.hypot(x, max(0.0, abs(ay) - 0.5))


def _polygon_transform(polygon: F64, kx: F64, ky: F64) -> C128:
    """∫ exp(−2πi k·y) dy over the polygon, edge by edge (Green's theorem); its area at k = 0."""
    square = kx * kx + ky * ky
    following = np.roll(polygon, -1, axis=0)
    area = 0.5 * float(np.sum(polygon[:, 0] * following[:, 1] - following[:, 0] * polygon[:, 1]))
    result = np.zeros(kx.shape, complex)
    for a, b in zip(polygon, following, strict=True):
        middle, edge = 0.5 * (a + b), b - a
        along = np.exp(-2j * np.pi * (kx * middle[0] + ky * middle[1])) * np.sinc(kx * edge[0] + ky * edge[1])
        result += (kx * edge[1] - ky * edge[0]) * along
    zero = square == 0.0
    transform: C128 = np.where(zero, area, 1j / (2.0 * np.pi * np.where(zero, 1.0, square)) * result)
    return transform


def _gaussian_otf(lens: Lens) -> Callable[[F64], F64]:
    sigma = float(lens.blur[0])
    return lambda k: np.exp(-2.0 * (np.pi * sigma * k) ** 2)


def _airy_otf(lens: Lens, k: F64) -> F64:
    """Σ weight · overlap of two circles."""
    total = np.zeros(k.shape)
    for blur, weight in zip(lens.blur, lens.weights, strict=True):
        u = np.minimum(blur * k, 1.0)
        total += weight * (2.0 / np.pi) * (np.arccos(u) - u * np.sqrt((1.0 - u) * (1.0 + u)))
    return total


def _tapered_otf(lens: Lens, inner: float, outer: float, cut: float, blurred: float) -> Callable[[F64], F64]:
    """Hankel transform of the pattern times a smooth step from 1 to 0 between two radii, as a spline."""
    k = np.linspace(0.0, cut, math.ceil(KNOTS * outer * cut))
    values = _airy_otf(lens, k)
    rough = np.concatenate([[0.0], 1.0 / lens.blur])
    gap = np.abs(k - np.sort(rough)[np.clip(np.searchsorted(np.sort(rough), k), 0, rough.size - 1)])
    before = np.abs(k - np.sort(rough)[np.clip(np.searchsorted(np.sort(rough), k) - 1, 0, rough.size - 1)])
    near = np.flatnonzero(np.minimum(gap, before) <= blurred)
    panels = math.ceil(outer * (2.0 / float(lens.blur.min()) + cut))
    x, w = np.polynomial.legendre.leggauss(12)
    width = outer / panels
    r = ((np.arange(panels)[:, None] + 0.5 * (1.0 + x)) * width).ravel()
    step = 0.5 * special.erfc(6.0 * (2.0 * (r - inner) / (outer - inner) - 1.0))
    psf = np.zeros(r.shape)
    for blur, weight in zip(lens.blur, lens.weights, strict=True):
        u = np.pi * r / blur
        psf += weight * np.pi / blur**2 * (special.j1(u) / u) ** 2
    ring = psf * step * 2.0 * np.pi * r * np.tile(0.5 * width * w, panels)
    for part in np.array_split(near, math.ceil(near.size * r.size / CHUNK)):
        values[part] = special.j0(2.0 * np.pi * np.outer(k[part], r)) @ ring
    return interpolate.make_interp_spline(k, values, k=7)
