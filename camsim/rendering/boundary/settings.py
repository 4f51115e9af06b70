"""The boundary engine's settings, chosen from the tolerance by an error model before anything is computed.

Every source of error has its share of the tolerance (budget.py); amplitudes are for a contrast of 1:

* The far form neglects ringing, which oscillates with cos(2πr/λN). An end at distance R has at most
  (λN/R)^{5/2}·D/(4π⁴), D the footprint's transfer at 1/λN; a whole line twice that. The wavelengths of a spectrum add
  up as phasors, with the sign of D; many corners (or lines) near one photosite add up with random phases, so their
  share falls with the root of their number.
* The footprint's moments end at the sixth: the next are |Mₙ|/(2πnRⁿ), n = 8, 10 …, and about 3·c1·M6/(2π R⁷).
* The eight-point look-up in the field and the six-point one in a line's response: `_step`.
* The Gauss rule on panels along an edge: `_panel_nodes`.
* Chebyshev interpolation over a tile: ρ⁻ⁿ/(πn) with ρ = κ + √(1 + κ²) for the angle of an edge κ half-widths away.
* Edges of length s at a distance R that are taken as short: their angles lack (s/R)⁵/5 each, and a ring of them has
  2πR/s.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from camsim.errors import InvalidValueError
from camsim.numerics.quadrature import EIGHT_POINTS, SIX_POINTS, gauss_error
from camsim.optics.pattern import Pattern
from camsim.rendering.boundary.coherence import Waves
from camsim.rendering.boundary.ringing import reach_of_ringing
from camsim.rendering.footprint import Footprint
from camsim.rendering.job import Job

COARSEST = 1e-2  # the contract's: the bounds below are of small errors
SEPARATION = 2.0  # half-widths of a tile: least distance of a source that is interpolated over it
PANEL_BLURS = 1.6  # λN: length of a panel that ``panel_nodes`` integrate along an edge
LONGEST_PIECE, LENGTHS = 6.4, 64  # λN: longest piece of one Gauss rule near an end; number of rules up to it
OF_PIECES = 16.0  # bound for pieces over the allowed error
OF_BRIEF = 0.1  # of the tiles' share, for edges that are short for their distance
COARSEST_FIELD, COARSEST_RESPONSE = 0.3, 0.15  # largest steps, λN, for which the error's leading terms hold to a tenth
LARGEST_LEAF = 16  # side of the smallest tiles, photosites; a smaller frame is one tile


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Settings of one boundary rendering; lengths in pitches.

    near    : an end is integrated within this distance; beyond, its ringing is neglected
    reach   : a line's response is looked up within this distance; beyond, its ringing is neglected
    brief   : distance from which an edge is short, over its length
    leaf    : side of the smallest tiles, photosites;  tile_nodes: Chebyshev nodes along any tile
    """

    tolerance: float
    near: float
    reach: float
    field_step: float
    response_step: float
    panel: float
    panel_nodes: int
    piece_nodes: tuple[int, ...]
    tile_nodes: int
    brief: float
    leaf: int
    separation: float = SEPARATION

    @property
    def shortest(self) -> float:
        """The shortest λN, pitches."""
        return self.panel / PANEL_BLURS


def check_tolerance(tolerance: float, pattern: Pattern, part: float = 1.0) -> None:
    """Refuse a tolerance outside the engine's range; part: share of the tolerance for the pattern."""
    finest = pattern.finest / part
    if not finest <= tolerance <= COARSEST:
        raise InvalidValueError(
            f"{tolerance:g} is outside {finest:g} … {COARSEST:g}, what this lens can be rendered to",
            key="tolerance",
        )


def plan_boundary(job: Job, pattern: Pattern, footprint: Footprint) -> Settings:
    """Choose the settings for the job's pattern and for its footprint, or a part of that."""
    check_tolerance(job.tolerance, pattern)
    budget, blur = job.budget, job.blur
    waves = Waves(pattern=pattern, blur=blur, shares=job.shares, footprint=footprint)
    shortest = float(blur.min())
    near, reach = reach_of_ringing(waves, job.edges, job.grid, budget)
    field_step = shortest * min(COARSEST_FIELD, _step(pattern, 8, budget.allowed("field") / EIGHT_POINTS))
    response_step = shortest * min(COARSEST_RESPONSE, _step(pattern, 6, 0.5 * budget.allowed("response") / SIX_POINTS))
    panel_nodes = _panel_nodes(pattern, budget.allowed("panels"))
    return Settings(
        tolerance=job.tolerance,
        near=near,
        reach=reach,
        field_step=field_step,
        response_step=response_step,
        panel=shortest * PANEL_BLURS,
        panel_nodes=panel_nodes,
        piece_nodes=_piece_nodes(pattern, budget.allowed("panels"), panel_nodes),
        tile_nodes=_tile_nodes((1.0 - OF_BRIEF) * budget.allowed("tiles")),
        brief=(5.0 * OF_BRIEF * budget.allowed("tiles")) ** -0.25,
        leaf=min(LARGEST_LEAF, max(job.grid.rows, job.grid.cols)),
    )


def _step(pattern: Pattern, points: int, allowed: float) -> float:
    """Return a table's step δ, λN, for which interpolation through n points has the error ``allowed``.

    The error is (2πδ)ⁿ·∫OTF·fⁿ⁻¹ df/π, since the light across an edge is ½ + ∫OTF(f)·sin(2πfh)/πf df and interpolation
    has the relative error (2πδf)ⁿ for every wave in it. An infinite edge's response reaches this bound, and two edges
    at once in a corner; ends in the field were measured to reach a tenth to eight tenths of it.
    """
    angle: float = (math.pi * allowed / pattern.moment(points - 1)) ** (1.0 / points)
    return angle / (2.0 * math.pi)


@functools.lru_cache(maxsize=64)
def _panel_nodes(pattern: Pattern, allowed: float) -> int:
    """Return the number of nodes of the Gauss rule on a panel along an edge.

    The field across the edge is ∬OTF(f)·fₙ/(2πf²)·e^(2πi…) d²f. A wave of frequency f·sin θ along the panel has the
    error E(f·sin θ) ∝ (f·sin θ)²ⁿ, and over all directions ∫|cos θ||sin θ|²ⁿ dθ = 4/(2n + 1). They cannot all be in
    phase: at most 0.15 of the bound was measured.
    """
    order = 2
    while _lost(pattern, order, PANEL_BLURS) > allowed:
        order += 1
    return order


def _lost(pattern: Pattern, order: int, length: float) -> float:
    """Return the error of a rule on pieces of a length (λN) that make up a panel."""
    each = math.exp(gauss_error(order, math.pi * length)) * pattern.moment(2 * order)
    return PANEL_BLURS * each / (math.pi * (2 * order + 1))


@functools.lru_cache(maxsize=64)
def _piece_nodes(pattern: Pattern, allowed: float, order: int) -> tuple[int, ...]:
    """Return the numbers of nodes of the rules for pieces of 1/LENGTHS, 2/LENGTHS … 1 of the longest.

    They resolve the highest frequency as well as ``order`` nodes do on a panel. That is too few if the lens passes
    mostly low frequencies: the error of two nodes grows as f⁴, that of four as f⁸, and errors of the pieces of one
    outline add up. For a round outline behind a Gaussian lens the error was a hundredth of the bound, 37 times the
    allowed one: OF_PIECES is well below that.
    """
    on_panel, longest, most = gauss_error(order, math.pi * PANEL_BLURS), [0.0], 0.0
    while most < LONGEST_PIECE:
        n = len(longest)
        keeps = math.log(OF_PIECES * allowed * math.pi * (2 * n + 1) / (PANEL_BLURS * pattern.moment(2 * n)))
        most = math.exp(0.5 * (min(on_panel, keeps) - gauss_error(n, 1.0)) / n) / math.pi
        longest.append(max(longest[-1], most * (1.0 + 1e-12)))  # rounded up: a panel's length is looked up
    return tuple(np.searchsorted(longest, LONGEST_PIECE * np.arange(1, LENGTHS + 1) / LENGTHS).tolist())


def _tile_nodes(allowed: float) -> int:
    """Return the number of Chebyshev nodes along a tile: the angle's coefficients fall as ρ⁻ⁿ/n."""
    rho = SEPARATION + math.sqrt(1.0 + SEPARATION**2)
    order = 4
    while rho**-order / (math.pi * order) > allowed:
        order += 1
    return order
