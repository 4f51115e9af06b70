"""A lens that changes over the frame: every photosite by sums over the pupil of its own place (``waves.py``).

Tables are followed by B-splines; Zernikes are turned by their trigonometric definition; what is seen of the scene
(``picture.py``) is cut where nothing is bent, and every piece is bent at its nodes.
Nothing of camsim is imported. Lengths in pitches.
"""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
from scipy import interpolate, optimize

from tests.truth import waves

CIRCLE = {"shape": "circular", "obstruction": 0.0}


class PlacedTruth:
    """What single photosites see.

    lens   : f-number as ``blur`` (λN at ``reference_nm``), wavelength_nm, zernike, waves, and heights with distortion
             or distortion_powers, lateral (wavelengths, heights) and illumination, or x and y
    pieces : from ``picture.pieces`` of the scene without distortion;  jumps, photosite, olpf: as in ``WaveTruth``
    nm     : wavelengths of jumps;  digits: as in ``WaveTruth``
    """

    def __init__(self, lens, pieces, jumps, photosite, olpf, *, nm, reference_nm, digits=waves.DIGITS):
        self.digits = digits
        self.lens, self.pieces, self.jumps, self.photosite, self.olpf = lens, pieces, jumps, photosite, olpf
        self.nm, self.reference_nm = nm, reference_nm

    def value(self, place):
        """Light of a photosite at a place of the frame, less the background's, and its error."""
        values, error = self._of(place).values(np.zeros(1), np.zeros(1))
        return float(values[0, 0]), error

    def cost(self, place):
        """Seconds that a value takes, about."""
        return self._of(place).cost(np.zeros(1), np.zeros(1))

    def _of(self, place):
        place = np.array(place, float)
        seen = [fallen(piece, self.lens, place) for piece in self.pieces]
        return waves.WaveTruth(seen, self.openings(place), self.jumps, self.photosite, self.olpf, digits=self.digits)

    def openings(self, place):
        """The pupil at a place, at every wavelength."""
        lens, found = self.lens, []
        for nm in self.nm:
            one = {"pupil": CIRCLE, "reference_nm": nm, "f_number": 1.0, "defocus_um": 0.0}
            one |= {"zernike_waves": zernikes(lens, place, nm, self.reference_nm)}
            found.append(waves.Opening(one | {"blur": lens["blur"] / self.reference_nm}, nm))
        return found


def zernikes(lens, place, nm, reference_nm):
    """Coefficients in waves at a place: [(index, waves)]."""
    known = np.array(lens["wavelength_nm"])
    table = np.array(lens["waves"]) * known.reshape(-1, *(1,) * (np.ndim(lens["waves"]) - 1))
    paths = _spline(known, table, nm) / nm  # waves: (heights, k), or (y, x, k)
    if "heights" not in lens:
        one = _spline(lens["x"], _spline(lens["y"], paths, place[1]), place[0])
        return list(zip(lens["zernike"], one.tolist(), strict=True))
    height, angle = math.hypot(*place), math.atan2(place[1], place[0])
    along = [
        (index, _about_the_axis(lens, paths[:, k], height, order(index))) for k, index in enumerate(lens["zernike"])
    ]
    if lens.get("lateral"):
        # A plane of path across the pupil of so many waves at its rim, ±1, moves light by 2λN each; Zernike 2 is 2·x.
        moved = _about_the_axis(lens, _spline(known, np.array(lens["lateral"]), nm), height, 1)
        along.append((2, moved / (4.0 * lens["blur"] * nm / reference_nm)))
    found = []
    for index, one in along:
        # cos m(θ − φ) = cos mφ·cos mθ + sin mφ·sin mθ; the one with the sine has the index of m less
        m = order(index)
        found.append((index, one * math.cos(m * angle)))
        if m:
            found.append((index - m, one * math.sin(m * angle)))
    return found


def illumination(lens, place):
    """Light at a place over that on the axis."""
    if not lens.get("illumination"):
        return 1.0
    return float(_about_the_axis(lens, np.array(lens["illumination"]), math.hypot(*place), 0))


def fallen(piece, lens, place):
    """A piece of the scene as it falls, about a place."""
    if lens.get("distortion") or lens.get("distortion_powers"):
        return waves.Mapped(piece, lambda places, steps: _distorted(lens, place, places, steps))
    start, end = (tuple(np.array(p) - place) for p in (piece.start, piece.end))
    centre = None if piece.centre is None else tuple(np.array(piece.centre) - place)
    return dataclasses.replace(piece, start=start, end=end, centre=centre)


def falls(lens, height):
    """Where what would fall at heights falls, and how fast that moves with them; beyond what is told straight on."""
    height = np.asarray(height, float)
    last = lens["heights"][-1]
    inside = np.minimum(height, last * _stated(tuple(lens.get("distortion_powers") or ())))
    if lens.get("distortion"):
        one = _both_sides(lens["heights"], np.array(lens["distortion"]), 0)
        share, slope = one(inside), one.derivative()(inside)
    elif lens.get("distortion_powers"):
        u = inside / last
        share = sum(k * u ** (2 * n) for n, k in enumerate(lens["distortion_powers"], 1))
        slope = sum(2 * n * k * u ** (2 * n - 1) for n, k in enumerate(lens["distortion_powers"], 1)) / last
    else:
        return height, np.ones_like(height)
    slope = 1.0 + share + inside * slope
    return inside * (1.0 + share) + slope * (height - inside), slope


@functools.cache
def _stated(powers):
    """How many heights far a polynomial is followed: until it is half as steep as at the last, to 2 at most."""
    if not powers:
        return 1.0

    def steep(u):
        return 1.0 + sum((2 * n + 1) * k * u ** (2 * n) for n, k in enumerate(powers, 1))

    u = np.linspace(1.0, 2.0, 100_001)
    flat = np.flatnonzero(steep(u) <= 0.5 * steep(1.0))
    return 2.0 if not flat.size else optimize.brentq(lambda v: steep(v) - 0.5 * steep(1.0), 1.0, u[flat[0]], xtol=1e-15)


def _distorted(lens, origin, places, steps):
    """Places (n, 2) moved along their radius and taken from an origin, and the steps there."""
    height = np.hypot(*places.T)
    fallen_at, slope = falls(lens, height)
    out = places / np.where(height > 0.0, height, 1.0)[:, None]
    times = np.where(height > 0.0, fallen_at / np.where(height > 0.0, height, 1.0), slope)
    outward = np.sum(steps * out, axis=1)
    moved = times[:, None] * steps + ((slope - times) * outward)[:, None] * out
    return times[:, None] * places - origin, moved


def order(index):
    """How often a Zernike goes round: above 0 as cosines, below as sines."""
    n = 0
    while (n + 1) * (n + 2) // 2 <= index:
        n += 1
    return 2 * (index - n * (n + 1) // 2) - n


def _about_the_axis(lens, values, height, m):
    """A harmonic's value at a height: from order 3 on a spline goes through what is left over the square."""
    if m < 3:
        return _both_sides(lens["heights"], values, m)(height)
    left = [0.0] + [value / place**2 for place, value in zip(lens["heights"][1:], values[1:], strict=True)]
    return height**2 * _both_sides(lens["heights"], np.array(left), m)(height)


def _both_sides(heights, values, m):
    """A spline through values at heights and beyond the axis, oddly where m is odd."""
    heights = np.array(heights)
    return _maker(np.concatenate([-heights[:0:-1], heights]), np.concatenate([(-1.0) ** m * values[:0:-1], values]))


def _spline(places, values, at):
    return values[0] if len(places) == 1 else _maker(np.array(places), values)(at)


def _maker(places, values):
    return interpolate.make_interp_spline(places, values, k=min(3, len(places) - 1))
