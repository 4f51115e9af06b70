"""Tables of the system's point spread function (PSF), lens ⊗ OLPF ⊗ photosite, by radius and angular harmonic.

In polar coordinates about a photosite the transfer is T(f, φ) = Σ T_m(f)·e^{imφ}. The PSF has the same form, with
2π(−i)^m ∫ T_m(f)·J_m(2πfr) f df in place of T_m. Its integral G over r dr from 0 has ∫ J_m(x)·x dx in place of J_m.
All wavelengths are expressed by the few whose transfers span the others. Beyond the cutoff radius, where ringing is
below the tolerance, G is a series in powers of 1/r: a power f^s of T_m at 0 contributes one of r^{−s}.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np

from camsim.core.arrays import F64, I64, distinct
from camsim.core.kernels import shared
from camsim.numerics.matrix_products import product
from camsim.numerics.quadrature import chebyshev, gauss_pieces, gauss_rules, power_series
from camsim.optics import OpticalSystem, RoundLens
from camsim.optics.pattern import RING
from camsim.rendering.direct.records import POWERS, Table
from camsim.rendering.direct.spread_kernels import ROWS, fill_rows

SERIES_NODES, OF_BREAK, OF_EXTENT = 14, 0.2, 0.4  # of a transfer's series at 0, and the range of its fit
MOST_NODES = 48  # of one panel of frequencies
FEWER = 0.75  # nodes of a zone, over those of the next, that are worth transfers of their own
# Of many wavelengths, breaks are merged where closer than a share of the band: at most, and by the allowed error to the
# power 0.6. Panels then get so many nodes besides those for their phase, not three. Curves with bends have more breaks.
FEW_BREAKS, NEAREST, MERGED, MORE_NODES, SMOOTH, MANY_BREAKS = 8, 1.0 / 12.0, 1200.0, 6, 3, 64
QUINTIC = 1.0 / 46080.0  # error of quintic interpolation between two rows, over the sixth derivative times step⁶
STEEP = 4.5  # sixth derivative, over that of a wave of the highest frequency and the fifth moment of the transfer
FEWEST_ROWS, MOST_ROWS = 3.0, 16.0  # per period of the highest frequency
FIRST_ZONE, WIDER, ENOUGH = 8.0, 3.0, 1.3  # zones of equal density: first, in periods; ratio of the others, at least
FEW_HARMONICS = 3.0  # radians of phase with hardly a harmonic
ROUNDING = 1e-13  # of sums, and of places in the band, relative
NOTHING = 1e-300  # keeps a quotient of zeros finite
OF_POWER, OF_DENSITY, OF_HARMONIC = 0.07, 0.1, 0.5  # error of a table's powers of 1/r, signals and harmonics, over its
FIRST_POWER, OF_MOMENTS = 0.2, 4.0  # light beyond a distance in λN; allowed error, in units of a table's
MOST_CACHED = 12  # tables, some MB each: those of one camera's channels and pictures


class Spline(NamedTuple):
    """A B-spline with which the PSF is convolved: its degree, step in pitches, and the direction (cos, sin) of x."""

    degree: int
    step: float
    along: tuple[float, float]

    def transfer(self, fx: F64, fy: F64) -> F64:
        """Return the spline's transfer at frequencies in cycles/pitch."""
        x, y = self.along
        both: F64 = (np.sinc(self.step * (x * fx + y * fy)) * np.sinc(self.step * (x * fy - y * fx))) ** (
            self.degree + 1
        )
        return both

    @property
    def extent(self) -> float:
        """How far the spline reaches from its centre, pitches."""
        return 0.5 * (self.degree + 1) * self.step * math.sqrt(2.0)


def tabled(
    system: OpticalSystem,
    pitch_um: float,
    wavelength_nm: F64,
    density: F64,
    *,
    until: float,
    allowed: float,
    spline: Spline | None = None,
) -> tuple[Table, F64]:
    """Return the table of the PSF, and the weights (n, kinds) that its kinds of light have in every signal.

    density : (n, j) signals at wavelengths (j,)
    until : cutoff radius of ringing, pitches;  allowed: error of a photosite for light of 1
    """
    few, mixture = _few(density, OF_DENSITY * allowed / wavelength_nm.size)
    light = tuple(wavelength_nm.tolist()), tuple(map(tuple, density[few].tolist()))
    made: Callable[..., tuple[Table, F64]] = _made
    try:
        hash(system)
    except TypeError:  # a custom stage that is not hashable
        made = _made.__wrapped__
    table, of_few = made(system, pitch_um, light, until, allowed, spline)
    return table, product(mixture, of_few)


Signals: TypeAlias = tuple[tuple[float, ...], tuple[tuple[float, ...], ...]]


@functools.lru_cache(maxsize=MOST_CACHED)
def _made(
    system: OpticalSystem, pitch_um: float, signals: Signals, until: float, allowed: float, spline: Spline | None
) -> tuple[Table, F64]:
    """Return the table for signals that are linearly independent: wavelengths (j,), and values (n, j) there."""
    wavelength_nm, density = (np.array(column) for column in signals)
    highest = system.highest_per_um(wavelength_nm) * pitch_um
    breaks = breaks_of(system, pitch_um, wavelength_nm)
    extent = system.extent_um / pitch_um + (0.0 if spline is None else spline.extent)
    phase = 2.0 * math.pi * highest * extent
    if not fades(system):
        # The first neglected term of the series in 1/r: c₁/R·(extent/R)⁶.
        blur = float(system.blurs_um(wavelength_nm).max()) / pitch_um
        until = max(until, (FIRST_POWER * blur * extent**6 / (OF_MOMENTS * allowed)) ** (1.0 / 7.0))
    allowed /= max(1.0, phase / FEW_HARMONICS)  # the errors of the harmonics add up
    starts, begin = [0.0], extent + FIRST_ZONE / highest
    while ENOUGH * begin < until:
        starts.append(begin)
        begin *= WIDER
    stops = [*starts[1:], until + 2.0 / (FEWEST_ROWS * highest)]
    assert isinstance(system.lens, RoundLens)
    nearest = _nearest(len(system.lens.pattern().breaks), len(breaks), allowed)
    rules = [_frequencies(breaks, highest, end + extent, allowed, highest * nearest) for end in stops]
    # A zone whose rule is hardly smaller shares that of the next.
    which = np.cumsum([0, *(one.size < FEWER * other.size for (one, _), (other, _) in pairwise(rules))])
    rules = [rules[int(np.flatnonzero(which == k)[-1])] for k in range(which[-1] + 1)]
    # A transfer's series at 0 gives the tail.
    series_until = min(OF_BREAK * breaks.min(initial=highest), OF_EXTENT / extent if extent else math.inf)
    low = 0.5 * series_until * (1.0 + chebyshev(SERIES_NODES))
    f = np.concatenate([low, *(nodes for nodes, _ in rules)])
    begins = np.cumsum([low.size, *(nodes.size for nodes, _ in rules)])
    last = slice(begins[-2], None)
    curves = product(density, transfers(system, pitch_um, wavelength_nm, f))
    few, mixture = _few(curves[:, last], allowed)
    density, curves = density[few], curves[few]
    beyond = 8.0 * (math.cbrt(phase) + 1.0) * min(math.log10(allowed) / math.log10(ROUNDING), 1.0)
    angles = 2 * math.ceil(phase + beyond) if extent else 1
    around = _around(system, pitch_um, spline, f, angles=angles)
    orders, sines = _harmonics(around[..., last], np.abs(curves[:, last]).max(axis=0), OF_HARMONIC * allowed)
    shapes = np.concatenate([around[0, orders[: len(orders) - sines]], around[1, orders[len(orders) - sines :]]])
    # ∫ J_m(x) x dx over all x is m.
    weighted = shapes[:, last] * (rules[-1][1] / f[last])
    ends = (orders[:, None] / (2.0 * math.pi)) * np.einsum("hn,kn->hk", weighted, curves[:, last])
    ends[0] = density.sum(axis=1) / (2.0 * math.pi)
    strength = rules[-1][1] * (f[last] / highest) ** 5 * np.abs(around[..., last]).max(axis=(0, 1))
    steep = STEEP * float((np.abs(curves[:, last]) * strength).sum(axis=1).max()) / highest
    rings = sum(size for _, size, _ in system.lens.pattern().rings) / RING
    per_pitch = [_rows(steep, (start - extent) * highest, rings, allowed) * highest for start in starts]
    first, parts = [0], []
    for zone, (start, end, rate) in enumerate(zip(starts, stops, per_pitch, strict=True)):
        r, step = start + np.arange(math.ceil((end - start) * rate) + 1) / rate, 1.0 / rate
        first.append(first[-1] + r.size)
        rule = int(which[zone])
        here = slice(begins[rule], begins[rule + 1])
        found = np.zeros((4, len(orders), len(few), r.size))
        k, weight = 2.0 * math.pi * f[here], 2.0 * math.pi * f[here] * rules[rule][1]
        each = np.ascontiguousarray(shapes[:, here]), np.ascontiguousarray(curves[:, here].T)
        work = functools.partial(fill_rows, r, k, weight, *each, orders, bool((orders % 2).any()), found)
        shared(r.size, work, least=ROWS)
        g, p, slope, bend = np.moveaxis(found, 3, 1).reshape(4, r.size, -1)
        r = r[:, None]
        parts.append(np.stack([g, r * p * step, (p + r * slope) * step**2, p, slope * step, bend * step**2], axis=1))
    rows, half = np.concatenate(parts), len(orders) - sines
    powers = np.zeros((len(orders), len(few), POWERS))
    if not fades(system):
        values = shapes[:, None, : low.size] * curves[:, : low.size]
        powers = _far_powers(orders, power_series(values, series_until, POWERS + 1))
    total = np.abs(powers).max(axis=1) @ until ** -np.arange(1.0, POWERS + 1.0)
    stride = int(np.gcd.reduce(orders)) or 1
    table = Table(
        within=np.ascontiguousarray(rows[:, :3]),
        light=np.ascontiguousarray(rows[:, 3:]),
        starts=np.array(starts),
        per_pitch=np.array(per_pitch),
        first=np.array(first[:-1]),
        until=until,
        step=stride,
        cosines=half - 1,
        sines=sines,
        ends=ends,
        ending=_last(np.abs(ends).max(axis=1) > allowed, half),
        powers=powers,
        reach=_reach(powers, OF_POWER * allowed),
        far=_last(total > allowed, half),
        kinds=len(few),
    )
    return table, mixture


def _rows(steep: float, waves: float, rings: float, allowed: float) -> float:
    """Return the rows per period in a zone that begins so many periods from the centre: fewer where ringing is weak.

    rings : strength of the ringing, over that of a clear lens
    """
    if waves > 0.0:
        steep = min(steep, 2.0 * max(rings, 1.0) / (math.pi**3 * waves**2))
    rows_a_wave: float = 2.0 * math.pi * (QUINTIC * steep / allowed) ** (1.0 / 6.0)
    return min(max(rows_a_wave, FEWEST_ROWS), MOST_ROWS)


def _reach(powers: F64, allowed: float) -> F64:
    """Return where each power of 1/r, with those after it, ends: 2π∫ c·r^{−3−p} r dr of all beyond is allowed."""
    over = np.arange(1.0, POWERS + 1.0)
    light = 2.0 * math.pi / over * np.abs(powers).max(axis=(0, 1))
    reach: F64 = np.maximum.accumulate(((light / allowed) ** (1.0 / over))[::-1])[::-1]
    return reach


def _last(some: np.ndarray, cosines: int) -> int:
    """Return how many of the first harmonics include all those in ``some``, with sines counted as cosines."""
    both = some[:cosines].copy()
    both[1:] |= some[cosines:] if len(some) > cosines else False
    return int(np.flatnonzero(both).max(initial=0)) + 1


def transfers(system: OpticalSystem, pitch_um: float, wavelength_nm: F64, f: F64) -> F64:
    """Return the transfer (wavelengths, n) of a rotationally symmetric lens at radial frequencies in cycles/pitch."""
    per_um, zero = f / pitch_um, np.zeros_like(f)
    return np.stack([np.real(system.lens.otf(per_um, zero, nm)) for nm in wavelength_nm.tolist()])


def breaks_of(system: OpticalSystem, pitch_um: float, wavelength_nm: F64) -> F64:
    """Return the frequencies where the lens's transfers are not smooth, cycles/pitch."""
    assert isinstance(system.lens, RoundLens)
    breaks = np.array(system.lens.pattern().breaks)
    found: F64 = distinct(np.outer(1.0 / system.blurs_um(wavelength_nm), breaks)) * pitch_um
    return found


def fades(system: OpticalSystem) -> bool:
    """Return whether the PSF has neither ringing nor an algebraic tail, like a Gaussian."""
    assert isinstance(system.lens, RoundLens)
    pattern = system.lens.pattern()
    return not pattern.rings and not any(pattern.powers)


def _nearest(each: int, breaks: int, allowed: float) -> float:
    """Return the share of the band within which breaks, ``each`` of one wavelength, are merged; 0: none."""
    if breaks <= (FEW_BREAKS if each <= SMOOTH else MANY_BREAKS):
        return 0.0
    return min(NEAREST, MERGED * allowed**0.6) if each <= SMOOTH else 1.0 / MANY_BREAKS


def _frequencies(breaks: F64, highest: float, until: float, allowed: float, nearest: float) -> tuple[F64, F64]:
    """Return quadrature nodes and weights over 0 … highest, in panels between breaks farther apart than ``nearest``."""
    ends = [0.0]
    for place in [*breaks.tolist(), highest]:
        if place - ends[-1] > max(nearest, ROUNDING * highest):
            ends.append(min(place, highest))
    ends[-1] = highest
    low, wide = np.array(ends[:-1]), np.diff(ends)
    # Where no breaks are merged, nodes lie like sin² between them: with the power 3/2 there, others converge slowly.
    denser = 1.0 if nearest else 0.5 * math.pi
    pieces, orders = gauss_pieces(math.pi * until * denser * wide, 0.1 * allowed, MOST_NODES)
    orders += MORE_NODES if nearest else 3
    panel, of_piece = np.repeat(np.arange(low.size), pieces), np.repeat(orders, pieces)
    piece = np.arange(panel.size) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    x, w, _ = gauss_rules(tuple(range(1, MOST_NODES + MORE_NODES + 1)))
    filled = np.arange(x.shape[1]) < of_piece[:, None]
    t = ((piece[:, None] + 0.5 + 0.5 * x[of_piece - 1]) / pieces[panel, None])[filled]
    weights = (0.5 * w[of_piece - 1] * (wide / pieces)[panel, None])[filled]
    if not nearest:
        t, weights = np.sin(0.5 * math.pi * t) ** 2, weights * denser * np.sin(math.pi * t)
    panel = np.repeat(panel, of_piece)
    return low[panel] + wide[panel] * t, weights


def _few(curves: F64, allowed: float) -> tuple[I64, F64]:
    """Return the indices of curves (k, n) that span all others to within ``allowed``, and the mixtures (k, few)."""
    rest, chosen = curves.copy(), list[int]()
    parts = np.zeros((len(curves), 0))
    while len(chosen) < len(curves):
        size = np.abs(rest).max(axis=1)
        j = int(size.argmax())
        if chosen and size[j] <= allowed:
            break
        chosen.append(j)
        unit = rest[j] / max(math.sqrt(float(np.einsum("n,n->", rest[j], rest[j]))), NOTHING)
        along = np.einsum("kn,n->k", rest, unit)
        parts = np.concatenate([parts, along[:, None]], axis=1)
        rest -= along[:, None] * unit
    # Solve parts = mixture · parts[chosen], where parts[chosen] is triangular.
    triangle, mixture = parts[chosen], np.zeros_like(parts)
    for k in reversed(range(len(chosen))):
        mixture[:, k] = (parts[:, k] - np.einsum("kc,c->k", mixture[:, k + 1 :], triangle[k + 1 :, k])) / max(
            triangle[k, k], NOTHING
        )
    return np.array(chosen), mixture


def _harmonics(found: F64, strength: F64, allowed: float) -> tuple[I64, int]:
    """Return orders (h,) of the significant harmonics of (2, orders, n), cosines first, and the number of sines.

    strength : (n,) largest factor by which they are multiplied
    """
    significant = (np.abs(found) * strength).max(axis=2) > allowed
    present = np.flatnonzero(significant.any(axis=0))
    stride = int(np.gcd.reduce(present)) or 1
    some = stride * np.arange(1, int(present.max(initial=0)) // stride + 1)
    has_sines = bool(significant[1].any())
    return np.concatenate([[0], some, some if has_sines else some[:0]]), some.size if has_sines else 0


def _around(system: OpticalSystem, pitch_um: float, spline: Spline | None, f: F64, *, angles: int) -> F64:
    """Return cosine and sine harmonics (2, orders, n) of the transfer of all stages but the lens, times 2(−i)^m."""
    # Half a turn on, a transfer is the conjugate.
    turn = 2.0 * math.pi * np.arange(-(-angles // 2))[:, None] / angles
    fx, fy = f * np.cos(turn), f * np.sin(turn)
    footprint = np.asarray(system.footprint_otf(fx / pitch_um, fy / pitch_um), complex)
    if spline is not None:
        footprint = footprint * spline.transfer(fx, fy)
    half = np.broadcast_to(footprint, fx.shape)
    if half.imag.any():
        terms = np.fft.fft(np.concatenate([half, half.conj()]), axis=0)[: (angles + 1) // 2] / angles
    else:
        terms = np.zeros(((angles + 1) // 2, f.size), complex)
        terms[::2] = np.fft.rfft(half.real, axis=0)[: len(terms[::2])] / len(half)
    order = np.arange(len(terms))
    terms = terms * (np.array([1.0, -1.0j, -1.0, 1.0j])[order % 4] * np.where(order == 0, 1.0, 2.0))[:, None]
    return np.stack([terms.real, -terms.imag])


def _far_powers(orders: I64, series: F64) -> F64:
    """Return the tail's powers (harmonics, kinds, POWERS) from a transfer's series (harmonics, kinds, powers).

    ∫ f^s·J_m(2πfr) f df = (2πr)^{−s−2}·2^{s+1}·Γ((m+s+2)/2)/Γ((m−s)/2).
    """
    powers = np.zeros((*series.shape[:2], POWERS))
    for h, m in enumerate(orders.tolist()):
        for s in range(max(1, m + 1), POWERS + 1):
            if (s - m) % 2:  # even powers are smooth at 0 and leave no tail
                times = math.gamma(0.5 * (m + s + 2)) / math.gamma(0.5 * (m - s)) * 2.0 ** (s + 1)
                powers[h, :, s - 1] = series[h, :, s] * times * (2.0 * math.pi) ** (-s - 1)
    return powers


def smooth_energy(system: OpticalSystem, pitch_um: float, nm: float, r: F64) -> F64:
    """Return the asymptotic encircled energy of a lens within radii r, pitches, without ringing."""
    if fades(system):
        return np.ones_like(r)
    until = OF_BREAK * float(breaks_of(system, pitch_um, np.array([nm])).min())
    f = 0.5 * until * (1.0 + chebyshev(SERIES_NODES))
    series = power_series(transfers(system, pitch_um, np.array([nm]), f)[None], until, POWERS + 1)
    powers = _far_powers(np.zeros(1, np.int64), series)[0, 0]
    energy = np.ones_like(r)
    for p, size in enumerate(powers.tolist()):
        energy -= 2.0 * math.pi * size / (p + 1.0) * r ** -(p + 1.0)
    return energy
