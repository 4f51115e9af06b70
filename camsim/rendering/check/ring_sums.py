"""How far the check hears rings of a picture that are in step about a place: it looks at the picture from there."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.optics import OpticalSystem
from camsim.rendering.check.field_kernels import Patches, Waves, rings_of_patches, rings_of_points
from camsim.rendering.check.fields import at_spots
from camsim.rendering.check.seen_fields import Summed

FARTHEST = 4096.0  # λN: as far out as samples, of 10⁸, may lie in rings
SHELLS = 1.1  # times as far, from one to the next
SECTORS = 16  # within which what a wavefront does to rings does not turn
CELLS, AT_ONCE = 12.0, 4096  # of a wave, in which rings are looked up; of them made at once
ROUGHLY = 1e12  # times as wrong as a sum may be, which a rule for parts of a picture may be
PASSED = 5  # directions of a sector in which what passes the footprint is asked


class RingSums(NamedTuple):
    """The most that is heard in some places, ``beyond`` (n,) each of the distances ``begins`` (n + 1,)."""

    begins: F64
    beyond: F64

    @classmethod
    def at(cls, points: F64, summed: Summed, pitch_um: float) -> RingSums:
        """Sum rings at points (n, 2), as far as all that lie beyond, in step, would be more than is allowed."""
        if not len(points):
            return cls(np.zeros(1), np.zeros(0))
        blur = summed.system.blurs_um(summed.wavelength_nm) / pitch_um
        spots = summed.system.spots_um() / pitch_um
        images = at_spots(points, spots)
        within = min(max(one.farthest(images) for one in summed.pictures), FARTHEST * float(blur.max()))
        waves = _waves(summed.density, blur, within)
        passed = _passed(summed.system, blur, pitch_um)
        first, step = float(blur.max()), math.log(SHELLS)
        farthest = max(_heard_until(waves, float(passed.mean()), summed.allowed), SHELLS * first)
        count = math.ceil(math.log(farthest / first) / step)
        sums = np.zeros((len(images), summed.density.shape[1], count, SECTORS), complex)
        in_step = (
            2.0 * float(passed.max() * np.abs(summed.density).sum(axis=(0, 2)).max()) * float(blur.max()) / math.pi**3
        )
        planes = 0
        for one in summed.pictures:
            own = waves._replace(table=waves.table[:, planes : planes + one.planes] * one.step**2)
            planes += one.planes
            patches = Patches(one.values, one.whole, one.degree, one.corner, one.axes * one.step)
            until = one.in_step_until(images, float(blur.max()), in_step / summed.allowed, SHELLS * farthest)
            for point, out in zip(images, sums, strict=True):
                rings_of_patches(patches, point, own, 1.0 / first, (math.log(first), 1.0 / step), out)
                for places, lit in one.lit_near(point, [(ROUGHLY, (0.0, until))], beyond=False):
                    rings_of_points(places, lit, point, own, (math.log(first), 1.0 / step), out)
        # What one spot hears of rings another may take away.
        sums = sums.reshape(len(points), len(spots), *sums.shape[1:]).mean(axis=1)
        heard = passed * np.abs(np.cumsum(sums[:, :, ::-1], axis=2)[:, :, ::-1])
        begins: F64 = first * SHELLS ** np.arange(count + 1.0)
        return cls(begins, heard.sum(axis=3).max(axis=(0, 1)))

    def until(self, allowed: float) -> float:
        """Return the distance beyond which no more than that is heard, 0 where that is anywhere."""
        loud = np.flatnonzero(self.beyond > allowed)
        return float(self.begins[loud[-1] + 1]) if loud.size else 0.0


def _waves(density: F64, blur: F64, farthest: float) -> Waves:
    """Return the rings of an Airy pattern, (λN/π³r³)·exp(2πi·r/λN), of all wavelengths."""
    per_pitch = CELLS / float(blur.min())
    table = np.empty((math.ceil(farthest * per_pitch) + 1, *density.shape[:2]), complex)
    for begin in range(0, len(table), AT_ONCE):
        r = (np.arange(begin, min(begin + AT_ONCE, len(table))) + 0.5) / per_pitch
        turns = np.exp(2j * math.pi * r[:, None] / blur) * (blur / math.pi**3)
        table[begin : begin + r.size] = np.einsum("rj,pcj->rpc", turns, density, optimize=True)
    return Waves(table, per_pitch)


def _heard_until(waves: Waves, passed: float, allowed: float) -> float:
    """Return the distance beyond which no more is heard even of rings whose bright halves all are in step."""
    r = (np.arange(len(waves.table)) + 0.5) / waves.per_pitch
    ring = 2.0 * passed * np.abs(waves.table).sum(axis=1).max(axis=1) / r**2
    loud = np.flatnonzero(np.cumsum(ring[::-1])[::-1] / waves.per_pitch > allowed)
    return float(r[loud[-1]]) if loud.size else 0.0


def _passed(system: OpticalSystem, blur: F64, pitch_um: float) -> F64:
    """Return (sectors,) how much of the rings passes a photosite, at the most."""
    turn = 2.0 * math.pi * (np.arange(SECTORS)[:, None] + np.linspace(0.0, 1.0, PASSED)) / SECTORS
    f = 1.0 / (np.array([blur.min(), blur.max()])[:, None, None] * pitch_um)
    passed: F64 = np.abs(system.photosite.otf(f * np.cos(turn), f * np.sin(turn), 0.0)).max(axis=(0, 2))
    return passed
