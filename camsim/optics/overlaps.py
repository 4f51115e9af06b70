"""Transfers of pupils at many frequencies: integrals over what two shifted copies of the opening have in common."""

from __future__ import annotations

import math

from camsim.arrays import C128, F64, I64
from camsim.kernels import kernel


@kernel()
def overlaps(
    shifts: F64,
    angles: F64,
    opening: tuple[F64, float, float],
    paths: F64,
    waves: tuple[F64, I64],
    rule: tuple[F64, F64, F64, F64],
    cuts: F64,
    out: C128,
    begin: int,
    stop: int,
) -> None:
    """Write ∫ exp(i(W(x − s/2) − W(x + s/2))) dx over the overlap for shifts s begin … stop: out (n, j).

    shifts, angles : (n,) in half diameters, and their direction
    opening : directions of a polygon's sides (none: a circle of radius 1), its inner radius, radius of the obstruction
    paths   : (w, d + 1, d + 1) coefficients of x^a·y^b of path differences
    waves   : (j,) radians per unit of path, and which path difference each wavelength has
    rule    : places −cos u and their weights across a strip, Gauss nodes on 0 … 1 and weights along it
    cuts    : (m,) room for the distances at which the overlap's boundary changes
    """
    normals, inner, hole = opening
    radians, which = waves
    spaced, slope, along, weight = rule
    for n in range(begin, stop):
        s, angle = shifts[n], angles[n]
        cos, sin = math.cos(angle), math.sin(angle)
        for j in range(len(radians)):
            out[n, j] = 0.0
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
                        for p in range(len(along)):
                            u = left + length * along[p]
                            own = of_line * length * weight[p]
                            before = -1
                            path = 0.0
                            for j in range(len(radians)):
                                if which[j] != before:
                                    before = which[j]
                                    path = _path(
                                        paths[before], (u - 0.5 * s) * cos - t * sin, (u - 0.5 * s) * sin + t * cos
                                    )
                                    path -= _path(
                                        paths[before], (u + 0.5 * s) * cos - t * sin, (u + 0.5 * s) * sin + t * cos
                                    )
                                phase = path * radians[j]
                                out[n, j] += complex(own * math.cos(phase), own * math.sin(phase))


@kernel()
def _path(terms: F64, x: float, y: float) -> float:
    """Return Σ terms[a, b]·x^a·y^b, a + b no more than the degree."""
    degree = len(terms) - 1
    total = 0.0
    for a in range(degree, -1, -1):
        inner = 0.0
        for b in range(degree - a, -1, -1):
            inner = inner * y + terms[a, b]
        total = total * x + inner
    return total


@kernel()
def _chord(t: float, angle: float, normals: F64, inner: float) -> tuple[float, float]:
    """Return where a line along ``angle``, t beside the middle, enters and leaves the outline."""
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
    """Write every distance from the middle at which ends of chords begin, end or meet, in order; return how many."""
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
    # In order, those outside left out.
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
