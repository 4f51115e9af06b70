"""OTFs of pupils at many frequencies: integrals over the overlap of two shifted copies of the pupil."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from camsim.core.arrays import C128, F64, I64, distinct
from camsim.core.kernels import kernel, shared
from camsim.core.kernels.turning import turned
from camsim.errors import UnsupportedError
from camsim.numerics.quadrature import gauss_legendre
from camsim.optics.pupil import Pupil

FIRST_RULE, MOST_RULE = 6, 600  # nodes per axis of the integrals over overlaps
# Shifts, of the largest, and directions, radians, at which rules are compared: uneven, so that none is special.
SHARES = np.array([0.05, 0.15, 0.25, 0.4, 0.55, 0.7, 0.85, 0.95])
TRIED = np.array([0.02, 0.3, 0.77, 1.2, 1.56, 2.1, 2.9])
DEGREES = 2, 4, 6, 8, 12, 16, 20  # of the polynomials that are tried for a wavefront
ROUNDING, DIGITS = 1e-12, 12  # waves; digits to which equal directions agree
SAME_PATH = 1e-9  # nm: path differences closer than this are equal


class Opened(Protocol):
    """A lens with a pupil and a path difference over it."""

    @property
    def pupil(self) -> Pupil: ...  # noqa: D102 (above)

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64:
        """Return the path difference in waves at (x, y), in units of half the pupil's diameter."""
        ...


@kernel(allocates=True)
def overlaps(
    shifts: F64,
    angles: F64,
    opening: tuple[F64, float, float],
    paths: F64,
    waves: tuple[F64, I64],
    rule: tuple[F64, F64, F64, F64],
    out: C128,
    begin: int,
    stop: int,
) -> None:
    """Write ∫ exp(i(W(x − s/2) − W(x + s/2))) dx over the overlap into out (n, j), for the shifts s from begin to stop.

    shifts, angles : (n,) in half diameters, and their direction
    opening : normals of a polygon's sides (none: a circle of radius 1), its inner radius, radius of the obstruction
    paths   : (w, d + 1, d + 1) coefficients of x^a·y^b of path differences
    waves   : (j,) waves per unit of path, and the index of each wavelength's path difference
    rule    : nodes −cos u and their weights across a strip, Gauss nodes on 0 … 1 and weights along it
    """
    normals, inner, hole = opening
    per_path, which = waves
    spaced, slope, along, weight = rule
    degree = paths.shape[1] - 1
    cuts = np.empty((len(normals) + 2) * (len(normals) + 6) + 32)  # distances at which the overlap's boundary changes
    rotated, room = np.empty_like(paths), np.empty((degree + 1, degree + 1))
    u, v, path, other = np.empty((4, len(along)))
    real, imag = np.empty((len(per_path), len(along))), np.empty((len(per_path), len(along)))
    for n in range(begin, stop):
        s, angle = shifts[n], angles[n]
        cos, sin = math.cos(angle), math.sin(angle)
        real[:] = 0.0
        imag[:] = 0.0
        for w in range(len(paths)):
            _rotated(paths[w], cos, sin, rotated[w], room)
        count = _cuts(s, angle, normals, inner, hole, cuts)
        for cut in range(count - 1):
            low, high = cuts[cut], cuts[cut + 1]
            if high - low < 1e-13:
                continue
            for q in range(len(spaced)):
                t = 0.5 * (low + high) + 0.5 * (high - low) * spaced[q]
                of_line = 0.5 * (high - low) * slope[q]
                first, last = _chord(t, angle, normals, inner)
                half = math.sqrt(max(hole * hole - t * t, 0.0))
                parts = 2 if half > 0.0 else 1
                for a in range(parts):
                    for b in range(parts):
                        left_a = first if a == 0 else half
                        right_a = -half if a == 0 and parts == 2 else last
                        left_b = first if b == 0 else half
                        right_b = -half if b == 0 and parts == 2 else last
                        left = max(left_a - 0.5 * s, left_b + 0.5 * s)
                        length = min(right_a - 0.5 * s, right_b + 0.5 * s) - left
                        if length <= 0.0:
                            continue
                        before = -1
                        for p in range(len(along)):
                            u[p], v[p] = left + length * along[p] - 0.5 * s, left + length * along[p] + 0.5 * s
                        for j in range(len(per_path)):
                            if which[j] != before:
                                before = which[j]
                                path[:], other[:] = 0.0, 0.0
                                for k in range(degree, 0, -1):  # t is the same in both
                                    power = 0.0
                                    for m in range(degree - k, -1, -1):
                                        power = power * t + rotated[before, k, m]
                                    for p in range(len(along)):
                                        path[p], other[p] = (path[p] + power) * u[p], (other[p] + power) * v[p]
                            times, size = per_path[j], of_line * length
                            for p in range(len(along)):
                                c, d = turned((path[p] - other[p]) * times)
                                real[j, p] += size * weight[p] * c
                                imag[j, p] += size * weight[p] * d
        for j in range(len(per_path)):
            out[n, j] = complex(real[j].sum(), imag[j].sum())


@kernel()
def _rotated(terms: F64, cos: float, sin: float, out: F64, inner: F64) -> None:
    """Write Σ terms[a, b]·x^a·y^b, with a + b up to the degree, as powers of u and t.

    x + iy = (u + it)(cos + i·sin)
    """
    degree = len(terms) - 1
    out[:] = 0.0
    for a in range(degree, -1, -1):
        inner[:] = 0.0
        for b in range(degree - a, -1, -1):
            _times(inner, degree - a - b, sin, cos)
            inner[0, 0] += terms[a, b]
        _times(out, degree - a, cos, -sin)
        out += inner


@kernel()
def _times(powers: F64, degree: int, u: float, t: float) -> None:
    """Multiply a polynomial, of this degree afterwards, by a sum of u and t."""
    for i in range(degree, -1, -1):
        for j in range(degree - i, -1, -1):
            value = u * powers[i - 1, j] if i else 0.0
            powers[i, j] = value + t * powers[i, j - 1] if j else value


@kernel()
def _chord(t: float, angle: float, normals: F64, inner: float) -> tuple[float, float]:
    """Return where a line along ``angle``, at distance t from the centre, enters and leaves the outline."""
    if len(normals) == 0:
        half = math.sqrt(max(1.0 - t * t, 0.0))
        return -half, half
    first, last = -1e300, 1e300
    for k in range(len(normals)):
        along = math.cos(normals[k] - angle)
        bound = inner - t * math.sin(normals[k] - angle)
        if along > 1e-12:
            last = min(last, bound / along)
        elif along < -1e-12:
            first = max(first, bound / along)
    return min(first, last), last


@kernel()
def _cuts(s: float, angle: float, normals: F64, inner: float, hole: float, cuts: F64) -> int:
    """Write every distance from the centre at which ends of chords begin, end or meet, in order; return how many."""
    count, extent = 0, 1.0
    sides = len(normals)
    if sides:
        outer, extent = inner / math.cos(math.pi / sides), 0.0
        for k in range(sides):
            corner = outer * math.sin(normals[k] + math.pi / sides - angle)
            cuts[count] = corner
            extent = max(extent, abs(corner))
            count += 1
        for k in range(sides):
            along = math.cos(normals[k] - angle)
            if abs(along) <= 1e-12:
                continue
            c0, c1 = inner / along, -math.sin(normals[k] - angle) / along
            for m in range(sides):
                other = math.cos(normals[m] - angle)
                if abs(other) <= 1e-12:
                    continue
                d0, d1 = inner / other, -math.sin(normals[m] - angle) / other
                if abs(c1 - d1) > 1e-12:
                    cuts[count] = (s - c0 + d0) / (c1 - d1)
                    count += 1
            if hole > 0.0:
                for side in range(2):
                    level = c0 - s if side == 0 else c0 + s
                    middle, free = c1 * level / (1.0 + c1 * c1), (level * level - hole * hole) / (1.0 + c1 * c1)
                    if middle * middle > free:
                        root = math.sqrt(middle * middle - free)
                        cuts[count], cuts[count + 1] = -middle - root, -middle + root
                        count += 2
    else:
        count = _roots(1.0, 1.0, s, cuts, count)
        if hole > 0.0:
            count = _roots(hole, 1.0, s, cuts, count)
    if hole > 0.0:
        cuts[count], cuts[count + 1] = -hole, hole
        count = _roots(hole, hole, s, cuts, count + 2)
    # Sort them, without those outside.
    inside = 0
    for k in range(count):
        value = cuts[k]
        if abs(value) > extent:
            continue
        place = inside
        while place > 0 and cuts[place - 1] > value:
            cuts[place] = cuts[place - 1]
            place -= 1
        cuts[place] = value
        inside += 1
    return inside


@kernel()
def _roots(a: float, b: float, s: float, cuts: F64, count: int) -> int:
    """Add ±t at which √(b² − t²) ± √(a² − t²) = s, if there are any."""
    larger = 0.5 * (s + (b * b - a * a) / s) if s > 0.0 else 0.0
    if larger < b:
        root = math.sqrt(b * b - larger * larger)
        cuts[count], cuts[count + 1] = -root, root
        return count + 2
    return count


@dataclass(frozen=True, eq=False)
class Overlaps:
    """A pupil's overlaps with its shifted copies, at several wavelengths.

    paths_nm : (w, d + 1, d + 1) coefficients of x^a·y^b;  which: (j,) index of each wavelength's path difference
    symmetry_rad : angle of rotational symmetry, of a round wavefront: of a polygon; 0 of a circle; else π
    """

    lens: Opened
    wavelength_nm: F64
    paths_nm: F64
    which: I64
    symmetry_rad: float

    @property
    def revolves(self) -> bool:
        """Whether the transfer is rotationally symmetric."""
        return self.symmetry_rad == 0.0

    @property
    def panels(self) -> int:
        """Number of panels between directions of sides in half a turn; 0 for a circle."""
        pupil = self.lens.pupil
        if pupil.shape == "circular":
            return 0
        # Panels end in the directions of sides and of the corners of the transfer's border.
        return pupil.sides // 2 if pupil.sides % 4 == 2 else pupil.sides

    @property
    def first_rad(self) -> float:
        """Where the panels begin, radians: the largest boundary between panels that is at most −π/2; 0 for a circle."""
        if not self.panels:
            return 0.0
        along, width = next(iter(self.lens.pupil.normals())) + 0.5 * math.pi, math.pi / self.panels
        return along - width * math.ceil((along + 0.5 * math.pi) / width - 1e-12)

    @property
    def border(self) -> F64:
        """Vectors (panels, 2) normal to the transfer's border: the polygon of shifts at which two copies just touch."""
        pupil = self.lens.pupil
        corner = pupil.inner_radius / math.cos(math.pi / pupil.sides)
        near = 0.5 * (pupil.inner_radius + (corner if pupil.sides % 2 else pupil.inner_radius))
        apart = 2.0 * math.pi / (2 * pupil.sides if pupil.sides % 2 else pupil.sides)
        middle = self.first_rad + (math.pi / self.panels) * (np.arange(self.panels) + 0.5)
        first = next(iter(pupil.normals()))
        normal = first + apart * np.round((middle - first) / apart)
        return np.stack([np.cos(normal), np.sin(normal)], axis=1) / near

    def border_at(self, angle_rad: F64) -> F64:
        """Return the cut-off ρ in directions (n,)."""
        if not self.panels:
            return np.full(angle_rad.size, self.lens.pupil.outer_radius)
        place = np.floor((angle_rad - self.first_rad) * self.panels / np.pi).astype(np.int64)
        vector = self.border[place % self.panels] * np.where(place // self.panels % 2, -1.0, 1.0)[:, None]
        return 1.0 / (vector[:, 0] * np.cos(angle_rad) + vector[:, 1] * np.sin(angle_rad))

    @property
    def breaks(self) -> tuple[float, ...]:
        """Radii at which outlines of the opening begin or cease to intersect."""
        hole = self.lens.pupil.obstruction
        if self.lens.pupil.shape != "circular" or not hole:
            return 0.0, 1.0
        return tuple(sorted({0.0, hole, 0.5 - 0.5 * hole, 0.5 + 0.5 * hole, 1.0}))

    @classmethod
    def of(cls, lens: Opened, wavelength_nm: F64) -> Overlaps:
        """Express a wavefront as a polynomial and find its symmetry."""
        terms, degree = _polynomials(lens, wavelength_nm)
        same = [int(np.argmax(np.abs(terms[: k + 1] - one).max(axis=1) <= SAME_PATH)) for k, one in enumerate(terms)]
        distinct, which = np.unique(same, return_inverse=True)
        paths = np.zeros((distinct.size, degree + 1, degree + 1))
        for out, one in zip(paths, terms[distinct], strict=True):
            out[_powers(degree)] = one
        x = np.array([0.3, 0.7, 1.0])
        turned = [lens.waves(x * math.cos(a), x * math.sin(a), float(wavelength_nm[0])) for a in (0.0, 1.1, 2.9)]
        symmetry_rad = math.pi  # transfers at opposite directions are conjugate
        if float(np.ptp(turned, axis=0).max()) <= ROUNDING:
            symmetry_rad = 0.0 if lens.pupil.shape == "circular" else 2.0 * math.pi / lens.pupil.sides
        return cls(lens, wavelength_nm, paths, which.astype(np.int64), symmetry_rad)

    def __call__(self, rho: F64, angle: F64, nodes: I64) -> C128:
        """Return transfers (j, n) at ρ and directions (n,), computed once for equivalent directions.

        nodes : per axis of an overlap, at the fractions ``SHARES`` of the border's ρ; between two the larger
        """
        pupil = self.lens.pupil
        if 0.0 < self.symmetry_rad < math.pi:  # of a regular polygon: rotation, and reflection about its corners
            first = math.radians(pupil.rotate_deg) + (0.25 * math.pi if pupil.shape == "square" else 0.0)
            turned: F64 = np.remainder(angle - first, self.symmetry_rad)
            angle = np.asarray(first + np.round(np.minimum(turned, self.symmetry_rad - turned), DIGITS), np.float64)
        both, which = np.unique(np.round(rho, DIGITS) + 1j * angle, return_inverse=True)
        rho, angle = np.ascontiguousarray(both.real), np.ascontiguousarray(both.imag)
        plain = not self.paths_nm.any()  # the transfer is the same at all wavelengths then
        per_nm = 1.0 / (self.wavelength_nm[:1] if plain else self.wavelength_nm)
        out = np.empty((rho.size, per_nm.size), complex)
        normals = np.array([] if pupil.shape == "circular" else [*pupil.normals()], float)
        opening = normals, float(pupil.inner_radius), float(pupil.obstruction)
        waves, counts = (per_nm, self.which[: per_nm.size]), self.counts(rho, angle, nodes)
        for count in distinct(counts).tolist():
            one = np.flatnonzero(counts == count)
            found = np.empty((one.size, per_nm.size), complex)
            given = 2.0 * rho[one], angle[one], opening, self.paths_nm, waves, _rule(count), found
            shared(one.size, functools.partial(overlaps, *given), least=8)
            out[one] = found
        return np.broadcast_to(out[which].T / pupil.area, (self.wavelength_nm.size, which.size))

    def counts(self, rho: F64, angle_rad: F64, nodes: I64) -> I64:
        """Return the number of nodes per axis (n,) for each ρ and direction."""
        interval = np.searchsorted(SHARES, rho / self.border_at(angle_rad))
        counts: I64 = np.maximum(nodes[np.minimum(interval, nodes.size - 1)], nodes[np.maximum(interval - 1, 0)])
        return counts

    def nodes_for(self, allowed: float) -> I64:
        """Return how many nodes per axis suffice: 1.5 times as many change the result by at most ``allowed``."""
        rho, angle = (one.ravel() for one in np.meshgrid(SHARES, TRIED, indexing="ij"))
        rho = rho * self.border_at(angle)
        enough, nodes = np.zeros(SHARES.size, np.int64), FIRST_RULE
        before = self(rho, angle, np.full(SHARES.size, nodes))
        while True:
            more = math.ceil(1.5 * nodes)
            found = self(rho, angle, np.full(SHARES.size, more))
            off = np.abs(found - before).reshape(-1, SHARES.size, TRIED.size).max(axis=(0, 2))
            enough[(enough == 0) & (off <= allowed)] = nodes
            if enough.all():
                return enough
            if more > MOST_RULE:
                raise UnsupportedError(
                    f"the wavefront turns too fast to be integrated at {self.wavelength_nm.min():g} nm; "
                    "give fewer waves of aberration, or a larger tolerance",
                    key="lens",
                )
            nodes, before = more, found


def _powers(degree: int) -> tuple[I64, I64]:
    """Return the powers a and b of x and y with a + b up to the degree."""
    a, b = np.nonzero(np.add.outer(np.arange(degree + 1), np.arange(degree + 1)) <= degree)
    return a, b


def _polynomials(lens: Opened, wavelength_nm: F64) -> tuple[F64, int]:
    """Return coefficients (j, terms) of path differences in nm as polynomials, and their degree."""
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
    """Return nodes −cos u across a strip with their weights, and a Gauss rule on 0 … 1 along it."""
    x, w = gauss_legendre(nodes)
    u = 0.5 * np.pi * (1.0 + x)
    return -np.cos(u), 0.5 * np.pi * np.sin(u) * w, 0.5 * (1.0 + x), 0.5 * w
