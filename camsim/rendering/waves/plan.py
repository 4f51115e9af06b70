"""Plan of a rendering by frequency sums: band limit, levels, wavelength nodes and cost."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

import numpy as np

from camsim.core.arrays import F64, I64, U8
from camsim.core.cached import cached_property
from camsim.core.tiled import Channels
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.optics import RoundLens
from camsim.optics.annular import AnnularAiry
from camsim.optics.of_pupil import OfPupil
from camsim.optics.protocols import Fading, KnowsReach
from camsim.optics.radial import RadialOtf
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.engine import FEWEST_CHECKED, FINEST, Cost, Decision, Marks, Progress
from camsim.rendering.fields.job import FieldJob
from camsim.rendering.fields.layer import Layer
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fields.samples import LONGEST_SQUARE, Support
from camsim.rendering.job import Job, Nodes
from camsim.rendering.spectral import Signals, fuse, kinds, wavefront_phase
from camsim.rendering.waves.edges import EdgeSource
from camsim.rendering.waves.fields import FieldSource
from camsim.rendering.waves.image import MOST_AT_ONCE, FrequencyImage, Source, summed_shape, tiles
from camsim.rendering.waves.levels import Level, Window, lattice_of, levels_of, reach_of
from camsim.rendering.waves.low import WIDER, LowFrequencies
from camsim.rendering.waves.transfers import Footprint, Lens
from camsim.rendering.work import Work

COARSEST = 1e-2
BESIDE_SUPPORT = 8.0  # pitches: margin for patches that extend into the support of the first level
NEAR, NEAR_OF_LARGE, LARGE = 24.0, 40.0, 700  # smallest reach of the first level, pitches, and side of a large frame
_share = ErrorBudget(1.0).allowed
OF_LIGHT, OF_BAND, OF_LEAK = _share("far light"), _share("band"), min(_share("windows"), _share("between points"))
OF_PRECISION, OF_TRANSFER, OF_MIXTURE = _share("spreading"), _share("transfers"), _share("mixtures")
OF_RINGS, OF_SPIKES = _share("ringing"), _share("spikes")
OF_ECHO = 0.3  # of the tolerance
HIDDEN = 0.4  # largest part of a spike that is lost where a corner cuts it
RINGING = 2.0 / math.pi**4  # amplitude of an edge's ringing: 8 end points' (λN/R)^{5/2}/4π⁴
CIRCLE_TAIL = 0.06  # an edge's light at R, over (p/a)·λN/R, behind a pupil of perimeter p and area a
STEEP, BENT = 20.0, 40.0  # scales of aberrations: spot radius in λN; waves per radian² along the rim
STRONGER = 3.5  # ringing behind an aberration of s such scales is stronger by 1 + STRONGER·s²
UNKNOWN = 4.0  # the same of a lens that is known by its transfer alone: its pupil may be obstructed, or have sides
RINGS_AT = 0.8, 0.85, 0.9, 0.95  # fractions of the cut-off at which an aberrated lens rings
MOST_OF_KINKS = 500.0  # pitches: farther, only curves that no lens has ring at tolerances that somebody takes
CROWD = 4000  # edges beyond which the bound on ringing grows no further
NEARLY_ALL = 0.92  # fraction of the lens's band from which all of it is taken: a picture's ringing is not estimated
DIGITS_POWER, NODES_OF_WAVE = 1.6, 2.0  # rule for the number of wavelengths
NEAR_ZERO, KINK_DIRECTIONS = 0.01, 720  # of the cut-off, and in half a turn: where straight sides are looked for
STEPS, DIRECTIONS = 256, 32  # samples of a system's transfer, along the radius and in angle
SECONDS_OF_EDGES, SECONDS_OF_FIELD, SECONDS_NODE = 6e-8, 2e-8, 1e-7  # per frequency; the last, per node
SECONDS_CURVE, SECONDS_POLAR = 4e-9, 2e-8  # per frequency and channel
SECONDS_TABLE = 0.01  # for a pupil's transfer at one wavelength
SECONDS_SAMPLE = 3.5e-7  # for a sample of a picture that is turned or cut
BYTES_EACH, BYTES_SUMMED = 32.0, 32.0  # per frequency, and per point of the summed lattice


@dataclass(frozen=True, kw_only=True, eq=False)
class WavesPlan:
    """A job, with the fields of its scene if there are any.

    nodes : wavelength nodes of the edges
    """

    job: Job
    nodes: Nodes
    settings: Waves
    fields: FieldJob | None = None

    summed: ClassVar = FrequencyImage

    @property
    def marks(self) -> Marks:
        """Plain marks: this engine adds none."""
        return Marks.plain(float(self.job.blur.max()))

    @property
    def fewest(self) -> int:
        """Smallest number of photosites that are checked: few, as an error of frequencies is everywhere."""
        return FEWEST_CHECKED // 2

    @property
    def wavelengths(self) -> int:
        """Number of wavelengths at which the optics are computed."""
        return self.nodes.wavelength_nm.size

    @cached_property
    def image(self) -> FrequencyImage | None:
        """The frequency sums of all sources; None for an empty scene."""
        job, tolerance = self.job, self.job.tolerance
        precision = max(1e-13, OF_PRECISION * self._finest)
        found: list[tuple[Source, F64, Lens]] = []
        if len(job.edges):
            nodes = self.nodes
            lens = self._lens(nodes.wavelength_nm, tolerance)
            density = nodes.density
            if not job.system.chromatic:
                density, lens = density.sum(axis=2, keepdims=True), self._lens(nodes.wavelength_nm[:1], tolerance)
            shares, contrast = kinds(density[1:] - density[0])
            mixture = lens.mixed(contrast, self._of_mixtures * tolerance)
            shares = np.einsum("sk,mk->sm", shares, mixture)
            weights = np.einsum("mk,kcj->mcj", mixture, contrast)
            frequency, size, footprint = self._passes(lens, weights)
            passes = frequency, size * footprint.max(axis=0)
            source = EdgeSource(edges=job.edges, shares=shares, precision=precision, passes=passes)
            found.append((source, weights, lens))
        if self.fields is not None:
            found += self._of_fields(self.fields, precision)
        if not found:
            return None
        image = self.on_levels(found)
        if len(image.levels) > 1:
            found = [(self._with_far(one, image.levels, precision), weights, lens) for one, weights, lens in found]
            image = dataclasses.replace(image, sources=found)
        return image

    def on_levels(self, sources: Sequence[tuple[Source, F64, Lens]]) -> FrequencyImage:
        """Return the image of sources, each with its weights and lens, on the levels of this plan."""
        job, tolerance = self.job, self._finest
        return self.summed(
            sources=sources,
            footprint=Footprint(system=job.system, pitch_um=job.grid.pitch_um),
            levels=self._levels(sources, tolerance),
            leak=OF_LEAK * tolerance,
        )

    @property
    def _finest(self) -> float:
        """The tolerance of the brightest light."""
        return self.job.tolerance if self.fields is None else self.job.tolerance / self.fields.brighter

    def _with_far(self, source: Source, levels: Sequence[Level], precision: float) -> Source:
        """Return a source whose far levels take fewer samples."""
        far, grid = tuple(level.cut for level in levels if not level.near), self.job.grid
        if far and isinstance(source, FieldSource):
            reach, first = reach_of(levels) + BESIDE_SUPPORT, np.array(grid.first_centre)
            last = first + np.array([grid.cols - 1, grid.rows - 1])
            source = source.thinning(far, Support(first - reach, last + reach, WIDER * far[0]))
            if source.far:
                return source
        for low in far[:2]:
            source = LowFrequencies(source=source, cut=low, precision=precision)
        return source

    def fused(self, signals: Signals, tolerance: float) -> tuple[F64, F64]:
        """Return the wavelength nodes (j,), and the weights (spectra, channels, j) of the signals at them."""
        return fuse(signals, phase=0.0, allowed=1.0, count=self.settings.wavelengths(self.job, tolerance))

    def _lens(self, wavelength_nm: F64, tolerance: float) -> Lens:
        return Lens(
            system=self.job.system,
            wavelength_nm=wavelength_nm,
            pitch_um=self.job.grid.pitch_um,
            allowed=float(f"{self.settings.rougher * OF_TRANSFER * tolerance:.6g}"),  # rounded: tables are shared
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
            mixture = lens.mixed(weights, self._of_mixtures * fields.tolerance)
            cut = self._band(lens, weights, fields.tolerance)
            yield self._source(layer, mixture, cut, precision), np.einsum("mk,kcj->mcj", mixture, weights), lens

    def _source(self, layer: Layer | PointLayer, mixture: F64, cut: float, precision: float) -> Source:
        return FieldSource(layer=layer, mixture=mixture, cut=cut, precision=precision)

    def _band(self, lens: Lens, weights: F64, tolerance: float) -> float:
        """Return the band limit, cycles/pitch: above it, four edges have at most their share of the error."""
        frequency, size, footprint = self._passes(lens, weights)
        highest = frequency[0] + frequency[-1]
        passes = size * footprint.max(axis=0)
        beyond = np.cumsum((passes / frequency)[::-1])[::-1] * (4.0 / math.pi * highest / STEPS)
        if (rings := self.job.rings) is not None:
            beyond = np.maximum(beyond, rings.beyond(size * footprint.mean(axis=0), highest))  # concentric edges
        allowed = OF_BAND * tolerance
        passing = int(np.count_nonzero(beyond > allowed))
        if self.fields is not None and passing >= NEARLY_ALL * STEPS:
            passing = STEPS
        return float(highest * max(passing, 8) / STEPS)

    def _passes(self, lens: Lens, weights: F64) -> tuple[F64, F64, F64]:
        """Return frequencies (STEPS,), cycles/pitch, the lens's transfer at them, and the footprint's by direction."""
        pitch_um = self.job.grid.pitch_um
        highest = self.job.system.highest_per_um(lens.wavelength_nm) * pitch_um
        frequency = highest * (np.arange(STEPS) + 0.5) / STEPS
        angle = np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        fx, fy = np.outer(np.cos(angle), frequency) / pitch_um, np.outer(np.sin(angle), frequency) / pitch_um
        footprint = np.abs(self.job.system.footprint_otf(fx, fy))
        return frequency, lens.size(frequency, np.abs(weights).max(axis=(0, 1))), footprint

    def _compact(self, boxes: Sequence[tuple[F64, F64]]) -> float:
        """Return the diameter of scenery whose light falls with the PSF; infinite for a pupil that may have sides."""
        if self._has_sides:
            return math.inf
        size = np.max([high for _, high in boxes], axis=0) - np.min([low for low, _ in boxes], axis=0)
        points = sum(float(layer.light.sum()) for layer in self._layers if isinstance(layer, PointLayer))
        return math.hypot(*size.tolist(), math.sqrt(2.0 * points))

    def _levels(self, sources: Sequence[tuple[Source, F64, Lens]], tolerance: float) -> Sequence[Level]:
        job, system = self.job, self.job.system
        cut = max(self._band(lens, weights, tolerance) for _, weights, lens in sources)
        farthest = max(_farthest(source, job) for source, *_ in sources)
        boxes = [source.box for source, *_ in sources]
        pitch_um, extent = job.grid.pitch_um, job.extent
        lens, longest = system.lens, float(job.blur.max())
        lost, leak, wavelengths = OF_LIGHT * tolerance, OF_LEAK * tolerance, job.signals.wavelength_nm
        if isinstance(lens, Fading) and lens.fades and isinstance(lens, KnowsReach) and not system.more:
            reach = (
                max(lens.reach_um(0.1 * lost, nm) for nm in (float(wavelengths[0]), float(wavelengths[-1]))) / pitch_um
            )
            return levels_of(cut, reach + extent + self._support, lost, leak, 0.0)
        near = NEAR if max(job.grid.rows, job.grid.cols) <= LARGE else NEAR_OF_LARGE
        tail = 2.0 * CIRCLE_TAIL * longest / (1.0 - _obstruction(lens))
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
        hardly = spikes = 0.0
        if self._has_sides:
            allowed = OF_SPIKES * self.settings.rougher * tolerance
            again = max(farthest, self._again(boxes, allowed))
            beyond = max(self._beyond(lens, weights, leak) for _, weights, lens in sources)
            hardly, spikes = (min(part * self._thrown / allowed, again) for part in (beyond, HIDDEN))
        if job.rings is not None:
            light = np.abs(job.signals.density).sum(axis=(0, 1))
            near = max(near, job.rings.reach(job.blur, light / light.sum(), _strength(job), OF_RINGS * tolerance))
        crowded, followed = self.fields is not None, self.settings.rougher * tolerance
        near = max(
            near,
            _ringing(job, tolerance, crowded=crowded),
            _slow(job, followed),
            _kinked(job, tolerance),
            2.0 * longest,
        )
        nearer, more = self.settings.nearer, spot + extent
        first = max(self.settings.farther * (near + more), nearer * (hardly + more)) + self._support
        passed = nearer * (spikes + more) + self._support
        return levels_of(cut, first, lost, leak, tail, extent, self._compact(boxes), passed)

    @property
    def _layers(self) -> Sequence[Layer | PointLayer]:
        return () if self.fields is None else self.fields.layers

    @property
    def _support(self) -> float:
        """Half the diagonal of a picture's largest spline, pitches: samples are selected by their centres."""
        each = (
            (layer.degree + 1) * min(layer.step, LONGEST_SQUARE) for layer in self._layers if isinstance(layer, Layer)
        )
        return math.sqrt(0.5) * max(each, default=0.0)

    def _beyond(self, lens: Lens, weights: F64, leak: float) -> float:
        """Return the most that an edge's light beyond the window of what photosites pass can be, of all its light."""
        frequency, size, footprint = self._passes(lens, weights)
        beyond = (1.0 - Window.passed(leak).at(frequency)) * size * footprint.max(axis=0)
        return float((beyond / frequency).sum() * 2.0 * frequency[0] / math.pi)

    def _again(self, boxes: Sequence[tuple[F64, F64]], allowed: float) -> float:
        """Return the reach from which on the spikes of scenery that ends, at all periods, are within the tolerance.

        It appears again at every period to both sides: in all, π²/3 of the part of the spike that falls within its
        width.
        """
        width = max(float(np.hypot(*np.subtract(*box))) for box in boxes)
        return math.sqrt(math.pi**2 / 3.0 * self._thrown * width / allowed)

    @property
    def _has_sides(self) -> bool:
        """Whether the pupil may have straight sides, whose spikes take a share of the tolerance."""
        lens = self.job.system.lens
        return not isinstance(lens, RoundLens | Fading) and not (
            isinstance(lens, OfPupil) and lens.pupil.shape == "circular"
        )

    @property
    def _of_mixtures(self) -> float:
        """Share of the tolerance for mixtures: larger where neither spikes nor an obstruction take theirs."""
        taken = self._has_sides or _obstruction(self.job.system.lens) > 0.0
        return OF_MIXTURE + (0.0 if taken else OF_SPIKES - _share("bent edges"))

    @cached_property
    def _thrown(self) -> float:
        """Light that the straight sides of a pupil throw beyond r, times r in pitches.

        A side of length l of a pupil of area a, in half diameters, diffracts (l/2π²a)·λN/r of the light beyond r, in
        both directions perpendicular to the side; opposite sides add up. Spikes stay as narrow as λN at any distance,
        so no coarser level can represent them; the part of a spike that a corner hides beyond the reach is lost.

        Near frequency 0 the transfer of an unknown pupil falls by c(φ)·f. Opposite sides of length l give c a kink
        perpendicular to them, a step of its slope by 4π² times what they throw.
        """
        lens = self.job.system.lens
        if isinstance(lens, OfPupil):
            sides = 1.0 if lens.pupil.sides % 2 else 2.0
            return sides * lens.pupil.side_length * float(self.job.blur.max()) / (2.0 * math.pi**2 * lens.pupil.area)
        system, pitch_um = self.job.system, self.job.grid.pitch_um
        nm = float(self.job.signals.wavelength_nm[-1])
        frequency = NEAR_ZERO * system.highest_per_um(np.array([nm]))
        angle = np.pi * np.arange(KINK_DIRECTIONS) / KINK_DIRECTIONS
        transfer = np.abs(system.point_otf(frequency * np.cos(angle), frequency * np.sin(angle), nm))
        falls = (1.0 - transfer) / (frequency * pitch_um)
        bend = np.roll(falls, 1) - 2.0 * falls + np.roll(falls, -1)
        both = bend + np.roll(bend, -1)  # a kink lies between two directions
        sharp = both - 0.5 * (np.roll(both, 4) + np.roll(both, -4))
        return float(sharp.max()) * KINK_DIRECTIONS / (4.0 * math.pi**3)

    def _spot_um(self, wavelength_nm: float) -> float:
        """Return the largest distance of a ray from the centre of the spot."""
        lens = self.job.system.lens
        assert isinstance(lens, OfPupil)
        return spot_um(lens, wavelength_nm)

    @cached_property
    def _lattices(self) -> list[tuple[int, int]]:
        """Numbers of frequencies and of points of the summed lattice, for every level and tile."""
        image = self.image
        if image is None:
            return []
        grid, (low, high) = self.job.grid, image.box
        at, found = np.array(grid.first_centre), []
        whole = 0, 0, grid.rows, grid.cols
        for level in image.levels:
            for row, col, height, width in tiles((grid.rows, grid.cols)) if level.near else (whole,):
                here = at + np.array([col, row], float)
                lattice = lattice_of(level, (width, height), low - here, high - here)
                found.append((lattice.size, math.prod(summed_shape(lattice, level.every, -(-height // level.every)))))
        return found

    @property
    def _frequencies(self) -> int:
        return sum(size for size, _ in self._lattices)

    @cached_property
    def cost(self) -> Cost:
        """Seconds and memory of one image."""
        image = self.image
        if image is None:
            return Cost(seconds=0.0, memory_bytes=0.0)
        each = 0.0
        for k, (_, weights, lens) in enumerate(image.sources):
            transform = SECONDS_OF_EDGES if k < min(1, len(self.job.edges)) else SECONDS_OF_FIELD
            each += len(weights) * (transform + weights.shape[1] * (SECONDS_CURVE if lens.is_round else SECONDS_POLAR))
        nodes = 8.0 * len(self.job.edges)
        seconds = self._frequencies * each + nodes * SECONDS_NODE
        most = max(len(weights) for _, weights, _ in image.sources)
        tables = sum(len(lens.wavelength_nm) * SECONDS_TABLE for *_, lens in image.sources if not lens.is_round)
        bytes_each = most * BYTES_EACH, image.sources[0][1].shape[1] * BYTES_SUMMED
        at_once = MOST_AT_ONCE / most if image.in_parts else math.inf
        memory = max(min(size, at_once) * bytes_each[0] + places * bytes_each[1] for size, places in self._lattices)
        samples = sum(math.prod(layer.shape) * layer.planes for layer in self._layers if not layer.upright)
        samples += sum(math.prod(layer.shape) for layer in self._layers if layer.outline is not None and layer.upright)
        return Cost(seconds=0.005 + seconds + tables + SECONDS_SAMPLE * samples, memory_bytes=memory)

    def work(self, images: int) -> Work:
        """Count the work of ``images`` images."""
        grid = self.job.grid
        return Work(
            edges=len(self.job.edges),
            wavelength_nodes=self.wavelengths,
            channels=images,
            photosites=images * grid.rows * grid.cols,
            frequencies=self._frequencies,
            samples_of_pictures=sum(math.prod(layer.shape) for layer in self._layers),
        )

    def decisions(self) -> Iterator[Decision]:
        """Yield the decisions that are reported to the user."""
        image = self.image
        if image is None:
            return
        for layer in self._layers:
            decision, reason = layer.said
            yield Decision(topic=layer.kind, decision=decision, reason=reason)
        if coarser := sum(not level.near for level in image.levels):
            yield Decision(
                topic="far light",
                decision=f"beyond {reach_of(image.levels):.3g} photosites on {coarser} coarser lattices",
                reason="the lens's tail is smooth there",
            )
        yield Decision(
            topic="settings",
            decision=f"{self._frequencies:.2g} frequencies, up to {image.levels[0].cut:.3g} cycles a pitch",
            reason="lens, OLPF and photosite pass nothing beyond that counts",
        )

    def of(self, job: Job) -> WavesPlan:
        """Return the same plan for a job with other edges, without pictures."""
        return dataclasses.replace(self, job=job, nodes=job.nodes_like(self.nodes), fields=None)

    def bands(self, channel: Channels, progress: Progress) -> Iterator[F64]:
        """Yield the image in bands of a tile's height; ``channel`` gives the channel of each photosite."""
        grid, image = self.job.grid, self.image
        base = self.job.base
        if image is None:
            yield base[channel[:]]
            progress(1.0)
            return
        band: F64 | None = None
        for rows, cols, planes in image.planes(grid.first_centre, (grid.rows, grid.cols)):
            one = channel[rows]
            if band is None:
                band = base[one]
            for k, plane in enumerate(planes):
                np.add(band[:, cols], plane, out=band[:, cols], where=one[:, cols] == k)
            if cols.stop == grid.cols:
                yield band
                band = None
                progress(rows.stop / grid.rows)

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield several images, each as one band; the sums of all channels are computed once."""
        grid, image, base = self.job.grid, self.image, self.job.base
        out = base[channels]
        if image is not None:
            for rows, cols, planes in image.planes(grid.first_centre, (grid.rows, grid.cols)):
                for one, channel in zip(out, channels, strict=True):
                    for k, plane in enumerate(planes):
                        np.add(one[rows, cols], plane, out=one[rows, cols], where=channel[rows, cols] == k)
                progress(rows.stop / grid.rows)
        for one in out:
            yield iter((one,))

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: the method is deterministic."""
        return None


@dataclass(frozen=True, kw_only=True)
class Waves:
    """The engine of frequency sums, for any source, lens and photosite.

    farther, nearer, finer : factors of the first level's reach, of that for spikes, and of the number of wavelengths;
                             the check uses others than the image
    rougher        : factor of the tolerance for transfer tables, spikes and slow oscillations; the check uses it to
                     keep the image's tolerance
    """

    farther: float = 1.0
    nearer: float = 1.0
    finer: float = 1.0
    rougher: float = 1.0

    def plan(self, job: Job, samples: int | None = None, fields: FieldJob | None = None) -> WavesPlan:
        """Choose wavelengths; ``samples`` must be None."""
        if samples is not None:
            raise UnsupportedError("fourier takes none; only importance takes a number", key="samples")
        if not FINEST <= job.tolerance <= COARSEST:
            raise InvalidValueError(
                f"{job.tolerance:g} is outside {FINEST:g} … {COARSEST:g}, what the Fourier engine renders to",
                key="tolerance",
            )
        return planned(WavesPlan, job=job, fields=fields, settings=self)

    def wavelengths(self, job: Job, tolerance: float) -> int:
        """Return the number of wavelength nodes that resolves a transfer over the spectrum.

        A wavefront's phase adds nodes, since the transfer then changes fast with wavelength. Ringing that a continuous
        spectrum averages out revives where the path difference between neighbouring nodes is one wave; the nodes are
        dense enough for this to happen only where ringing is below the tolerance.
        """
        if not job.system.chromatic:
            return 1
        turned = wavefront_phase(job.system, job.signals.wavelength_nm) / (2.0 * math.pi)
        digits: float = max(-math.log10(min(self.rougher * tolerance, 0.1)), 1.0) ** DIGITS_POWER
        counted = _ringing(job, OF_ECHO / OF_RINGS * self.rougher * tolerance)
        apart = float(1.0 / job.blur.min() - 1.0 / job.blur.max())
        echoes = min(counted * apart, job.span * apart + digits) if len(job.edges) else counted * apart
        return math.ceil(self.finer * math.ceil(max(digits, echoes) + 2.0 + NODES_OF_WAVE * turned))


def _ringing(job: Job, tolerance: float, *, crowded: bool = False) -> float:
    """Return the distance from which on the ringing of all edges stays within its share of the error, pitches.

    The ringing of many edges, as in a picture, adds up with random phases.
    """
    longest, count = float(job.blur.max()), CROWD if crowded else min(max(4.0, job.edges.turning), CROWD)
    strength = RINGING * _strength(job) * math.sqrt(count / 4.0)
    return float(longest * (strength / (OF_RINGS * tolerance)) ** 0.4)


def _strength(job: Job) -> float:
    """Return the ringing amplitude of an edge relative to a clear, unaberrated lens sampled at points.

    With aberrations, ringing also has frequencies below the cut-off, where the photosite's footprint passes more.
    """
    wavelengths, lens = job.signals.wavelength_nm, job.system.lens
    passes = max(job.system.ring_share(wavelengths), 1e-3)
    hole = _obstruction(lens)  # ringing of the inner rim adds to that of the outer
    stronger = (1.0 + math.sqrt(hole)) ** 2 / (1.0 - hole**2)
    if isinstance(lens, OfPupil):
        slope = spot_um(lens, float(wavelengths[0])) / lens.blur_um(float(wavelengths[0]))
        angle, every = np.arange(256) * (math.pi / 128), math.pi / 128
        rim = lens.waves(np.cos(angle), np.sin(angle), float(wavelengths[0]))
        bend = np.abs(np.roll(rim, 1) - 2.0 * rim + np.roll(rim, -1)).max() / every**2
        steep = (slope / STEEP) ** 2 + (float(bend) / BENT) ** 2
        passes += min(steep, 1.0) * max(job.system.ring_share(wavelengths, share) for share in RINGS_AT)
        stronger *= 1.0 + STRONGER * steep
    elif not isinstance(lens, RoundLens | Fading):
        stronger *= UNKNOWN
    return stronger * passes


def _kinked(job: Job, tolerance: float) -> float:
    """Return the distance from which on the ringing of a given curve's bends stays within its share, pitches.

    Where its slope changes by s at the frequency f, four edges at the distance R ring by s/(π³fR²), or by s/(2π⁴fwR³)
    if the change takes a width w, the distance of two points. At its end a curve has no width.
    """
    lens = job.system.lens
    if not isinstance(lens, RadialOtf):
        return 0.0
    frequency, values = (np.array(one) for one in (lens.freq_per_um, lens.values))
    frequency = frequency * job.grid.pitch_um
    width = np.diff(frequency)
    bends = np.abs(np.diff(np.diff(values) / width, append=0.0))
    shares = [job.system.ring_share(job.signals.wavelength_nm, one) for one in (frequency[1:] / frequency[-1]).tolist()]
    rings = bends * np.array(shares) / (math.pi**3 * frequency[1:] * OF_RINGS * tolerance)
    wide: float = float(np.sum(rings[:-1] / (2.0 * math.pi * np.minimum(width[1:], width[:-1])))) ** (1.0 / 3.0)
    return min(max(math.sqrt(float(rings[-1])), min(math.sqrt(float(rings[:-1].sum())), wide)), MOST_OF_KINKS)


def _slow(job: Job, tolerance: float) -> float:
    """Return the distance from which on the slow oscillation of a straight edge stays within its share, pitches.

    An obstruction causes it: the inner and the outer rim on the same side interfere. It uses the share of spikes, which
    a round lens lacks.
    """
    hole = _obstruction(job.system.lens)
    if not hole:
        return 0.0
    share = 0.5 - 0.5 * hole
    strength = 2.0 * math.sqrt(hole) * job.system.ring_share(job.signals.wavelength_nm, share) / share**1.5
    return float(job.blur.max() * (0.25 * RINGING * strength / (1.0 - hole**2) / (OF_SPIKES * tolerance)) ** 0.4)


def _obstruction(lens: object) -> float:
    """Return the diameter of a lens's central obstruction over that of the pupil."""
    if isinstance(lens, OfPupil):
        return lens.pupil.obstruction
    return lens.obstruction if isinstance(lens, AnnularAiry) else 0.0


def spot_um(lens: OfPupil, wavelength_nm: float) -> float:
    """Return the spot's largest ray displacement: 2λN times the wavefront's slope in waves per pupil radius."""
    outer = 0.98 * lens.pupil.outer_radius
    angle = 2.0 * np.pi * np.arange(32) / 32
    radius = outer * np.array([[0.4], [0.7], [1.0]])
    x, y, step = (radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel(), 1e-3
    dx, dy = step * np.array([(1, -1, 0, 0), (0, 0, 1, -1)])[..., None]
    right, left, below, above = lens.waves((x + dx).ravel(), (y + dy).ravel(), wavelength_nm).reshape(4, -1)
    across, down = (right - left) / (2.0 * step), (below - above) / (2.0 * step)
    return 2.0 * lens.blur_um(wavelength_nm) * float(np.hypot(across, down).max())


def _farthest(source: Source, job: Job) -> float:
    """Return the largest distance between a corner of a source's box and a photosite, pitches."""
    low, high = source.box
    first = np.array(job.grid.first_centre)
    last = first + np.array([job.grid.cols - 1, job.grid.rows - 1])
    return float(np.hypot(*np.maximum(np.abs(high - first), np.abs(last - low))))


P = TypeVar("P", bound=WavesPlan)


def planned(kind: type[P], *, job: Job, **more: Any) -> P:
    """Return a plan of class ``kind`` with its wavelength nodes chosen."""
    first = kind(job=job, nodes=job.nodes(count=1), **more)
    wavelength_nm, density = first.fused(job.signals, job.tolerance)
    nodes = dataclasses.replace(first.nodes, wavelength_nm=wavelength_nm, density=density)
    return dataclasses.replace(first, nodes=job.nodes_like(nodes))
