"""OTFs of pupils at many frequencies: integrals over the overlap of two shifted copies of the pupil."""

from __future__ import annotations

import math

import numpy as np

from camsim.core.arrays import C128, F64, I64
from camsim.core.kernels import kernel
from camsim.core.kernels.turning import turned


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
    """Write ∫ exp(i(W(x − s/2) − W(x + s/2))) dx over the overlap for shifts s begin … stop: out (n, j).

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
    kept = 0
    for k in range(count):
        value = cuts[k]
        if abs(value) > extent:
            continue
        place = kept
        while place > 0 and cuts[place - 1] > value:
            cuts[place] = cuts[place - 1]
            place -= 1
        cuts[place] = value
        kept += 1
    return kept


@kernel()
def _roots(a: float, b: float, s: float, cuts: F64, count: int) -> int:
    """Add ±t at which √(b² − t²) ± √(a² − t²) = s, if there are any."""
    larger = 0.5 * (s + (b * b - a * a) / s) if s > 0.0 else 0.0
    if larger < b:
        root = math.sqrt(b * b - larger * larger)
        cuts[count], cuts[count + 1] = -root, root
        return count + 2
    return count
