"""Envelope of the transfer of a footprint of any shape: its largest value over all directions."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64
from camsim.optics import OpticalSystem

PER_OCTAVE, OCTAVES = 4, 6  # sampling of frequencies below the highest; lower ones are assumed to pass entirely
LOBES = 16.0  # directions over half a turn per period within the footprint's extent: five steps or more to half a lobe
BETWEEN = 0.75  # largest sample over the largest value between samples; 0.78 and more was found
BESIDE = 5  # samples around each frequency


@dataclass(frozen=True, slots=True, eq=False)
class Envelope:
    """The envelope of OLPF and photosite, over all directions.

    cycles : (n,) frequencies, cycles/pitch, increasing;  passes: (n,) bounds of the transfer, decreasing
    """

    cycles: F64
    passes: F64

    @classmethod
    def of(cls, system: OpticalSystem, pitch_um: float, highest: float) -> Envelope:
        """Compute the envelope of a system up to a frequency, cycles/pitch.

        A transfer has zeros, but a curved wave passes even there. So it is also sampled half a lobe to either side (the
        lobes of a footprint that extends R to either side are 1/2R apart), and the bound includes all higher
        frequencies.
        """
        reach = system.extent_um / pitch_um
        cycles = highest * 2.0 ** (np.arange(-OCTAVES * PER_OCTAVE, 1.0) / PER_OCTAVE)
        aside = 0.25 / max(reach, 1e-300) * np.linspace(-1.0, 1.0, BESIDE)
        passes = np.ones(cycles.size)
        for k in np.flatnonzero(cycles * reach > 0.25).tolist():
            asked = cycles[k] + aside
            angle = np.pi * np.arange(count := math.ceil(LOBES * float(asked[-1]) * reach) + 12) / count
            per_um = asked[:, None] / pitch_um
            found = np.abs(system.footprint_otf(per_um * np.cos(angle), per_um * np.sin(angle)))
            passes[k] = min(1.0, float(found.max()) / BETWEEN)
        return cls(cycles, np.maximum.accumulate(passes[::-1])[::-1])

    def at(self, frequency: F64) -> F64:
        """Return the bound of the transfer at frequencies, cycles/pitch; chords lie above a decrease like 1/f."""
        passed: F64 = np.interp(frequency, self.cycles, self.passes)
        return np.where(frequency < self.cycles[0], 1.0, passed)
