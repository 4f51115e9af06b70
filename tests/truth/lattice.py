"""An exact image by Fourier transforms: a road that shares nothing with camsim's. Imports nothing of camsim.

The transform of the polygon is a closed form, every OTF a factor, and the aliases of the photosite lattice are added
up before one inverse FFT. A periodic transform would wrap the Airy pattern's tail round, so the pattern is tapered
smoothly from 1 to 0 between two radii, the inner one past the largest distance that matters: within it nothing changes.
"""

from __future__ import annotations

import math

import numpy as np
from scipy import fft, interpolate, special

from tests.truth.rays import airy_psf


def white_with_a_black_polygon(polygon, rows, cols, lambda_n, *, side=0.0, split=0.0, taper=90.0, band=18.0):
    """Image (rows, cols) of a black polygon on white, pitch 1, the origin in the middle of the grid.

    polygon  : (n, 2) x, y, positive shoelace area;  side: of the square photosite;  split: of a four-spot OLPF
    taper    : width of the taper;  band: how far past the cut-off frequencies are kept, in 1/taper
    """
    polygon = np.asarray(polygon, float)
    first_x, first_y = 0.5 - 0.5 * cols, 0.5 - 0.5 * rows
    corners = np.array([[x, y] for x in (first_x, -first_x) for y in (first_y, -first_y)])
    reach = max(np.hypot(*(c - p)) for c in corners for p in polygon) + side + split + 2.0
    outer = reach + taper
    spread = np.abs(polygon).max() + max(-first_x, -first_y) + side + split
    period = fft.next_fast_len(math.ceil(outer + spread))

    cut = 1.0 / lambda_n + band / taper
    lens = _tapered_otf(lambda_n, reach, outer, cut)
    orders = range(-math.ceil(cut), math.ceil(cut) + 1)
    base = fft.fftfreq(period)
    total = np.zeros((period, period), complex)
    for alias_y in orders:
        for alias_x in orders:
            kx, ky = np.meshgrid(base + alias_x, base + alias_y)
            keep = kx * kx + ky * ky <= cut * cut
            kx, ky = kx[keep], ky[keep]
            if not kx.size:
                continue
            otf = lens(np.hypot(kx, ky)) * np.sinc(side * kx) * np.sinc(side * ky)
            otf *= np.cos(np.pi * split * kx) * np.cos(np.pi * split * ky)
            shift = np.exp(2j * np.pi * (kx * first_x + ky * first_y))
            total[keep] += _polygon_transform(polygon, kx, ky) * otf * shift
    covered = fft.ifft2(total).real
    return 1.0 - covered[:rows, :cols]


def _polygon_transform(polygon, kx, ky):
    """∫ exp(−2πi k·y) dy over the polygon, edge by edge (Green's theorem); its area at k = 0."""
    square = kx * kx + ky * ky
    following = np.roll(polygon, -1, axis=0)
    area = 0.5 * np.sum(polygon[:, 0] * following[:, 1] - following[:, 0] * polygon[:, 1])
    result = np.zeros(kx.shape, complex)
    for a, b in zip(polygon, following, strict=True):
        middle, edge = 0.5 * (a + b), b - a
        along = np.exp(-2j * np.pi * (kx * middle[0] + ky * middle[1])) * np.sinc(kx * edge[0] + ky * edge[1])
        result += (kx * edge[1] - ky * edge[0]) * along  # k · n ds, n outwards
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(square == 0.0, area, 1j / (2.0 * np.pi * square) * result)


def _tapered_otf(lambda_n, inner, outer, cut):
    """Hankel transform of the Airy pattern times a smooth step from 1 to 0 between two radii, as a spline."""
    panels = math.ceil(outer * (2.0 / lambda_n + cut))
    x, w = np.polynomial.legendre.leggauss(12)
    width = outer / panels
    r = (np.arange(panels)[:, None] + 0.5 * (1.0 + x)) * width
    step = 0.5 * special.erfc(6.0 * (2.0 * (r - inner) / (outer - inner) - 1.0))
    ring = (airy_psf(r, lambda_n) * step * 2.0 * np.pi * r * (0.5 * width * w)).ravel()
    k = np.linspace(0.0, cut, math.ceil(6.0 * outer * cut))
    values = np.concatenate(
        [special.j0(2.0 * np.pi * np.outer(part, r.ravel())) @ ring for part in np.array_split(k, 64)]
    )
    return interpolate.make_interp_spline(k, values, k=7)
