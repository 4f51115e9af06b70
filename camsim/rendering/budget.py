"""Error budget: every source of error by name, with its share of the tolerance.

An image's error comes from the preparation of the scene and from one engine. The shares of ``SCENE`` and ``BOUNDARY``
add to 1, and those of ``SCENE`` and ``FREQUENCIES`` to at most 1 for each lens: none has both spikes and distortion,
and what spikes do not take mixtures do.
Shares are large where accuracy is expensive: the cost of ends and lines grows as their share to the power −2/5, all
other costs as −1/6 or slower.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

Source: TypeAlias = Literal[
    "outlines", "dropped", "wavelengths",
    "ends", "lines", "in step", "powers", "moments", "tiles", "field", "response", "panels",
    "band", "far light", "windows", "between points", "ringing", "transfers", "spreading", "mixtures", "spikes",
    "bent edges",
]  # fmt: skip


class Share(NamedTuple):
    """Part of the tolerance, and the error model that keeps a source within it."""

    part: float
    model: str


SCENE: dict[Source, Share] = {
    "outlines": Share(
        0.14,
        "discs as polygons: slope of the line spread × mean square wobble / 2, or light between side and arc",
    ),
    "dropped": Share(0.03, "outlines outside the frame: contrast × angle/2π × light beyond their distance, added up"),
    "wavelengths": Share(0.03, "fused wavelengths: φ/2 + ∛φ + 3.5 nodes for φ radians of 2πr/λN, three for a digit"),
}
BOUNDARY: dict[Source, Share] = {
    "ends": Share(0.25, "ringing of an edge's end, which the far form omits: (λN/R)^{5/2}·D/4π⁴ over the spectrum"),
    "lines": Share(0.16, "the same ringing across a whole line, twice that of an end"),
    "in step": Share(0.09, "what edges add to that if their rings meet in step: (λN/R)²/π³ of a circle"),
    "powers": Share(0.03, "powers of λN/R beyond the far form's three: c₇·(λN/R)⁷/13.7; a Gaussian's tail"),
    "moments": Share(0.07, "moments of the footprint beyond the far form's: Mₙ/2πnRⁿ, n = 8, 10 …; 3·c₁·M₆/2πR⁷"),
    "tiles": Share(0.07, "Chebyshev interpolation over a tile: ρ⁻ⁿ/πn, ρ = 2 + √5"),
    "field": Share(0.05, "eight-point look-up in the field: 1.07e-3·(2πδ)⁸·∫OTF·f⁷ df/π"),
    "response": Share(0.05, "six-point look-up in the edge response, twice in a corner: 4.9e-3·(2πδ)⁶·∫OTF·f⁵ df/π"),
    "panels": Share(0.03, "Gauss rule of n nodes on panels of 1.6 λN: error for cos 1.6πt × 1.6·∫OTF·f²ⁿ df/(2n+1)π"),
}
FREQUENCIES: dict[Source, Share] = {
    "band": Share(0.05, "frequencies cut off where hardly any light passes: ∫transfer/πf df beyond, four edges"),
    "far light": Share(
        0.05, "light beyond the last level: an edge's c·λN/R, c by the pupil's perimeter; a small scene's by 1/R³"
    ),
    "windows": Share(0.05, "light beyond the kernel of a level's window: 1/sinh β of the light in that window"),
    "between points": Share(0.05, "coarse levels between their points: side lobes of the interpolating kernel"),
    "ringing": Share(
        0.10, "ringing beyond the first level: (λN/R)^{5/2}/4π⁴ of eight ends × √(edges/4); (λN/R)²/π³ of circles"
    ),
    "transfers": Share(0.15, "tables of the lens's transfer, and integrals over its pupil, tested between nodes"),
    "spreading": Share(0.02, "precision of the non-uniform transforms of edges, pictures and points"),
    "mixtures": Share(0.06, "colours computed as mixtures of fewer; 0.28 without spikes or an obstruction"),
    "spikes": Share(0.27, "light that a pupil's straight sides throw beyond their level: 2/5 of it"),
    "bent edges": Share(0.05, "edges bent by distortion as straight sides: two thirds of the sagitta × line spread"),
}


@dataclass(frozen=True, slots=True)
class ErrorBudget:
    """Largest errors of a photosite from each source, which add to ``tolerance``.

    >>> ErrorBudget(1e-6).allowed("ends")
    2.5e-07
    """

    tolerance: float

    def allowed(self, source: Source) -> float:
        """Return the largest error from one source, in the unit of the tolerance."""
        return self.tolerance * _SHARES[source].part


_SHARES = SCENE | BOUNDARY | FREQUENCIES
