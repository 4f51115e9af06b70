"""A pupil's transfer as a table over radius and direction, at several wavelengths: computed once, looked up everywhere.

In polar coordinates the transfer of a pupil is smooth: the cone at zero frequency is a straight line along each
direction, and where it ends, as (1 − ρ)^{3/2}, places lie like 1 − t². So few places are enough, and how many is found
by trying: a table is as fine as makes places between its nodes right.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.errors import UnsupportedError
from camsim.kernels import shared
from camsim.optics.of_pupil import OfPupil
from camsim.optics.overlaps import overlaps
from camsim.quadrature import chebyshev, gauss_legendre, interpolation

FIRST_RULE, MOST_RULE = 6, 600  # nodes each way of the integrals over overlaps
RADII = 10, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256
DIRECTIONS = 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256
DEGREES = 2, 4, 6, 8, 12, 16, 20
ROUNDING, DIGITS = 1e-12, 12  # waves; of directions that are one
SAME_PATH = 1e-9  # nm: path differences that are one
RADII_TRIED, DIRECTIONS_TRIED = (
    (0.15, 0.45, 0.8),
    (0.031, 0.173, 0.342, 0.561, 0.777, 0.913),
)  # of the largest; of half a turn


@dataclass(frozen=True, eq=False)
class TransferTable:
    """Transfers at ρ = |f|·λN, 0 … 1 times ``outer``, and directions 0 … π.

    breaks  : ρ between which the transfer is smooth, from 0 to 1; it goes as the power 3/2 at each
    values  : (j, radii, directions) at Chebyshev places of each piece; directions evenly from 0 to below π
    blur_um : (j,) λN
    """

    wavelength_nm: F64
    blur_um: F64
    outer: float
    breaks: tuple[float, ...]
    values: C128

    def along(self, frequency_per_um: F64, directions: int, angle_rad: float = 0.0) -> C128:
        """Return transfers (j, n, directions) at radial frequencies (n,), in even directions from ``angle_rad`` on.

        directions : over half a turn, as many as the table's or more
        """
        count = self.values.shape[2]
        turned = _finer(self.values, directions, angle_rad) if count > 1 or angle_rad else self.values
        turned = np.broadcast_to(turned, (*turned.shape[:2], directions)) if count == 1 else turned
        out = np.zeros((len(self.values), frequency_per_um.size, directions), complex)
        for own, values, blur in zip(out, turned, self.blur_um, strict=True):
            rho = frequency_per_um * (blur / self.outer)
            within = rho < 1.0
            own[within] = radial_matrix(len(values), rho[within], self.breaks) @ values
        return out


def radial_places(count: int, breaks: tuple[float, ...] = (0.0, 1.0)) -> F64:
    """Return ρ at ``count`` places of each piece: a + (b − a)·sin²(πt/2), t Chebyshev's on 0 … 1."""
    t = 0.5 * (1.0 + chebyshev(count))
    return np.concatenate([a + (b - a) * np.sin(0.5 * np.pi * t) ** 2 for a, b in pairwise(breaks)])


def radial_matrix(total: int, rho: F64, breaks: tuple[float, ...] = (0.0, 1.0)) -> F64:
    """Return the matrix (n, total) of interpolation from all pieces' places to ρ (n,)."""
    count = total // (len(breaks) - 1)
    out = np.zeros((rho.size, total))
    piece = np.clip(np.searchsorted(breaks, rho, side="right") - 1, 0, len(breaks) - 2)
    for k, (a, b) in enumerate(pairwise(breaks)):
        mine = piece == k
        t = (2.0 / np.pi) * np.arcsin(np.sqrt((rho[mine] - a) / (b - a)))
        out[mine, k * count : (k + 1) * count] = interpolation(chebyshev(count), 2.0 * t - 1.0)
    return out


def _finer(values: C128, directions: int, angle_rad: float) -> C128:
    """Return the table in other even directions over half a turn: T(ρ, θ + π) is the conjugate."""
    whole = np.concatenate([values, values.conj()], axis=2)
    count = whole.shape[2]
    waves = np.fft.fft(whole, axis=2) / count
    order = np.fft.fftfreq(count, 1.0 / count)
    waves = waves * np.exp(1j * order * angle_rad)
    wide = np.zeros((*values.shape[:2], 2 * directions), complex)
    half = min(count, 2 * directions) // 2
    wide[..., :half] = waves[..., :half]
    wide[..., -half:] = waves[..., -half:]
    if half == count // 2 and 2 * directions > count:  # the highest wave is as much of either sign
        wide[..., half] = 0.5 * waves[..., half]
        wide[..., -half] *= 0.5
    turned: C128 = np.fft.ifft(wide, axis=2)[..., :directions] * (2 * directions)
    return turned


@functools.lru_cache(maxsize=512)
def transfer_table(lens: OfPupil, wavelength_nm: tuple[float, ...], allowed: float) -> TransferTable:
    """Return a lens's table that is right to ``allowed``.

    Each axis has as many places as make places between them right, tried along a few lines; so have the integrals.
    """
    at, outer = _Overlaps.of(lens, np.array(wavelength_nm)), lens.pupil.outer_radius
    nodes = at.nodes_for(0.2 * allowed)
    directions = 1 if at.revolves else _fewest(DIRECTIONS, lambda n: _directions_off(at, outer, n, nodes), allowed)
    radii = _fewest(RADII, lambda n: _radii_off(at, outer, n, nodes), allowed)
    rho, angle = outer * radial_places(radii, at.breaks), np.pi * np.arange(directions) / directions
    values = at(np.repeat(rho, directions), np.tile(angle, rho.size), nodes)
    blur_um = np.array([lens.blur_um(nm) for nm in wavelength_nm])
    table = np.ascontiguousarray(values.reshape(len(blur_um), rho.size, directions))
    return TransferTable(at.wavelength_nm, blur_um, outer, at.breaks, table)


def _fewest(counts: tuple[int, ...], off: Callable[[int], float], allowed: float) -> int:
    """Return the smallest count that is off by no more than allowed, or the largest."""
    return next((count for count in counts if off(count) <= allowed), counts[-1])


def _directions_off(at: _Overlaps, outer: float, count: int, nodes: int) -> float:
    """Return how far off the middles between directions are on a few radii."""
    rho = outer * np.array(RADII_TRIED)
    angle = np.pi * np.arange(count) / count
    values = at(np.repeat(rho, count), np.tile(angle, rho.size), nodes).reshape(-1, rho.size, count)
    between = math.pi * np.array(DIRECTIONS_TRIED)
    right = at(np.repeat(rho, between.size), np.tile(between, rho.size), nodes).reshape(-1, rho.size, between.size)
    found = np.concatenate([_finer(values, count, angle)[..., :1] for angle in between.tolist()], axis=2)
    return float(np.abs(found - right).max())


def _radii_off(at: _Overlaps, outer: float, count: int, nodes: int) -> float:
    """Return how far off radii between the nodes are, in two directions."""
    places = radial_places(count, at.breaks)
    tried = 0.5 * (places[1:] + places[:-1])
    tried = tried[:: max(1, tried.size // 12)]
    off = 0.0
    for angle in (0.4,) if at.revolves else (0.4, 1.9):
        known = at(outer * places, np.full(places.size, angle), nodes)
        right = at(outer * tried, np.full(tried.size, angle), nodes)
        off = max(off, float(np.abs(known @ radial_matrix(places.size, tried, at.breaks).T - right).max()))
    return off


@dataclass(frozen=True, eq=False)
class _Overlaps:
    """A pupil's overlaps with its shifted copies, at several wavelengths.

    paths : (w, d + 1, d + 1) coefficients of x^a·y^b, nm;  which: (j,) which of them each wavelength has
    turns : the angle after which a polygon with a wavefront of revolution is the same; 0 of a circle; π of all others
    """

    lens: OfPupil
    wavelength_nm: F64
    paths: F64
    which: I64
    turns: float

    @property
    def revolves(self) -> bool:
        """Whether all directions are alike."""
        return self.turns == 0.0

    @property
    def breaks(self) -> tuple[float, ...]:
        """Where along the radius outlines of the opening begin or cease to meet."""
        hole = self.lens.pupil.obstruction
        if self.lens.pupil.shape != "circular" or not hole:
            return 0.0, 1.0
        return tuple(sorted({0.0, hole, 0.5 - 0.5 * hole, 0.5 + 0.5 * hole, 1.0}))

    @classmethod
    def of(cls, lens: OfPupil, wavelength_nm: F64) -> _Overlaps:
        """Find the polynomial that a wavefront is."""
        terms, degree = _polynomials(lens, wavelength_nm)
        same = [int(np.argmax(np.abs(terms[: k + 1] - own).max(axis=1) <= SAME_PATH)) for k, own in enumerate(terms)]
        kept, which = np.unique(same, return_inverse=True)
        paths = np.zeros((kept.size, degree + 1, degree + 1))
        for out, own in zip(paths, terms[kept], strict=True):
            out[_powers(degree)] = own
        x = np.array([0.3, 0.7, 1.0])
        turned = [lens.waves(x * math.cos(a), x * math.sin(a), float(wavelength_nm[0])) for a in (0.0, 1.1, 2.9)]
        turns = math.pi  # after which directions repeat, conjugate
        if float(np.ptp(turned, axis=0).max()) <= ROUNDING:
            turns = 0.0 if lens.pupil.shape == "circular" else 2.0 * math.pi / lens.pupil.sides
        return cls(lens, wavelength_nm, paths, which.astype(np.int64), turns)

    def __call__(self, rho: F64, angle: F64, nodes: int) -> C128:
        """Return transfers (j, n) at ρ and directions (n,), each kind of direction computed once."""
        pupil = self.lens.pupil
        if 0.0 < self.turns < math.pi:  # a regular polygon is the same turned, and mirrored about its corners
            first = math.radians(pupil.rotate_deg) + (0.25 * math.pi if pupil.shape == "square" else 0.0)
            turned: F64 = np.remainder(angle - first, self.turns)
            angle = np.asarray(first + np.round(np.minimum(turned, self.turns - turned), DIGITS), np.float64)
        both, which = np.unique(rho + 1j * angle, return_inverse=True)
        rho, angle = np.ascontiguousarray(both.real), np.ascontiguousarray(both.imag)
        plain = not self.paths.any()  # then all wavelengths have one
        radians = 2.0 * np.pi / (self.wavelength_nm[:1] if plain else self.wavelength_nm)
        out = np.empty((rho.size, radians.size), complex)
        normals = np.array([] if pupil.shape == "circular" else [*pupil.normals()], float)
        opening = normals, float(pupil.inner_radius), float(pupil.obstruction)
        waves, rule = (radians, self.which[: radians.size]), _rule(nodes)

        def work(begin: int, stop: int) -> None:
            cuts = np.empty((pupil.sides + 2) * (pupil.sides + 6) + 32)
            overlaps(2.0 * rho, angle, opening, self.paths, waves, rule, cuts, out, begin, stop)

        shared(rho.size, work, least=8)
        return np.broadcast_to(out[which].T / pupil.area, (self.wavelength_nm.size, which.size))

    def nodes_for(self, allowed: float) -> int:
        """Return how many nodes each way are enough: so many that half as many more change nothing."""
        outer = self.lens.pupil.outer_radius
        rho = outer * np.array([0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95])
        angle = np.array([0.3, 1.2, 2.1, 3.0, 0.8, 1.7, 2.6])
        nodes = FIRST_RULE
        before = self(rho, angle, nodes)
        while True:
            more = math.ceil(1.5 * nodes)
            found = self(rho, angle, more)
            if np.abs(found - before).max() <= allowed:
                return nodes
            if more > MOST_RULE:
                raise UnsupportedError(
                    f"the wavefront turns too fast to be integrated at {self.wavelength_nm.min():g} nm; "
                    "give fewer waves of aberration, or a larger tolerance",
                    key="lens",
                )
            nodes, before = more, found


def _powers(degree: int) -> tuple[I64, I64]:
    """Return the powers a and b of x and y, a + b no more than the degree."""
    a, b = np.nonzero(np.add.outer(np.arange(degree + 1), np.arange(degree + 1)) <= degree)
    return a, b


def _polynomials(lens: OfPupil, wavelength_nm: F64) -> tuple[F64, int]:
    """Return coefficients (j, terms) of path differences in nm, and the degree at which they are all of them."""
    for degree in DEGREES:
        count = 2 * degree + 5
        r, angle = np.sqrt((np.arange(count) + 0.5) / count), 2.0 * np.pi * np.arange(count) / count
        x, y = ((r[:, None] * part).ravel() for part in (np.cos(angle), np.sin(angle)))
        path = np.stack([lens.waves(x, y, nm) * nm for nm in wavelength_nm.tolist()], axis=1)
        a, b = _powers(degree)
        powers = x[:, None] ** a * y[:, None] ** b
        terms = np.linalg.lstsq(powers, path, rcond=None)[0]
        if np.abs(powers @ terms - path).max() <= SAME_PATH * (1.0 + np.abs(path).max()):
            return terms.T, degree
    raise UnsupportedError(f"the wavefront is no polynomial of degree {DEGREES[-1]} or less", key="lens")


def _rule(nodes: int) -> tuple[F64, F64, F64, F64]:
    """Return places −cos u across a strip with their weights, and a Gauss rule on 0 … 1 along it."""
    x, w = gauss_legendre(nodes)
    u = 0.5 * np.pi * (1.0 + x)
    return -np.cos(u), 0.5 * np.pi * np.sin(u) * w, 0.5 * (1.0 + x), 0.5 * w
