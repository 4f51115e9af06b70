"""How much of a wave a footprint of any shape lets pass, in the direction where that is the most."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64
from camsim.optics import OpticalSystem

PER_OCTAVE, OCTAVES = 4, 6  # frequencies that are asked below the highest; what is lower is taken to pass
LOBES = 16.0  # directions of a half turn for every period that the footprint's extent holds: a side's lobe is twice
BETWEEN = 0.75  # as wide as five steps at least. Of what passes between all that are asked: 0.78 and more was met
BESIDE = 5  # frequencies that are asked about each


@dataclass(frozen=True, slots=True, eq=False)
class Envelope:
    """The envelope of OLPF and photosite, over all directions.

    cycles : (n,) frequencies, cycles/pitch, rising;  passes: (n,) how much of each passes at the most, falling
    """

    cycles: F64
    passes: F64

    @classmethod
    def of(cls, system: OpticalSystem, pitch_um: float, highest: float) -> Envelope:
        """Measure a system's up to a frequency, cycles/pitch.

        A transfer has zeros, where a wave that is curved is not stopped: so it is asked half a lobe to either side
        too (lobes of what extends as far as R either way are 1/2R apart), and what any higher frequency passes counts.
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
        """Return what passes of frequencies, cycles/pitch, at the most. What falls like 1/f lies below chords."""
        passed: F64 = np.interp(frequency, self.cycles, self.passes)
        return np.where(frequency < self.cycles[0], 1.0, passed)
