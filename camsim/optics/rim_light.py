"""The far light of a round pupil: what its rim throws, rings averaged away, to as many powers of 1/r as matter.

Far beyond its geometric spot a pupil's amplitude comes from two places of its rim, those along the direction that is
looked in. About each of them, t along the direction and v across, the phase −πrt (r in λN) falls on steepest paths as
exp(−y − q²): t = T − iy/πr inward from the rim, where v² = 1 − T² and T = 1 − iq²/πr along it. The wavefront, a
polynomial, is what it is at such complex places. So either amplitude is a Gauss–Laguerre rule times a Gauss–Hermite
one. One turns with exp(−iπr), the other with exp(+iπr): the sum of their squares is the light between the rings.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64

Waves = Callable[[F64, F64], F64]

ANGLES, RADII = 64, 24  # where a wavefront is read: harmonics to order 31, and a series in r² about the rim
ABOUT = 0.5  # r² from 1 to either side
NOTHING = 1e-13  # of the largest coefficient: what no polynomial of order 20 has
COARSE, FINE = (16, 12), (22, 16)  # nodes along the rim, and inward; what two rules differ by is the first one's error


class Circle(NamedTuple):
    """A wavefront about a circle: Σ w_km·T_k((r² − 1)/ABOUT)·exp(imθ), r in units of the circle's radius, waves.

    orders : (m,) of the harmonics that there are;  series: (k, m);  share: the circle's radius, of the pupil's
    """

    orders: I64
    series: C128
    share: float

    def amplitudes(self, x: F64, directions: int, nodes: tuple[int, int]) -> C128:
        """Return what the circle throws, x (n,) λN away in even directions: outward and back, (2, n, m).

        Less exp(−iπr) and exp(+iπr), as much for both and as it comes from each of its places.
        """
        # Who reads a lens from a file needs no compiler.
        from camsim.kernels import shared
        from camsim.kernels.rim import fill_amplitudes

        turned = np.exp(2j * np.pi * np.outer(self.orders, np.arange(directions) / directions))
        rules, turns = (*_hermite(nodes[0]), *_laguerre(nodes[1])), np.pi * self.share * x
        found = np.empty((2, x.size, directions), complex)
        task = found, turns, rules, self.series, self.orders, turned, ABOUT
        shared(x.size, functools.partial(fill_amplitudes, *task))
        found *= self.share**2
        return found


def wavefront_about(waves: Waves, radius: float) -> Circle | None:
    """Read a wavefront about a circle of so many radii of the pupil; None: it is no polynomial of moderate order."""
    x = np.cos(np.pi * (np.arange(RADII) + 0.5) / RADII)
    angle, r = 2.0 * np.pi * np.arange(ANGLES) / ANGLES, radius * np.sqrt(1.0 + ABOUT * x)[:, None]
    around = scipy.fft.fft(waves(r * np.cos(angle), r * np.sin(angle)), axis=1) / ANGLES
    series = scipy.fft.dct(around.real, axis=0) + 1j * scipy.fft.dct(around.imag, axis=0)
    series /= RADII
    series[0] *= 0.5
    orders, sizes = scipy.fft.fftfreq(ANGLES, 1.0 / ANGLES), np.abs(series)
    most = float(sizes.max())
    if max(float(sizes[:, np.abs(orders) > 0.375 * ANGLES].max()), float(sizes[-2:].max())) > NOTHING * max(most, 1.0):
        return None
    some = sizes.max(axis=0) > 0.1 * NOTHING * most
    return Circle(orders[some].astype(np.int64), np.ascontiguousarray(series[:, some]), radius)


def light_between_rings(rims: tuple[Circle, ...], distance: F64, directions: int, nodes: tuple[int, int]) -> F64:
    """Return the light per square λN from a point of unit power, (n, directions), behind a disc or a ring.

    rims       : its outer one, and its inner one if it is a ring
    distance   : (n,) λN, so far that what the wavefront bends lies well within; NaN far too near
    directions : in the image, even ones from x on
    """
    light = np.zeros((distance.size, directions))
    with np.errstate(over="ignore", invalid="ignore"):
        for rim in rims:
            outward, back = np.square(np.abs(rim.amplitudes(distance, directions, nodes)))
            light += outward + np.roll(back, directions // 2, axis=1)
    light[~(light < 1.0)] = np.nan  # brighter than a pattern's middle: too near, and no number
    inner = rims[1].share if len(rims) > 1 else 0.0
    return light / (4.0 * math.pi * (1.0 - inner**2))


def light_without_waves(circles: tuple[float, ...], distance: F64) -> F64:
    """Return the same of a pupil without aberrations, at distances of any shape: 2J₁ is a Hankel function each way.

    >>> r = np.array([50.0])
    >>> flat = wavefront_about(lambda x, y: np.zeros(np.broadcast(x, y).shape), 1.0)
    >>> between = light_between_rings((flat,), r, 8, COARSE)[0]
    >>> bool(np.all(np.abs(between / light_without_waves((1.0,), r) - 1.0) < 1e-12))
    True
    """
    inner = circles[1] if len(circles) > 1 else 0.0
    light = sum(radius**2 * np.abs(scipy.special.hankel1e(1, np.pi * radius * distance)) ** 2 for radius in circles)
    between: F64 = 2.0 * light / distance**2 / (4.0 * math.pi * (1.0 - inner**2))
    return between


@functools.cache
def _hermite(count: int) -> tuple[F64, F64]:
    return np.polynomial.hermite.hermgauss(count)


@functools.cache
def _laguerre(count: int) -> tuple[F64, F64]:
    return np.polynomial.laguerre.laggauss(count)
