"""What the check's integrals are to know of each piece of an outline: what lies beside it, and how it bends."""

from __future__ import annotations

import functools
import math

import numpy as np

from camsim.arrays import F64, I64
from camsim.quadrature import gauss_phases, gauss_rules
from camsim.rendering.check.along import SHORT
from camsim.rendering.check.beziers import polynomials
from camsim.rendering.check.points import MOST_NODES
from camsim.rendering.check.records import Bent, Parts
from camsim.rendering.check.scenery import Pieces

LEAST_NODES = 4


def parts_seen(pieces: Pieces, sides: I64, times: F64, blur: float, allowed: float) -> Parts:
    """Collect it; blur, allowed: as for ``rules_of``."""
    o = pieces.outlines
    straight, middle = o.turn_rad == 0.0, o.from_rad + 0.5 * o.turn_rad
    x = o.x + np.where(straight, 0.5 * o.dx, o.dx * np.cos(middle))
    y = o.y + np.where(straight, 0.5 * o.dy, o.dx * np.sin(middle))
    about = np.stack([x, y, 0.5 * o.length], axis=1)
    curves = np.flatnonzero(pieces.bezier >= 0)
    if curves.size:
        centre, *more = polynomials(pieces.curves[pieces.bezier[curves]]).T
        about[curves] = np.stack([centre.real, centre.imag, sum(np.abs(part) for part in more)], axis=1)
    return Parts(sides, times, about, bent(pieces, blur, allowed))


def bent(pieces: Pieces, blur: float, allowed: float) -> Bent:
    """Return the pieces' Bézier curves, and how many nodes leave so much of the shortest wave along them.

    With |t| ≤ a in an ellipse whose half axes add up to ρ, a wave e^{2πif·P(t)} is there no larger than it is along a
    straight line of half the length |c₁| + 2a|c₂| + 3a²|c₃|; of a phase φ, n nodes leave the least by the ellipse with
    a = 2n/φ. Far away E/r² has no pole in the ellipse while |P(t) − c₀| stays below the distance: of 8 nodes a = 4, of
    four 33, as for a straight piece.
    """
    c = polynomials(pieces.curves)
    size = np.abs(c)
    phases = gauss_phases(allowed, MOST_NODES)
    order = np.full(len(c), MOST_NODES)
    for n in range(MOST_NODES, LEAST_NODES - 1, -1) if len(c) else ():
        a = 2.0 * n / phases[n - 1]
        phase = 2.0 * math.pi / blur * (size[:, 1] + 2.0 * a * size[:, 2] + 3.0 * a * a * size[:, 3])
        order[phase <= phases[n - 1]] = n
    farther = [(size[:, 1] + size[:, 2] / short + size[:, 3] / short**2) / short for _, short in SHORT]
    terms = np.concatenate([np.stack([c.real, c.imag], axis=2).reshape(-1, 8), np.stack(farther, axis=1)], axis=1)
    return Bent(pieces.bezier, terms, order, _rules())


@functools.cache
def _rules() -> F64:
    """Return Gauss rules (n, 2, most) of 0, 1 … MOST_NODES nodes, read-only."""
    rules = np.stack(gauss_rules(tuple(range(MOST_NODES + 1)))[:2], axis=1)
    rules.flags.writeable = False
    return rules
