"""Light about a window, ready to be transformed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from camsim.arrays import F64


class Lattice(NamedTuple):
    """Splines on a lattice along the photosites' rows."""

    light: F64  # (planes, rows, cols), row 0 at the top
    first: tuple[float, float]  # where the first of them is, pitches from an origin
    step: float
    degree: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Samples:
    """A layer about a window; lengths in pitches from an origin.

    lattice   : the kept splines, where they are wanted as that, or None
    places    : (n, 2) of the kept splines;  strengths: (planes, n) their light
    points    : (m, 2) of what they get wrong;  corrections: (planes, m) light
    step, degree, axes : of the splines
    """

    lattice: Lattice | None
    places: F64
    strengths: F64
    points: F64
    corrections: F64
    step: float
    degree: int
    axes: F64
