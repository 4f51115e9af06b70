"""How many nodes an integral over a pupil takes along lines: for waves, and for the wavefront besides.

What waves take is known (``even_rule``): so many for each radian that they turn, and a few. What the wavefront takes is
not worked out: more are taken until integrals along lines stay the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from camsim.arrays import F64
from camsim.errors import UnsupportedError
from camsim.quadrature import even_place, even_rule

PER_RADIAN = 0.17  # nodes that a wave takes, of all that it turns from end to end
SPARE, GROWTH, MOST_SPARE = 28, 1.25, 8000  # besides: of a wave alone 23
SLOW_RAD, FAST_RAD = 6.0, 400.0  # waves with which the wavefront's integrals settle, by as many nodes as each takes
SETTLED = 1e-12
ROUNDING = 2.0**-52  # of a phase, relative: a tenth of that was seen in the coefficients


def from_0(order: int) -> tuple[F64, F64]:
    """Return nodes on 0 … 1 and weights of a rule for waves."""
    nodes, weights = even_rule(order)
    return 0.5 * (1.0 + nodes), 0.5 * weights


def reached(order: int, count: int) -> float:
    """Return where on 0 … 1 so many of a rule's nodes end."""
    return 0.5 * (1.0 + even_place(order, count))


def nodes_of(turned_rad: float, spare: float) -> int:
    """Return how many nodes waves take that turn by so much, with so many to spare: a hundredth more at most.

    Rules for the next wavelength are often the same ones.
    """
    least = PER_RADIAN * turned_rad + spare
    step = max(1, int(least) >> 7)
    return step * math.ceil(least / step)


def spare_nodes(waves: Callable[[F64], F64], wavelength_nm: float, along: str) -> list[int]:
    """Return how many nodes a wavefront takes along lines besides those of waves, for each of some sets of lines.

    waves : path differences (sets, lines, n), waves, at places 0 … 1 along each line;  along: what lines these are
    """

    def integrals(spare: float) -> tuple[F64, F64]:
        """Return those of each set with so many nodes to spare, and what rounding hides of them."""
        rules = [(turn_rad, *from_0(nodes_of(turn_rad, spare))) for turn_rad in (SLOW_RAD, FAST_RAD)]
        phase = 2.0 * np.pi * waves(np.concatenate([t for _, t, _ in rules]))
        factor, first, found = np.exp(1j * phase), 0, []
        for turn_rad, t, weights in rules:
            own, first = factor[..., first : first + t.size] * weights, first + t.size
            # BLAS would wake threads, which spin on cores that a frame's other places want.
            found += [np.einsum("sln,n->sl", own, np.exp(sign * 1j * turn_rad * t)) for sign in (1.0, -1.0)]
        # The corners of a square are 2^(n/2) times as far off as its rim: what 1000 radians are rounded to shows.
        hidden = np.maximum(SETTLED, ROUNDING * np.abs(phase).max(axis=(1, 2)))
        return np.stack(found, axis=-1).reshape(len(phase), -1), hidden

    spare, (before, _) = float(SPARE), integrals(SPARE)
    enough = np.zeros(len(before), int)
    while (spare := GROWTH * spare) <= MOST_SPARE:
        values, hidden = integrals(spare)
        settled = np.abs(values - before).max(axis=1) <= hidden
        enough[settled & (enough == 0)] = math.ceil(spare)
        if enough.all():
            return [int(nodes) for nodes in enough]
        before = values
    raise not_followed(wavelength_nm, f"along {along} of the pupil", MOST_SPARE)


def not_followed(wavelength_nm: float, where: str, points: int) -> UnsupportedError:
    """Return the error of a wavefront that so many points do not follow."""
    return UnsupportedError(
        f"the wavefront has too many waves at {wavelength_nm:g} nm to be sampled {where} "
        f"({points} points do not follow it); give smaller coefficients",
        key="zernike_waves",
    )
