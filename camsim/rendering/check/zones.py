"""Averages over a photosite: few points do for what is far away, whose light is smooth over it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64

LEAST_RHO = 3.0  # of an ellipse that holds at D: nearer than that the near rule is taken
FAR_PART = 0.1  # of what the averages may be wrong by: for what is far away

Rule = tuple[F64, F64]


class Zones(NamedTuple):
    """Rules for what is near and for what is farther and farther away.

    begin : (n,) distances from which on each is used, pitches;  rules: (n,) nodes (m, 2) and weights (m,) of each
    """

    begin: F64
    rules: list[Rule]

    def ends(self, nearest: F64) -> F64:
        """Return where each begins and the last one ends (n + 1, points): all but the first lie beyond ``nearest``."""
        begin = np.maximum(self.begin[:, None], nearest)
        begin[0] = -np.inf
        return np.concatenate([begin, np.full((1, len(nearest)), np.inf)])


def zones_of(rule: Callable[[int], Rule], *, order: int, half: float, light: float, allowed: float) -> Zones:
    """Choose them.

    rule    : of so many nodes along a side, ``order`` of them for what is near;  half: of the longer side, pitches
    light   : Σ contrast × length/(2π × distance) over the pieces of outlines, what they give at the most
    allowed : what all but the first rule may leave

    Light from a distance D or more is analytic as far as D about the photosite, off the real axes too, and half as far
    at most twice as large. In an ellipse about the side whose half axes add up to ρ sides' halves, D/2 the longer one,
    n nodes then leave no more than (64/15)·2·light·ρ^{−2n}/(1 − ρ^{−2}), and twice that in two dimensions.
    """
    begin, rules = [-np.inf], [rule(order)]
    # More nodes than these do from where the ellipse begins to hold.
    most = math.ceil(0.5 * math.log(max(20.0 * light / allowed, 1.0)) / math.log(LEAST_RHO))
    for nodes in range(min(order - 1, max(most, 1)), 0, -1):
        rho = max(LEAST_RHO, (20.0 * light / allowed) ** (0.5 / nodes))
        begin.append(half * (rho + 1.0 / rho))
        rules.append(rule(nodes))
    return Zones(np.array(begin), rules)
