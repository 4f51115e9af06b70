"""Records of outlines that the check takes into its kernels, whose keys have all that their modules import."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64


class Outlines(NamedTuple):
    """Straight and round parts of outlines, fill by fill and loop by loop.

    x, y, dx, dy : start and vector to the end of a straight part; of a round one its centre, and (radius, 0)
    from_rad, turn_rad : of a round part, the angle at which it begins and how far it goes, below 0 the other way round;
                   a turn of 0 is straight
    """

    x: F64
    y: F64
    dx: F64
    dy: F64
    from_rad: F64
    turn_rad: F64

    def some(self, which: I64 | np.ndarray) -> Outlines:
        """Return picked ones."""
        return Outlines(*(column[which] for column in self))

    @property
    def length(self) -> F64:
        """Of each (n,)."""
        length: F64 = np.where(self.turn_rad == 0.0, np.hypot(self.dx, self.dy), self.dx * np.abs(self.turn_rad))
        return length


class Owners(NamedTuple):
    """Whose each part is: parts of fills, fills of layers, layers of primitives, each where the next begins.

    even_odd : (fills,) whether it is filled where a place is wound about an odd number of times
    ends     : (n, 4) x, y where each part begins and where it ends: the very numbers with which the next one begins
    """

    part: I64
    fill: I64
    layer: I64
    even_odd: np.ndarray
    ends: F64

    @property
    def primitive(self) -> I64:
        """Of each part (n,)."""
        first = self.part[self.fill[self.layer]]
        return np.repeat(np.arange(len(first) - 1), np.diff(first))


class Bent(NamedTuple):
    """Bézier curves as polynomials of t from −1 to 1; see ``parts.bent``.

    of     : (pieces,) which of them each piece is, −1 for none
    terms  : (m, 10) x and y of the four coefficients, and distances from which on eight and four nodes do
    order  : (m,) nodes that follow the shortest wave along each
    rules  : (n, 2, most) Gauss rules of 0, 1, 2 … nodes
    """

    of: I64
    terms: F64
    order: I64
    rules: F64


class Parts(NamedTuple):
    """What is to be known of each piece besides its outline."""

    sides: I64  # which two spectra lie beside it
    times: F64  # what their difference is to be multiplied by
    about: F64  # (n, 3) its middle, and half its length: a circle that it lies in
    bent: Bent

    @property
    def longest_curve(self) -> float:
        """No Bézier curve is longer."""
        return 2.0 * float(self.about[self.bent.of >= 0, 2].max(initial=0.0))

    def gaps(self, points: F64) -> F64:
        """Return how far (points, pieces) all of each piece lies at least from points (m, 2)."""
        x, y, half = self.about.T
        gaps: F64 = np.hypot(points[:, :1] - x, points[:, 1:] - y) - half
        return gaps
