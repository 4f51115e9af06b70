"""The boundary engine's settings, chosen from the tolerance by an error model before anything is computed.

Every source of error is given its share of the tolerance (budget.py); amplitudes are for a contrast of 1:

* The far form leaves out what oscillates with cos(2πr/λN). Per end at distance R it is at most
  (λN/R)^{5/2}·D/(4π⁴), D the footprint's transfer at 1/λN; a whole line twice that. Over a spectrum the
  wavelengths are added as the phasors that they are, sign of D included; many corners in sight of one photosite (or
  many lines) add up like random phases, so their share falls with the root of their number. Where keeping it out by
  distance would take long integrals, the rings are computed instead (rings.py) until they are as quiet as that.
* The footprint's moments end at the sixth: next come |Mₙ|/(2πnRⁿ), n = 8, 10 …, and about 3·c1·M6/(2π R⁷).
* The eight-point look-up in the field and the six-point one in a line's response: `_step`.
* The Gauss rule on panels along an edge: `_panel_nodes`; on short edges far away: `dipole.longest_dipoles`.
* Chebyshev interpolation over a tile: ρ⁻ⁿ/(πn) with ρ = κ + √(1 + κ²) for the angle of an edge κ half-widths away.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from camsim.core.errors import InvalidValueError
from camsim.numerics.quadrature import EIGHT_POINTS, SIX_POINTS, gauss_error
from camsim.optics.pattern import Pattern
from camsim.rendering.boundary.dipole import longest_dipoles
from camsim.rendering.focus import Foci
from camsim.rendering.footprint import Footprint
from camsim.rendering.job import Job
from camsim.rendering.ringing import counted, smooth_from

COARSEST = 1e-2
SEPARATION = 2.0  # half-widths of a tile: as near as a source may be that is interpolated over it
PANEL_BLURS = 1.6  # what ``panel_nodes`` integrate along an edge
LONGEST_PIECE, LENGTHS = 6.4, 64  # blurs that one Gauss rule integrates near an end, and rules for shorter pieces
OF_PIECES = 16.0  # times what is allowed: as much as a bound for pieces may be over it
OF_DIPOLES = 0.1  # of what is allowed: panels along edges were seen to take 0.15 of it
COARSEST_FIELD, COARSEST_RESPONSE = 0.3, 0.15  # steps, blurs: as far as these first terms hold (to a tenth)
RINGS_FROM = 60.0  # blurs of integration that cost more than an end's rings, per wavelength and tone
LARGEST_LEAF = 16  # photosites along the smallest tiles; a smaller frame is one
TABLE_BYTES = 3e8  # of the field: larger ones cost more than rings whatever these cost


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Settings of one boundary rendering; lengths in pitches.

    dipoles           : an edge no longer than this is two dipoles wherever it is not integrated
    near, quiet_end   : an end is integrated within ``near``; beyond, its rings count until ``quiet_end``
    reach, quiet_line : a line's response is looked up within ``reach``; beyond, its rings count until ``quiet_line``
    (without rings both pairs are equal: near and reach are themselves quiet)
    foci              : about these centres rings are followed as far as the outline that they come from
    leaf              : photosites along the smallest tiles;  tile_nodes: that any tile collects on
    """

    tolerance: float
    dipoles: float
    near: float
    negligible_end: float
    reach: float
    negligible_line: float
    field_step: float
    response_step: float
    panel: float
    panel_nodes: int
    piece_nodes: tuple[int, ...]
    tile_nodes: int
    foci: Foci
    leaf: int
    separation: float = SEPARATION

    @property
    def shortest(self) -> float:
        """The shortest blur, pitches."""
        return self.panel / PANEL_BLURS


def check_tolerance(tolerance: float, pattern: Pattern, part: float = 1.0) -> None:
    """Refuse what the engine cannot promise; part: of the tolerance, that the pattern is rendered to."""
    finest = pattern.finest / part
    if not finest <= tolerance <= COARSEST:
        raise InvalidValueError(
            f"{tolerance:g} is outside {finest:g} … {COARSEST:g}, what this lens can be rendered to",
            key="tolerance",
        )


def plan_boundary(job: Job, pattern: Pattern, footprint: Footprint) -> Settings:
    """Choose the settings; ``pattern``, ``footprint``: the job's, which are known."""
    check_tolerance(job.tolerance, pattern)
    budget, edges, blur = job.budget, job.edges, job.blur
    waves = job.waves(pattern, footprint)
    shortest, longest = float(blur.min()), float(blur.max())
    one = footprint is job.footprint
    negligible_end, negligible_line, strength = job.counted if one else counted(waves, edges, job.grid, budget)
    field_step = shortest * min(COARSEST_FIELD, _step(pattern, 8, budget.allowed("field") / EIGHT_POINTS))
    response_step = shortest * min(COARSEST_RESPONSE, _step(pattern, 6, 0.5 * budget.allowed("response") / SIX_POINTS))
    near, reach = negligible_end, negligible_line
    table_bytes = 16.0 * len(waves.different) * (negligible_end / field_step) ** 2
    dear = negligible_end > RINGS_FROM * len(pattern.oscillations) * blur.size * longest or table_bytes > TABLE_BYTES
    if pattern.oscillations and dear:
        holds = max(smooth_from(waves, budget), pattern.oscillations_from_blurs * longest + footprint.extent)
        near, reach = (holds, holds) if holds < negligible_end else (near, reach)
    panel_nodes = _panel_nodes(pattern, budget.allowed("panels"))
    return Settings(
        tolerance=job.tolerance,
        dipoles=longest_dipoles(negligible_end, OF_DIPOLES * budget.allowed("panels")),
        near=near,
        negligible_end=negligible_end,
        reach=reach,
        negligible_line=negligible_line,
        field_step=field_step,
        response_step=response_step,
        panel=shortest * PANEL_BLURS,
        panel_nodes=panel_nodes,
        piece_nodes=_piece_nodes(pattern, budget.allowed("panels"), panel_nodes),
        tile_nodes=_tile_nodes(budget.allowed("tiles")),
        foci=strength,
        leaf=min(LARGEST_LEAF, max(job.grid.rows, job.grid.cols)),
    )


def _step(pattern: Pattern, points: int, allowed: float) -> float:
    """Return a table's step δ, blurs, where a look-up through n points leaves (2πδ)ⁿ·∫OTF·fⁿ⁻¹ df/π = ``allowed``.

    Across an edge the light is ½ + ∫OTF(f)·sin(2πfh)/πf df, and a look-up leaves (2πδf)ⁿ of every wave in it. Of an
    infinite edge's response the bound is reached, and in a corner by two edges at once; of ends in the field a tenth to
    eight tenths of it were measured.
    """
    angle: float = (math.pi * allowed / pattern.moment(points - 1)) ** (1.0 / points)
    return angle / (2.0 * math.pi)


@functools.lru_cache(maxsize=64)
def _panel_nodes(pattern: Pattern, allowed: float) -> int:
    """Nodes of the Gauss rule on a panel along an edge.

    The field across the edge is ∬OTF(f)·fₙ/(2πf²)·e^(2πi…) d²f; a wave of frequency f·sin θ along the panel loses
    E(f·sin θ) ∝ (f·sin θ)²ⁿ, and over all directions ∫|cos θ||sin θ|²ⁿ dθ = 4/(2n + 1). No phase can make all of them
    add up: at most 0.15 of it was measured.
    """
    order = 2
    while _lost(pattern, order, PANEL_BLURS) > allowed:
        order += 1
    return order


def _lost(pattern: Pattern, order: int, length: float) -> float:
    """Return what nodes lose on pieces of a length (blurs) that make up a panel."""
    each = math.exp(gauss_error(order, math.pi * length)) * pattern.moment(2 * order)
    return PANEL_BLURS * each / (math.pi * (2 * order + 1))


@functools.lru_cache(maxsize=64)
def _piece_nodes(pattern: Pattern, allowed: float, order: int) -> tuple[int, ...]:
    """Nodes of the rules for pieces of 1/LENGTHS, 2/LENGTHS … 1 of the longest.

    As many as follow the highest frequency as well as ``order`` nodes do on a panel. That is too few where what passes
    is mostly low: two nodes lose to f⁴ what four lose to f⁸, and the pieces of one outline lose it alike. A round
    outline behind a Gaussian lens lost a hundredth of the bound, 37 times what is allowed: OF_PIECES is well below.
    """
    on_panel, longest, most = gauss_error(order, math.pi * PANEL_BLURS), [0.0], 0.0
    while most < LONGEST_PIECE:
        n = len(longest)
        keeps = math.log(OF_PIECES * allowed * math.pi * (2 * n + 1) / (PANEL_BLURS * pattern.moment(2 * n)))
        most = math.exp(0.5 * (min(on_panel, keeps) - gauss_error(n, 1.0)) / n) / math.pi
        longest.append(max(longest[-1], most * (1.0 + 1e-12)))  # as long as a panel is a length that is asked for
    return tuple(np.searchsorted(longest, LONGEST_PIECE * np.arange(1, LENGTHS + 1) / LENGTHS).tolist())


def _tile_nodes(allowed: float) -> int:
    """Chebyshev nodes along a tile: the angle's coefficients fall as ρ⁻ⁿ/n."""
    rho = SEPARATION + math.sqrt(1.0 + SEPARATION**2)
    order = 4
    while rho**-order / (math.pi * order) > allowed:
        order += 1
    return order
