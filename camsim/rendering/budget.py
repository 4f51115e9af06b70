"""What may be wrong by how much: every source of error by name, and its share of the tolerance.

An image's error is what the scene's preparation leaves and what one engine leaves: ``SCENE`` and ``BOUNDARY`` add to
1, and so do ``SCENE`` and ``FOURIER``. An aberrated lens is rendered as two, each to its part of the tolerance: a round
one and a difference; ``SCENE`` and ``DIFFERENCE`` add to 1. ``BENT`` is what distortion adds. The check is no source of
error in an image; what *it* may be wrong by is ``CHECK_PART`` of the tolerance, and ``CHECK`` adds to 1 within that.
Shares are large where a digit costs most: ends and lines grow with the power −2/5 of what they may leave, a
difference's reach with −1/3, everything else with −1/6 or slower.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

Source: TypeAlias = Literal[
    "outlines", "dropped", "wavelengths",
    "ends", "lines", "foci", "powers", "moments", "tiles", "field", "response", "panels",
    "rings", "band", "taper", "reach", "spreading", "pupil",
    "cut", "hem", "short pupil", "short lines", "bent edges",
    "footprint rule", "own curves", "beyond", "meeting", "own wavelengths",
]  # fmt: skip


class Share(NamedTuple):
    """Part of a tolerance, and what it is kept by."""

    part: float
    model: str


SCENE: dict[Source, Share] = {
    "outlines": Share(
        0.04,
        "discs as polygons: slope of the line spread × mean square wobble / 2, or light between side and arc",
    ),
    "dropped": Share(0.03, "outlines outside the frame: contrast × angle/2π × light beyond their distance, added up"),
    "wavelengths": Share(0.03, "fused wavelengths: φ/2 + ∛φ + 3.5 nodes for φ radians of 2πr/λN, three for a digit"),
}
BOUNDARY: dict[Source, Share] = {
    "ends": Share(0.25, "rings of an edge's end that the far form leaves out: (λN/R)^{5/2}·D/4π⁴ over the spectrum"),
    "lines": Share(0.16, "the same of a whole line, twice as loud"),
    "foci": Share(0.09, "what more than that a round outline may leave where its rings meet in step"),
    "powers": Share(0.03, "powers of λN/R past the far form's three: c₇·(λN/R)⁷/13.7; a Gaussian's tail"),
    "moments": Share(0.12, "footprint's moments past the far form's: Mₙ/2πnRⁿ, n = 8, 10 …; 3·c₁·M₆/2πR⁷"),
    "tiles": Share(0.12, "Chebyshev interpolation over a tile: ρ⁻ⁿ/πn, ρ = 2 + √5"),
    "field": Share(0.05, "eight-point look-up in the field: 1.07e-3·(2πδ)⁸·∫OTF·f⁷ df/π"),
    "response": Share(0.05, "six-point look-up in the edge response, twice in a corner: 4.9e-3·(2πδ)⁶·∫OTF·f⁵ df/π"),
    "panels": Share(0.03, "Gauss rule of n nodes on panels of 1.6 λN: error for cos 1.6πt × 1.6·∫OTF·f²ⁿ df/(2n+1)π"),
}
FOURIER: dict[Source, Share] = {
    "rings": Share(0.16, "a spectrum's rings beyond where its wavelengths follow them, as of a whole line"),
    "band": Share(
        0.03, "frequencies that lens, OLPF and photosite all but stop: ∫transfer/πf df beyond, of four edges"
    ),
    "taper": Share(0.57, "what a taper of finite width leaves outside the band: 1/sinh β of the light it works on"),
    "reach": Share(0.10, "light beyond the pattern's reach, where that is nearer than the scene"),
    "spreading": Share(
        0.02, "edges by non-uniform transforms: for 1000 outlines half of their precision, rising as √n"
    ),
    "pupil": Share(0.02, "a pupil by non-uniform transforms: at most 0.43 of their precision was measured"),
}
DIFFERENCE: dict[Source, Share] = {
    "cut": Share(0.62, "an aberrated pattern's difference from a round one past its reach, as of the lines in sight"),
    "hem": Share(0.20, "what its taper leaves outside the band: 1/sinh β of eight times what a line shows there"),
    "short pupil": Share(0.03, "its Zernike series, its harmonics, nodes of the radius, its transfer's table: ¼ each"),
    "short lines": Share(
        0.03, "six-point look-up in what it shows beside a line: a response's bound, transfer taken twice"
    ),
    "spreading": FOURIER["spreading"],
}
BENT: dict[Source, Share] = {
    "bent edges": Share(0.05, "edges bent by distortion as straight sides: two thirds of an arrow × line spread"),
}
CLOSED_PART = 0.5  # of the tolerance: what an aberrated lens's round part may be wrong by; its difference has the rest
CHECK: dict[Source, Share] = {
    "footprint rule": Share(0.35, "Gauss rule over the photosite"),
    "own curves": Share(0.05, "curves as pairs of arcs: what lies between, in one pair and in all"),
    "beyond": Share(0.35, "rings of ends and lines past the radius of the table"),
    "meeting": Share(0.20, "rings that meet: of round outlines and of many lines"),
    "own wavelengths": Share(0.05, "its own fused wavelengths"),
}
CHECK_PART = 1.0 / 40.0  # of the tolerance: what the check may be wrong by
DIFFERENCE_CHECK_PART = 0.5  # likewise of an aberrated lens's difference: its reach grows with the cube root of this


@dataclass(frozen=True, slots=True)
class ErrorBudget:
    """Largest errors that each source may cause in a photosite, adding to ``tolerance``.

    >>> ErrorBudget(1e-6).allowed("ends")
    2.5e-07
    """

    tolerance: float

    def allowed(self, source: Source) -> float:
        """Return what one source may leave, in the unit of the tolerance."""
        return self.tolerance * _SHARES[source].part

    @property
    def of_check(self) -> ErrorBudget:
        """What the check may be wrong by."""
        return ErrorBudget(CHECK_PART * self.tolerance)


_SHARES = SCENE | BOUNDARY | FOURIER | DIFFERENCE | BENT | CHECK
