"""How many nodes an integral over a pupil takes along lines: for waves, and for the wavefront besides.

What waves take is known (``even_rule``): so many for each radian that they turn, and a few. What the wavefront takes is
not worked out: more are taken until integrals along lines stay the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.errors import UnsupportedError
from camsim.quadrature import even_count, even_rule

PER_RADIAN = 0.17  # nodes that a wave takes, of all that it turns from end to end
SPARE, GROWTH = 28, 1.25  # besides: of a wave alone 23
SLOW_RAD, FAST_RAD = 6.0, 400.0  # waves with which the wavefront's integrals settle, by as many nodes as each takes
SETTLED = 1e-12
TURN = 0.9  # of a whole turn between two nodes, where integrals settle at the very earliest
ROUNDING = 2.0**-52  # of a phase, relative: a tenth of that was seen in the coefficients


class Turns(NamedTuple):
    """By how much waves turn on half of the diameter along x and along y, radians: all of a rectangle's.

    x, y : of its corners, from its middle;  middle_rad: what the wave in its middle turns, along x and along y
    """

    x: float
    y: float
    middle_rad: tuple[float, float] = (0.0, 0.0)

    def along(self, x: F64, y: F64) -> F64:
        """Return how much any of them turns at most on the way (x, y)."""
        most: F64 = np.abs(self.middle_rad[0] * x + self.middle_rad[1] * y) + self.x * np.abs(x) + self.y * np.abs(y)
        return most

    @property
    def most(self) -> tuple[float, float]:
        """What any of them turns at most along x, and along y."""
        return abs(self.middle_rad[0]) + self.x, abs(self.middle_rad[1]) + self.y

    @property
    def largest(self) -> float:
        """What any of them turns on half of the diameter in any direction."""
        return math.hypot(*self.most)


def from_0(order: int) -> tuple[F64, F64]:
    """Return nodes on 0 … 1 and weights of a rule for waves."""
    nodes, weights = even_rule(order)
    return 0.5 * (1.0 + nodes), 0.5 * weights


def nodes_before(order: I64 | int, place: F64) -> I64:
    """Return how many of a rule's nodes on 0 … 1 lie before a place."""
    return even_count(order, 2.0 * place - 1.0)


def nodes_of(turned_rad: F64 | float, spare: I64 | float) -> I64:
    """Return how many nodes waves take that turn by so much, with so many to spare: a hundredth more at most.

    Rules for the next wavelength are often the same ones.
    """
    least = np.asarray(PER_RADIAN * turned_rad + spare)
    step = np.maximum(1, least.astype(np.int64) >> 7)
    nodes: I64 = step * np.ceil(least / step).astype(np.int64)
    return nodes


def spare_nodes(waves: Callable[[F64, I64], F64], length: F64, most: float) -> I64:
    """Return how many nodes a wavefront takes along lines besides those of waves, for each of some sets of lines.

    waves   : path differences (sets, lines, n), waves, at places 0 … 1 along each line of some sets, given by number
    length  : (sets,) of the lines, in about half diameters: what places are rounded to shows in steep phases
    returns : (sets,) up to ``most``, 0 where it takes more
    """

    def integrals(spare: float, some: I64) -> tuple[C128, F64, F64]:
        """Return those of sets with so many to spare, what rounding hides of them, and what these take at least."""
        rules = [(turn_rad, *from_0(int(nodes_of(turn_rad, spare)))) for turn_rad in (SLOW_RAD, FAST_RAD)]
        phase = 2.0 * np.pi * waves(np.concatenate([t for _, t, _ in rules]), some)
        factor, first, found = np.exp(1j * phase), 0, []
        for turn_rad, t, weights in rules:
            own, first = factor[..., first : first + t.size] * weights, first + t.size
            # BLAS would wake threads, which spin on cores that a frame's other places want.
            found += [np.einsum("sln,n->sl", own, np.exp(sign * 1j * turn_rad * t)) for sign in (1.0, -1.0)]
        # The corners of a square are 2^(n/2) times as far off as its rim: what 1000 radians are rounded to shows, and
        # what their places are.
        _, t, _ = rules[0]
        step = np.abs(np.diff(phase[..., : t.size]))
        steepest = (step / np.diff(t)).max(axis=(1, 2)) / length[some]
        hidden = np.maximum(SETTLED, ROUNDING * (np.abs(phase).max(axis=(1, 2)) + steepest))
        # A phase that turns once from one node to the next is no other than one that does not turn.
        least = TURN * t.size * step.max(axis=(1, 2)) / (2.0 * np.pi) - PER_RADIAN * SLOW_RAD
        return np.stack(found, axis=-1).reshape(len(phase), -1), hidden, least

    enough, least, spare = np.zeros(len(length), np.int64), np.zeros(len(length)), float(SPARE)
    left, before = np.arange(len(length)), np.full((len(length), 1), np.nan, complex)
    while left.size and spare <= most:
        some = left[least[left] <= GROWTH * spare]  # what takes more than the next try gives is not tried now
        if some.size:
            values, hidden, least[some] = integrals(spare, some)
            enough[some[np.abs(values - before[some]).max(axis=1) <= hidden]] = math.ceil(spare)
            before = np.full((len(length), values.shape[1]), np.nan, complex)
            before[some] = values
        left = left[(enough[left] == 0) & (least[left] <= most)]
        spare *= GROWTH
    return enough


def not_followed(wavelength_nm: float, where: str, most: str) -> UnsupportedError:
    """Return the error of a wavefront that is not followed with the most that is tried, a number and of what."""
    return UnsupportedError(
        f"the wavefront has too many waves at {wavelength_nm:g} nm to be sampled {where} "
        f"({most} do not follow it); give smaller coefficients",
        key="zernike_waves",
    )
