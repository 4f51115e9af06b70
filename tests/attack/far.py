"""Scenery far away behind a circle with aberrations, given to a system in place of its own: wedges and half-planes.

What such a lens throws far comes by another road than what it throws near, and is left out of most systems: frames are
small, and what surrounds them is near. Outlines begin within some λN of a photosite, often on its centre, its border or
its corner, and end where a truth that follows powers of the distance takes them for endless.
"""

from __future__ import annotations

import math

import numpy as np

FAR = 4000  # seeds from here on, dates among them, draw them
BLUR = 0.3, 3.0
DIGITS = 4.0, 8.0
NEAR, ENDLESS = 20.0, (5.0, 7.0)  # λN, and powers of ten of them
WAVELENGTHS = 3
FULL = 4  # the order from which on waves fall as its square: spots of tens of λN, within what the truth sums up


def add_far(rng, system, surface):
    """Give a system such a lens, few photosites as a rule, and such scenery; ``surface``: what draws a reflectance."""
    blur = float(10.0 ** rng.uniform(*np.log10(BLUR)))
    rows, cols = (int(n) for n in rng.integers(1, int(rng.choice([4, 8, 30], p=[0.6, 0.25, 0.15])) + 1, 2))
    system["grid"] = {"rows": rows, "cols": cols, "origin": [0, 0], "frame": None}
    system["lens"] = {"kind": "wavefront", "blur": blur} | _wavefront(rng)
    system["tolerance"] = float(10.0 ** -rng.uniform(*DIGITS))
    count = min(len(system["wavelength_nm"]), WAVELENGTHS)
    system["wavelength_nm"] = system["wavelength_nm"][:count]
    system["response"] = [row[:count] for row in system["response"]]
    if rng.random() < 0.4:
        system |= {"photosite": {"kind": "point"}, "olpf": None}  # nothing but edges' own angles
    place = _corner(rng, rows, cols)
    shapes = []
    for draw in rng.choice([_star, _halves, _strip, _corners], 1 + int(rng.random() < 0.3), p=[0.35, 0.3, 0.15, 0.2]):
        shapes += draw(rng, place, blur)
    if rng.random() < 0.4:
        shapes += [_near(rng, place, blur) for _ in range(rng.integers(1, 4))]
    system["shapes"] = [{"kind": "polygon", "points": points, "reflectance": surface(rng)} for points in shapes]
    system["far"] = True


def _wavefront(rng):
    """A circle, some with a hole; one to three terms of orders to 8 or, where it is one, to 13."""
    count = int(rng.choice([1, 1, 2, 3]))
    highest = 13 if count == 1 else int(rng.choice([3, 4, 8]))
    indices = rng.integers(3, (highest + 1) * (highest + 2) // 2, count)
    strength = float(rng.choice([0.02, 0.1, 0.3]))
    hole = float(rng.uniform(0.05, 0.7)) if rng.random() < 0.2 else 0.0
    return {
        "pupil": {"shape": "circular", "obstruction": hole, "blades": 0, "rotate_deg": 0.0},
        "zernike_waves": [
            [index, float(min(1.0, (FULL / _order(index)) ** 2) * strength * rng.normal())]
            for index in sorted(set(indices.tolist()))
        ],
        "defocus_waves": float(rng.choice([0.0, 0.0, 0.3 * rng.normal()])),
    }


def _order(index):
    return int(0.5 * (math.sqrt(8.0 * index + 1.0) - 1.0))


def _corner(rng, rows, cols):
    """A place of the frame: a photosite's centre, a border or corner of one, or anywhere."""
    size = np.array([cols, rows])
    centre = rng.integers(0, size) + 0.5 - 0.5 * size
    off = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), rng.uniform(-0.5, 0.5, 2), rng.normal(0.0, 3.0, 2)]
    return centre + np.array(off[int(rng.choice(5, p=[0.35, 0.1, 0.15, 0.25, 0.15]))])


def _endless(rng, blur):
    return blur * 10.0 ** rng.uniform(*ENDLESS)


def _angle(rng):
    return math.radians(float(rng.choice([0.0, 45.0, 30.0, rng.uniform(0.0, 360.0)])))


def _towards(angle, reach):
    return reach * np.array([math.cos(angle), math.sin(angle)])


def _wedge(place, begin, turn, reach):
    """A triangle of less than half a turn, its tip at a place."""
    ends = [place + _towards(begin, reach), place + _towards(begin + turn, reach)]
    return [place.tolist(), *(end.tolist() for end in ends)]


def _star(rng, place, blur):
    """Wedges about a place, side by side or with as much between them."""
    count, begin, reach = int(rng.integers(2, 14)), _angle(rng), _endless(rng, blur)
    step = 2.0 * math.pi / count
    every = int(rng.choice([1, 2])) if count > 2 else 2
    turn = 0.5 * step if every == 2 else step
    return [_wedge(place, begin + k * step, turn, reach) for k in range(count)]


def _halves(rng, place, blur):
    """A half-plane, or a quarter of the plane and its opposite."""
    begin, reach = _angle(rng), _endless(rng, blur)
    if rng.random() < 0.3:
        return [_wedge(place, begin + turn, 0.5 * math.pi, reach) for turn in (0.0, math.pi)]
    out, along = _towards(begin, reach), _towards(begin + 0.5 * math.pi, reach * float(rng.uniform(0.5, 2.0)))
    return [[(place + p).tolist() for p in (-along, out - along, out + along, along)]]


def _strip(rng, place, blur):
    """An endless line, as wide as a blur or ten of them."""
    begin, reach, width = _angle(rng), _endless(rng, blur), blur * 10.0 ** rng.uniform(-1.0, 1.0)
    along, across = _towards(begin, reach), _towards(begin + 0.5 * math.pi, width)
    back = float(rng.choice([0.0, 1.0]))
    return [[(place + p).tolist() for p in (-back * along, along, along + across, -back * along + across)]]


def _corners(rng, place, blur):
    """Wedges that begin some λN away from each other."""
    count = int(rng.integers(1, 5))
    return [
        _wedge(
            place + rng.normal(0.0, 0.3 * NEAR * blur, 2),
            _angle(rng),
            float(rng.uniform(0.02, 3.0)),
            _endless(rng, blur),
        )
        for _ in range(count)
    ]


def _near(rng, place, blur):
    """A triangle or a square of some λN, beside the frame's place or over it."""
    count, size = int(rng.integers(3, 5)), blur * float(rng.uniform(0.5, NEAR))
    angles = _angle(rng) + 2.0 * math.pi * np.arange(count) / count
    middle = place + rng.normal(0.0, 0.5 * NEAR * blur, 2)
    return [(middle + _towards(angle, size)).tolist() for angle in angles]
