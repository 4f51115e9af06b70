"""What is heard of a pattern's rings where a taper cuts them off.

Of what lies all about a photosite the energy within a radius swings with each ring, by 4π√(f·r) times what an end hears
of it. Cut off, it ends in the middle of a swing, but for what the taper averages. A pattern's own rings are as fast as
its band, which every taper is wide enough for; behind an obstruction, or a curve with a knee, there are slower ones.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from camsim.optics import OpticalSystem, RoundLens


class Swing(NamedTuple):
    """A ring: f in cycles/pitch; an edge's end hears a·r⁻ⁿ of it."""

    f: float
    a: float
    n: float

    def at(self, distance: float) -> float:
        """Return by how much the energy within a distance swings."""
        swing: float = 4.0 * math.pi * math.sqrt(self.f * distance) * self.a * distance**-self.n
        return swing

    def light(self, distance: float) -> float:
        """Return how much light there is beyond a distance, of either sign: no more, from where it falls."""
        return 2.0 * math.pi * self.f * distance * self.at(distance) / max(self.n - 1.5, 0.5)

    def left(self, distance: float, width: float, sharpness: float) -> float:
        """Return how much of the swing a taper leaves: sinh(√(β² − x²))/√(β² − x²) over sinh(β)/β, x = πf·w."""
        x = math.pi * self.f * width
        root = math.sqrt(max(sharpness**2 - x * x, 0.0))
        return self.at(distance) * math.exp(root - sharpness) * sharpness / max(root, 1.0)

    def width(self, distance: float, sharpness: float, allowed: float) -> float:
        """Return how wide a taper is that leaves no more than is allowed."""
        swing = self.at(distance)
        if swing <= allowed:
            return 0.0
        root = max(sharpness + math.log(allowed / swing / sharpness), 0.0)
        return math.sqrt(max(sharpness**2 - root**2, 0.0)) / (math.pi * self.f)


def swings(system: OpticalSystem, blur: float) -> tuple[Swing, ...]:
    """Return a round lens's rings at a wavelength at which its own length is ``blur``, pitches."""
    if not isinstance(system.lens, RoundLens) or system.more:
        return ()
    return tuple(Swing(u / blur, a * blur**n, n) for u, a, n in system.lens.pattern().rings)
