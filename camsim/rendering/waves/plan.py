"""A rendering by frequency sums, everything decided: band, levels, wavelengths, what it costs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.kept import cached_property
from camsim.optics.of_pupil import OfPupil
from camsim.optics.protocols import Fading, KnowsReach
from camsim.rendering.engine import FEWEST_CHECKED, Cost, Decision, Marks, Progress
from camsim.rendering.fields.job import FieldJob
from camsim.rendering.fields.layer import Layer
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.job import Job, Nodes
from camsim.rendering.spectral import Signals, fewer, fuse, kinds, wavefront_phase
from camsim.rendering.waves.edges import EdgeSource
from camsim.rendering.waves.fields import FieldSource
from camsim.rendering.waves.image import FrequencyImage, Source, tiles
from camsim.rendering.waves.levels import Level, lattice_of, levels_of
from camsim.rendering.waves.transfers import Footprint, Lens
from camsim.rendering.work import Work
from camsim.repeated import Channels

FINEST, COARSEST = 1e-11, 1e-2
NEAR, NEAR_OF_LARGE, LARGE = 24.0, 40.0, 700  # pitches that the first level sees, in frames up to so many photosites
OF_LIGHT, OF_BAND, OF_LEAK, OF_PRECISION, OF_TRANSFER, OF_MIXTURE = (
    0.05,
    0.05,
    0.1,
    0.02,
    0.15,
    0.02,
)  # of the tolerance
OF_RINGS = 0.1
RINGING = 2.0 / math.pi**4  # of an edge's ringing: 8 ends' (λN/R)^{5/2}/4π⁴
CIRCLE_TAIL = 0.06  # an edge's light at R behind a pupil of perimeter p and area a: so much times (p/a)·λN/R
DIGITS_POWER, NODES_OF_WAVE = 1.6, 2.0  # of the number of wavelengths
STEPS, DIRECTIONS = 256, 8  # in which a system is asked what it passes
SECONDS_EACH, SECONDS_CURVE, SECONDS_POLAR, SECONDS_NODE = 6e-8, 4e-9, 3e-8, 1e-7  # of a frequency, and of a node
SECONDS_TABLE = 0.02  # of a pupil's transfer at a wavelength
BYTES_EACH = 40.0


@dataclass(frozen=True, kw_only=True, eq=False)
class WavesPlan:
    """A job, and the fields of its scene if there are any.

    nodes : wavelengths of the edges
    """

    job: Job
    nodes: Nodes
    fields: FieldJob | None = None

    summed: ClassVar = FrequencyImage

    @property
    def marks(self) -> Marks:
        """None of its own."""
        return Marks.plain(float(self.job.blur.max()))

    @property
    def fewest(self) -> int:
        """How many photosites are checked at the least."""
        return FEWEST_CHECKED

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        return self.nodes.wavelength_nm.size

    @cached_property
    def image(self) -> FrequencyImage | None:
        """What sums; None where there is nothing."""
        job, tolerance = self.job, self.job.tolerance
        precision = max(1e-13, OF_PRECISION * tolerance)
        found: list[tuple[Source, F64, Lens]] = []
        if len(job.edges):
            nodes = self.nodes
            lens = self._lens(nodes.wavelength_nm, tolerance)
            density = nodes.density
            if not job.system.chromatic:
                density, lens = density.sum(axis=2, keepdims=True), self._lens(nodes.wavelength_nm[:1], tolerance)
            off = OF_MIXTURE * tolerance / density.shape[2]
            shares, contrast = fewer(*kinds(density[1:] - density[0]), off)
            found.append((EdgeSource(edges=job.edges, shares=shares, precision=precision), contrast, lens))
        if self.fields is not None:
            found += self._of_fields(self.fields, precision)
        if not found:
            return None
        cut = max(self._band(lens, weights, tolerance) for _, weights, lens in found)
        farthest = max(_farthest(source, job) for source, *_ in found)
        levels = self._levels(cut, farthest, tolerance)
        return self.summed(
            sources=found,
            footprint=Footprint(system=job.system, pitch_um=job.grid.pitch_um),
            levels=levels,
            leak=OF_LEAK * tolerance,
        )

    def fused(self, signals: Signals, tolerance: float) -> tuple[F64, F64]:
        """Return few wavelengths (j,), and the weights (spectra, channels, j) of signals there."""
        return fuse(signals, phase=0.0, allowed=1.0, count=_wavelengths(self.job, tolerance))

    def _lens(self, wavelength_nm: F64, tolerance: float) -> Lens:
        return Lens(
            system=self.job.system,
            wavelength_nm=wavelength_nm,
            pitch_um=self.job.grid.pitch_um,
            allowed=OF_TRANSFER * tolerance,
        )

    def _of_fields(self, fields: FieldJob, precision: float) -> Iterator[tuple[Source, F64, Lens]]:
        signals = Signals(
            wavelength_nm=fields.wavelength_nm, density=fields.density, scale=np.ones(len(fields.density[0]))
        )
        nodes, density = self.fused(signals, fields.tolerance)
        if not self.job.system.chromatic:
            nodes, density = nodes[:1], density.sum(axis=2, keepdims=True)
        lens, first = self._lens(nodes, fields.tolerance), 0
        for layer in fields.layers:
            weights = density[first : first + layer.planes]
            first += layer.planes
            rows, mixture = lens.mixed(weights, OF_MIXTURE * fields.tolerance)
            cut = self._band(lens, weights, fields.tolerance)
            yield self._source(layer, mixture, cut, precision), weights[rows], lens

    def _source(self, layer: Layer | PointLayer, mixture: F64, cut: float, precision: float) -> Source:
        return FieldSource(layer=layer, mixture=mixture, cut=cut, precision=precision)

    def _band(self, lens: Lens, weights: F64, tolerance: float) -> float:
        """Return the highest frequency that matters: what is beyond gives four edges no more than its share."""
        pitch_um = self.job.grid.pitch_um
        highest = self.job.system.highest_per_um(lens.wavelength_nm) * pitch_um
        frequency = highest * (np.arange(STEPS) + 0.5) / STEPS
        angle = np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        fx, fy = np.outer(np.cos(angle), frequency) / pitch_um, np.outer(np.sin(angle), frequency) / pitch_um
        footprint = np.abs(self.job.system.footprint_otf(fx, fy)).max(axis=0)
        passes = lens.size(frequency, np.abs(weights).max(axis=(0, 1))) * footprint
        beyond = np.cumsum((passes / frequency)[::-1])[::-1] * (4.0 / math.pi * highest / STEPS)
        allowed = OF_BAND * tolerance
        kept = int(np.count_nonzero(beyond > allowed))
        return float(highest * max(kept, 8) / STEPS)

    def _levels(self, cut: float, farthest: float, tolerance: float) -> Sequence[Level]:
        job, system = self.job, self.job.system
        pitch_um, extent = job.grid.pitch_um, job.extent
        lens, longest = system.lens, float(job.blur.max())
        lost, wavelengths = OF_LIGHT * tolerance, job.signals.wavelength_nm
        if isinstance(lens, Fading) and lens.fades and isinstance(lens, KnowsReach) and not system.more:
            reach = (
                max(lens.reach_um(0.1 * lost, nm) for nm in (float(wavelengths[0]), float(wavelengths[-1]))) / pitch_um
            )
            return levels_of(cut, reach + extent, lost, OF_LEAK * tolerance, farthest, 0.0)
        near = NEAR if max(job.grid.rows, job.grid.cols) <= LARGE else NEAR_OF_LARGE
        tail = 2.0 * CIRCLE_TAIL * longest
        spot = 0.0
        if isinstance(lens, OfPupil):
            pupil = lens.pupil
            around = (
                2.0 * math.pi * (1.0 + pupil.obstruction)
                if pupil.shape == "circular"
                else pupil.sides * pupil.side_length + 2.0 * math.pi * pupil.obstruction
            )
            tail = CIRCLE_TAIL * longest * around / pupil.area
            spot = 1.5 * max(self._spot_um(nm) for nm in (float(wavelengths[0]), float(wavelengths[-1]))) / pitch_um
        first = max(near, _ringing(job, tolerance), 2.0 * longest) + spot + extent
        return levels_of(cut, first, lost, OF_LEAK * tolerance, farthest, tail)

    def _spot_um(self, wavelength_nm: float) -> float:
        """Return how far from the middle rays fall at the most."""
        lens = self.job.system.lens
        assert isinstance(lens, OfPupil)
        return spot_um(lens, wavelength_nm)

    @cached_property
    def _frequencies(self) -> float:
        """How many frequencies there are, of all levels and tiles."""
        image = self.image
        if image is None:
            return 0.0
        grid, (low, high) = self.job.grid, image.box
        at, total = np.array(grid.first_centre), 0.0
        for level in image.levels:
            if level.takes is None:
                for row, col, height, width in tiles((grid.rows, grid.cols)):
                    here = at + np.array([col, row], float)
                    total += lattice_of(level, (width, height), low - here, high - here).size
            else:
                total += lattice_of(level, (grid.cols, grid.rows), low - at, high - at).size
        return total

    @cached_property
    def cost(self) -> Cost:
        """What one image takes."""
        image = self.image
        if image is None:
            return Cost(seconds=0.0, memory_bytes=0.0)
        each = 0.0
        for _, weights, lens in image.sources:
            each += len(weights) * (
                SECONDS_EACH + weights.shape[1] * (SECONDS_CURVE if lens.is_round else SECONDS_POLAR)
            )
        nodes = 8.0 * len(self.job.edges)
        seconds = self._frequencies * each + nodes * SECONDS_NODE
        most = max(len(weights) for _, weights, _ in image.sources)
        grid = self.job.grid
        largest = max(
            lattice_of(image.levels[0], (width, height), np.full(2, -1e9), np.full(2, 1e9)).size
            for _, _, height, width in tiles((grid.rows, grid.cols))
        )
        tables = sum(len(lens.wavelength_nm) * SECONDS_TABLE for *_, lens in image.sources if not lens.is_round)
        return Cost(seconds=0.005 + seconds + tables, memory_bytes=BYTES_EACH * largest * most)

    def work(self, images: int) -> Work:
        """Count the work of ``images`` images."""
        grid, layers = self.job.grid, () if self.fields is None else self.fields.layers
        return Work(
            edges=len(self.job.edges),
            wavelength_nodes=self.wavelengths,
            channels=images,
            photosites=images * grid.rows * grid.cols,
            frequencies=round(self._frequencies),
            samples_of_pictures=sum(layer.shape[0] * layer.shape[1] for layer in layers),
        )

    def decisions(self) -> Iterator[Decision]:
        """Yield what people may want to know."""
        image = self.image
        if image is None:
            return
        for layer in () if self.fields is None else self.fields.layers:
            decision, reason = layer.said
            yield Decision(topic=layer.kind, decision=decision, reason=reason)
        if len(image.levels) > 1:
            yield Decision(
                topic="far light",
                decision=f"beyond {image.levels[0].reach:.3g} photosites on {len(image.levels) - 1} coarser lattices",
                reason="the lens's tail is smooth there",
            )
        yield Decision(
            topic="settings",
            decision=f"{self._frequencies:.2g} frequencies, up to {image.levels[0].cut:.3g} cycles a pitch",
            reason="lens, OLPF and photosite pass nothing beyond that counts",
        )

    def of(self, job: Job) -> WavesPlan:
        """Return the same for other edges, without pictures."""
        return dataclasses.replace(self, job=job, nodes=job.nodes_like(self.nodes), fields=None)

    def bands(self, channel: Channels, progress: Progress) -> Iterator[F64]:
        """Yield the image, each photosite in its own channel, in bands of a tile's height."""
        grid, image = self.job.grid, self.image
        base = self.job.base
        if image is None:
            yield base[channel[:]]
            progress(1.0)
            return
        band: F64 | None = None
        for rows, cols, planes in image.planes(grid.first_centre, (grid.rows, grid.cols)):
            own = channel[rows]
            if band is None:
                band = base[own]
            for k, plane in enumerate(planes):
                np.add(band[:, cols], plane, out=band[:, cols], where=own[:, cols] == k)
            if cols.stop == grid.cols:
                yield band
                band = None
                progress(rows.stop / grid.rows)
        self.__dict__.pop("image", None)  # the check needs the memory

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield several images, each as one band: all channels' sums are made at once."""
        grid, image, base = self.job.grid, self.image, self.job.base
        out = base[channels]
        if image is not None:
            for rows, cols, planes in image.planes(grid.first_centre, (grid.rows, grid.cols)):
                for own, channel in zip(out, channels, strict=True):
                    for k, plane in enumerate(planes):
                        np.add(own[rows, cols], plane, out=own[rows, cols], where=channel[rows, cols] == k)
                progress(rows.stop / grid.rows)
            self.__dict__.pop("image", None)
        for own in out:
            yield iter((own,))

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: no chance."""
        return None


class Waves:
    """The engine of frequency sums: any source, any lens, any photosite."""

    finest = FINEST

    def plan(self, job: Job, samples: int | None = None, fields: FieldJob | None = None) -> WavesPlan:
        """Choose wavelengths; ``samples`` must be None."""
        if samples is not None:
            raise UnsupportedError("fourier takes none; only importance takes a number", key="samples")
        if not FINEST <= job.tolerance <= COARSEST:
            raise InvalidValueError(
                f"{job.tolerance:g} is outside {FINEST:g} … {COARSEST:g}, what the Fourier engine renders to",
                key="tolerance",
            )
        return planned(WavesPlan, job=job, fields=fields)


P = TypeVar("P", bound=WavesPlan)


def planned(kind: type[P], *, job: Job, **more: Any) -> P:
    """Return a plan of a kind, its wavelengths chosen."""
    first = kind(job=job, nodes=job.nodes(count=1), **more)
    wavelength_nm, density = first.fused(job.signals, job.tolerance)
    return dataclasses.replace(
        first, nodes=job.nodes_like(dataclasses.replace(first.nodes, wavelength_nm=wavelength_nm, density=density))
    )


def _wavelengths(job: Job, tolerance: float) -> int:
    """Return how many nodes tell a transfer at all wavelengths: it changes with them as a wavefront turns, else slowly.

    Measured on edges in daylight: 7 at 1e-4, 20 at 1e-6.
    """
    if not job.system.chromatic:
        return 1
    turned = wavefront_phase(job.system, job.signals.wavelength_nm) / (2.0 * math.pi)
    digits: float = max(-math.log10(tolerance), 1.0) ** DIGITS_POWER
    return math.ceil(digits + 2.0 + NODES_OF_WAVE * turned)


def _ringing(job: Job, tolerance: float) -> float:
    """Return from where on the ringing of all edges in sight stays within its share, pitches.

    Of a crowd ringing adds up as of random phases.
    """
    longest, count = float(job.blur.max()), max(4, len(job.edges))
    passes = max(job.system.ring_share(job.signals.wavelength_nm), 1e-3)
    loud = RINGING * passes * math.sqrt(min(count, 4000) / 4.0)
    return float(longest * (loud / (OF_RINGS * tolerance)) ** 0.4)


def spot_um(lens: OfPupil, wavelength_nm: float) -> float:
    """Return how far from the middle rays fall at the most: 2λN times the wavefront's slope, waves over a radius."""
    outer = 0.98 * lens.pupil.outer_radius
    angle = 2.0 * np.pi * np.arange(32) / 32
    radius = outer * np.array([[0.4], [0.7], [1.0]])
    x, y, step = (radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel(), 1e-3
    across = (lens.waves(x + step, y, wavelength_nm) - lens.waves(x - step, y, wavelength_nm)) / (2.0 * step)
    down = (lens.waves(x, y + step, wavelength_nm) - lens.waves(x, y - step, wavelength_nm)) / (2.0 * step)
    return 2.0 * lens.blur_um(wavelength_nm) * float(np.hypot(across, down).max())


def _farthest(source: Source, job: Job) -> float:
    """Return the largest distance of a source's corner from a photosite."""
    low, high = source.box
    first = np.array(job.grid.first_centre)
    last = first + np.array([job.grid.cols - 1, job.grid.rows - 1])
    return float(np.hypot(*np.maximum(np.abs(high - first), np.abs(last - low))))
