"""Far scenery behind a pupil with straight sides: its light comes along spikes, edge by edge, without a transform.

No coarser lattice holds what is far, as it does behind round lenses (shells.py): spikes are as narrow far out as near.
But each is a profile across times 1/s² along (optics/spikes.py), so a region's light is an integral along its edges of
∫(1 − taper)/s² ds times the profile: where a spike crosses an edge, and how much of its width. The pattern itself,
tapered soon after a distance, is left to a transform whose period needs to be no longer than that.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, U8
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.nonuniform import line_modes
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsSpikes
from camsim.optics.spikes import Spike
from camsim.quadrature import gauss_legendre
from camsim.quintics import quintic_cells
from camsim.rendering.engine import Cost
from camsim.rendering.fourier.crossings import Crossings
from camsim.rendering.fourier.shells import RINGS_PART, first_quiet
from camsim.rendering.fourier.sight import FarLight, Sight
from camsim.rendering.fourier.spike_kernels import Far, Profiles, Ways, add_spikes
from camsim.rendering.fourier.taper import Hem, hem_from, taper, tapered
from camsim.rendering.spectral import Signals, fuse

BESIDES = 0.05  # (λN/r)² of an edge: interference and what lies between spikes, measured up to 0.003
UNEVEN = 0.1  # λN/r² times the spread: parts of an aberrated side that lie across are moved along, measured up to 0.01
WIDE = 0.1  # λN/r³ times its square: the taper, and 1/s², are those of a spike's middle, measured up to 0.015
CELLS = 256  # of a taper
TAIL, PER_WAVE = 32.0, 16.0  # blurs to either side of a spike that are tabulated, cells of its finest wave
PHASE, FUSED_OFF = 20.0, 1e-3  # wavelengths that a spike's light is summed from
SECONDS_PER_WAY = 4e-8  # of one core, of a photosite and an edge
SECONDS_PER_PLACE, SECONDS_PER_RULE = 2e-7, 1e-9  # of a place beside a spike, and of a Gauss rule, by its nodes' square
FINEST = 1e-14  # of what finufft sums


@dataclass(frozen=True, kw_only=True, eq=False)
class Spikes(FarLight):
    """The light from beyond a taper, as spikes of a lens throw it."""

    def rendered(
        self, origin: tuple[float, float], channel: U8, progress: Callable[[float], None] = lambda done: None
    ) -> F64:
        """Render every photosite in its own channel, less the background; see ``FourierImage.rendered``."""
        pairs, pair = self.edges.pairs()
        image = np.zeros(channel.shape)
        images, channels = image.reshape(-1, *channel.shape[-2:]), channel.reshape(-1, *channel.shape[-2:])
        far = Far(self.edges.start, self.edges.end, pair)
        add = functools.partial(_add, far, self._profiles(pairs), self._ways, np.array(origin), channels, images)
        shared(images.size, add, least=max(1, 20_000 // (1 + len(self.edges))))
        progress(1.0)
        return image

    def expected(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]:
        """Return what rows and columns are expected to take; no frequencies."""
        each = SECONDS_PER_WAY * self.count * len(self.edges)
        seconds = each * shape[0] * shape[1] + self._tables_seconds
        return Cost(seconds=seconds, memory_bytes=16.0 * shape[0] * shape[1]), 0.0

    @property
    def _tables_seconds(self) -> float:
        """What sides' profiles take at all wavelengths: a Gauss rule of a wave for every turn, and its transform."""
        blur = float(self.system.blurs_um(self.wavelength_nm).min())
        half = TAIL + 3.0 * self.system.extent_um / blur
        each = SECONDS_PER_PLACE * 2.0 * half * PER_WAVE + SECONDS_PER_RULE * (2.0 * half) ** 2
        return each * len(self._spikes) * self.wavelength_nm.size

    @property
    def count(self) -> int:
        """How many there are, two of every side."""
        return 2 * len(self._spikes)

    @cached_property
    def _spikes(self) -> tuple[Spike, ...]:
        return spikes_of(self.system, float(self.wavelength_nm.mean()))

    @cached_property
    def _ways(self) -> Ways:
        shape, (x, w) = taper(self.hem.sharpness), gauss_legendre(8)
        signs, cells, begins, steps, wholes, moves = np.tile([1.0, -1.0], len(self._spikes)), [], [], [], [], []
        spikes = [spike for spike in self._spikes for _ in range(2)]
        for spike, sign in zip(spikes, signs.tolist(), strict=True):
            move, aside = sign * spike.moved_um[0] / self.pitch_um, spike.moved_um[1] / self.pitch_um
            steepest = float(np.abs(spike.along).max())
            begin, end = (self.hem.inner - abs(aside)) / steepest, (self.hem.outer + abs(aside)) / steepest
            step = (end - begin) / CELLS
            s = begin + step * (np.arange(-2.0, CELLS + 2.0)[:, None] + 0.5 * (1.0 + x))
            at = [
                np.abs(s * sign * part + aside * other) for part, other in zip(spike.along, spike.across, strict=True)
            ]
            kept = np.prod([tapered(place, self.hem.inner, self.hem.outer, shape) for place in at], axis=0)
            running = np.concatenate([[0.0], np.cumsum(0.5 * step * ((1.0 - kept) / (s - move) ** 2) @ w)])
            cells.append(quintic_cells(running - running[2]))
            wholes.append(running[CELLS + 2] - running[2] + 1.0 / (end - move))
            begins.append(begin)
            steps.append(step)
            moves.append(move)
        return Ways(
            along=signs[:, None] * np.array([spike.along for spike in spikes]),
            across=np.array([spike.across for spike in spikes]),
            moved=np.array(moves),
            sign=signs,
            gained=np.array(cells),
            begin=np.array(begins),
            step=np.array(steps),
            whole=np.array(wholes),
        )

    def _profiles(self, pairs: np.ndarray) -> Profiles:
        """Return the light across every side's spike, running, summed over wavelengths."""
        signals = Signals(
            wavelength_nm=self.wavelength_nm,
            density=self.density[pairs[:, 0]] - self.density[pairs[:, 1]],
            scale=np.ones(self.density.shape[1]),
        )
        wavelength_nm, weights = fuse(signals, phase=PHASE, allowed=FUSED_OFF)
        each = [spikes_of(self.system, nm) for nm in wavelength_nm.tolist()]
        every = [spike for own in each for spike in own]
        finest = max(spike.cutoff_per_um for spike in every) * self.pitch_um
        blur = max(1.0 / spike.cutoff_per_um for spike in every) / self.pitch_um
        wide = (self.system.extent_um + max(spike.spread_um[1] for spike in every)) / self.pitch_um
        step, half = 1.0 / (PER_WAVE * finest), TAIL * blur + 3.0 * wide
        first, count = -half - 2.0 * step, math.ceil(2.0 * half / step) + 5
        running, tails, middles = [], [], []
        for own in zip(*each, strict=True):
            middle = own[0].moved_um[1] / self.pitch_um
            curves = np.array([self._running(spike, middle + first, step, count) for spike in own])
            light = np.array([spike.light_um for spike in own]) / self.pitch_um
            missing = np.array([0.5 / np.pi**2 / (spike.cutoff_per_um * self.pitch_um) for spike in own])
            running.append(quintic_cells(np.einsum("pcj,j,jt->pct", weights, light, curves)))
            tails.append(np.stack([0.5 * weights @ light, weights @ (light * missing)], axis=-1))
            middles.append(middle)
        all_alike = np.ones(len(middles))
        return Profiles(
            running=np.array(running),
            tail=np.array(tails),
            first=np.array(middles) - half,
            step=step * all_alike,
            middle=np.array(middles),
            width=(blur + wide) * all_alike,
        )

    def _running(self, spike: Spike, first: float, step: float, count: int) -> F64:
        """Return ∫ of a profile of one unit, averaged over the footprint, from the middle to even places (pitches)."""
        cut, farthest = spike.cutoff_per_um * self.pitch_um, max(abs(first), abs(first + step * (count - 1)))
        x, w = gauss_legendre(math.ceil(2.0 * cut * farthest) + 32)
        f = 0.5 * cut * (1.0 + x)
        fx, fy = np.multiply.outer(spike.across, f / self.pitch_um)
        passed = spike.transfer(f / self.pitch_um) * self.system.footprint_otf(fx, fy)
        middle = first + step * (count // 2)
        waves = 0.5 * cut * w / (np.pi * f) * passed * np.exp(2j * np.pi * middle * f)
        return line_modes(2.0 * np.pi * step * f, waves, count, precision=FINEST).imag


def _add(far: Far, profiles: Profiles, ways: Ways, origin: F64, channel: U8, image: F64, begin: int, stop: int) -> None:
    add_spikes(begin, stop, far, profiles, ways, origin, channel, image)


def spikes_of(system: OpticalSystem, wavelength_nm: float) -> tuple[Spike, ...]:
    """Return a system's spikes, none where it has none or where its far light is not known."""
    lens = system.lens
    return lens.spikes(wavelength_nm) if isinstance(lens, KnowsSpikes) and not system.more else ()


def spike_hem(sight: Sight) -> Hem | None:
    """Return a taper beyond which spikes are all that is seen of edges; None where there are none, or nothing is."""
    pitch_um, longest = sight.pitch_um, sight.longest
    spikes = spikes_of(sight.system, float(sight.wavelength_nm.max()))
    if not spikes or not len(sight.edges):
        return None
    allowed, (nearest, farthest) = sight.of_tapers, sight.distances
    nearest = np.maximum(nearest - sight.extent, 0.0)
    spread = np.max([spike.spread_um for spike in spikes], axis=0) / pitch_um
    spot = max(spike.spot_um for spike in spikes) / pitch_um  # within it light is no spike
    besides = BESIDES * longest**2 + UNEVEN * longest * spread[0], WIDE * longest * float(spread @ spread)
    crossings = Crossings(spikes, sight.edges, sight.shape, longest + sight.extent + float(spread[1]), spot)
    from_spot, share = nearest - spot, RINGS_PART * allowed

    def quiet(beyond: float) -> bool:
        """Whether what spikes leave out of edges beyond a distance is within its share: less, the farther that is."""
        away = np.maximum(from_spot, beyond)
        each = besides[0] / away**2 + besides[1] / away**3
        alone = besides[0] / beyond**2 + besides[1] / beyond**3
        return float(each.sum()) <= share or crossings.most(each, alone) <= share

    beyond = first_quiet(quiet, longest, farthest)
    if beyond is None:
        return None
    light = 2.0 * sum(spike.light_um for spike in spikes) / pitch_um / beyond
    hem = hem_from(spot + beyond, (1.0 - RINGS_PART) * allowed / light, max(sight.shape), sight.kernel.cutoff)
    return hem if hem.outer < farthest else None
