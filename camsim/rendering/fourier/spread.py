"""What the sizes of a transform depend on of the lens."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.gridded import held_bytes
from camsim.optics import OpticalSystem, RoundLens
from camsim.optics.protocols import (
    Fading,
    KnowsBands,
    KnowsEnergy,
    KnowsLine,
    KnowsNodes,
    KnowsReach,
    KnowsTail,
    Round,
    Separable,
    Span,
)
from camsim.products import product
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.fourier.fuses import Fuses
from camsim.rendering.fourier.prices import PER_PUPIL_SAMPLE, PER_ROUND_SAMPLE, PER_SUMMED_SAMPLE
from camsim.rendering.fourier.swings import swings
from camsim.rendering.fourier.taper import Hem
from camsim.rendering.psf import OF_LIGHT, is_summed, rule_of

BAND_STEPS, BAND_DIRECTIONS = 256, 12  # in which a round lens, and a footprint behind it, are asked what they pass
LOBE = 8.0  # directions for each period that a photosite's half extent holds: twice what follows its transfer round
SUMMED_BYTES = 90.0  # for each sample of a pattern by a non-uniform transform, its grid and all
ROUND_BYTES = 16.0  # of one that is known along its radius, and while it is weighed
IN_SIGHT = 8.0  # contrasts of full scale at once
NODES_OF = 5  # wavelengths that are asked how many nodes a pupil takes


def _no_nodes(distance: float) -> float:
    return 0.0


def _none_between(x: Span, y: Span) -> float:
    return 0.0


def _round_bytes(shape: tuple[int, int]) -> float:
    return ROUND_BYTES * math.prod(shape)


def _summed_bytes(shape: tuple[int, int]) -> float:
    return SUMMED_BYTES * math.prod(shape)


@dataclass(frozen=True, slots=True, kw_only=True)
class Kernel:
    """What the sizes depend on of a lens at all its wavelengths; lengths in pitches.

    cutoff  : highest frequency that is taken, cycles/pitch;  passes: and that it passes
    blur    : its shortest length (a pattern changes over a quarter of it)
    reach   : as far as its light matters; inf: as far as there is anything
    round   : the taper is round and the kernel a curve; else both are functions of x and y
    over_rectangle : they are, of a pattern that is round
    tapered : False for a pattern that has died away at ``reach`` by itself
    light   : how much light may lie beyond a distance, negative light counted as much
    line_nodes : nodes that all patterns of a round lens take out to a radius, of one that sums them
    pupil_nodes : nodes that all patterns of a lens that is not round take from where to where along x and along y
    rings   : (a, n): what the light beyond a distance R may leave of an edge outside the band, a·R⁻ⁿ; none if unknown
    longest : the longest wavelength's own length, of a lens that tells its rings
    hem     : the taper, where it is given
    tapers  : how many share what tapers may leave
    carries : how much of the light there is in it, at the most
    whole   : whether its transfers are made for a whole tile at once
    pattern_bytes : what is held while so many rows and columns of a pattern are made;  pattern_seconds: of each sample
    sooner  : by how much its band ends before the cut-off along x and along y, cycles/pitch
    """

    cutoff: float
    passes: float
    blur: float
    reach: float
    round: bool
    over_rectangle: bool
    tapered: bool
    light: Callable[[float], float]
    pupil_nodes: Callable[[Span, Span], float]
    line_nodes: Callable[[float], float] = _no_nodes
    rings: tuple[tuple[float, float], ...] = ()
    longest: float = 0.0
    hem: Hem | None = None
    tapers: int = 1
    carries: float = 1.0
    whole: bool = False
    pattern_bytes: Callable[[tuple[int, int]], float] = _summed_bytes
    pattern_seconds: float = PER_SUMMED_SAMPLE
    sooner: tuple[float, float] = (0.0, 0.0)

    def cuts(self, cut: float) -> tuple[float, float]:
        """Return the highest frequencies along x and along y of a band that ends at ``cut``."""
        return cut - self.sooner[0], cut - self.sooner[1]

    @property
    def sampled(self) -> bool:
        """Whether its transfers are made from its pattern on a lattice."""
        return self.tapered and not self.round and not self.whole

    def beyond(self, distance: float, edges: int) -> float:
        """Return what a taper that begins at ``distance`` works on: at most this of an image of so many edges."""
        beyond = self.light(distance)
        if self.rings:
            beyond = min(beyond, edges * sum(a * distance**-n for a, n in self.rings))
        return beyond


def kernel_of(
    system: OpticalSystem, wavelength_nm: F64, pitch_um: float, tolerance: float, *, over_rectangle: bool = False
) -> Kernel:
    """Return what the plan has to know of the lens at these wavelengths.

    over_rectangle : the lens is round, and its pattern is taken as a function of x and y
    """
    lens, more = system.lens, system.more
    cutoff = system.highest_per_um(wavelength_nm) * pitch_um
    blur = float(system.blurs_um(wavelength_nm).min()) / pitch_um
    reach = math.inf
    if isinstance(lens, KnowsTail):
        lost, heard = ErrorBudget(tolerance).allowed("reach"), system.ring_share(wavelength_nm)
        ends_nm = {float(wavelength_nm.min()), float(wavelength_nm.max())}
        reach = max(lens.reach_um(lost, nm, heard) for nm in ends_nm) / pitch_um
    elif len(known := [stage for stage in (lens, *more) if isinstance(stage, KnowsReach)]) == 1 + len(more):
        # What one blur takes to its reach, the next takes on from there.
        lost = ErrorBudget(tolerance).allowed("reach") / len(known)
        reach = max(sum(float(stage.reach_um(lost, nm)) for stage in known) for nm in wavelength_nm.tolist()) / pitch_um
    sooner = (0.0, 0.0)
    if isinstance(lens, KnowsBands):
        bands = np.max([lens.bands_per_um(nm) for nm in wavelength_nm.tolist()], axis=0) * pitch_um
        sooner = (cutoff - float(bands[0]), cutoff - float(bands[1]))
    is_round = isinstance(lens, Round) and not more and not over_rectangle
    faint = isinstance(lens, Fading) and lens.fades and not more
    rings: tuple[tuple[float, float], ...] = ()
    longest = 0.0
    if is_round and not faint and isinstance(lens, RoundLens):
        longest = float(system.blurs_um(wavelength_nm).max()) / pitch_um
        # Twice for a whole line, twice for the taper's step in what does not oscillate, four times to be sure:
        # with 4 in place of 16 random polygons came to 0.7 of the tolerance.
        rings = tuple((16.0 * ring.a, ring.n) for ring in swings(system, longest))
    pattern_bytes, pattern_seconds = _summed_bytes, PER_SUMMED_SAMPLE
    if over_rectangle:
        pattern_bytes, pattern_seconds = _round_bytes, PER_ROUND_SAMPLE
    elif isinstance(lens, KnowsNodes) and not is_summed(system):
        precision = OF_LIGHT * ErrorBudget(tolerance).allowed("pupil")
        pattern_bytes, pattern_seconds = functools.partial(held_bytes, precision=precision), PER_PUPIL_SAMPLE
    return Kernel(
        cutoff=cutoff,
        passes=cutoff,
        blur=blur,
        reach=reach,
        round=is_round,
        over_rectangle=over_rectangle,
        tapered=not faint,
        light=_light_beyond(system, wavelength_nm, pitch_um),
        pupil_nodes=_none_between if over_rectangle else _pupil_nodes(system, wavelength_nm, pitch_um),
        line_nodes=_line_nodes(lens, wavelength_nm, pitch_um) if isinstance(lens, KnowsLine) else _no_nodes,
        rings=rings,
        longest=longest,
        whole=isinstance(lens, Fuses) and not more,
        pattern_bytes=pattern_bytes,
        pattern_seconds=pattern_seconds,
        sooner=sooner,
    )


def with_band(
    known: Kernel, system: OpticalSystem, wavelength_nm: F64, shares: F64, contrast: F64, tolerance: float
) -> Kernel:
    """Return what is known of a round lens, and how far its band is taken.

    shares   : (sides, spectra) how much of each spectrum there is on every side
    contrast : (spectra, channels, j) what that gives
    """
    weights = (np.abs(shares).max(axis=0)[:, None, None] * contrast).reshape(-1, wavelength_nm.size)
    band = band_of(system, wavelength_nm, weights, known.passes, ErrorBudget(tolerance).allowed("band"))
    return dataclasses.replace(known, cutoff=band)


def band_of(system: OpticalSystem, wavelength_nm: F64, weights: F64, cutoff: float, allowed: float) -> float:
    """Return the frequency (of the unit of ``cutoff``) beyond which the whole system passes no more than is allowed.

    system  : its lens is round, the same in all directions
    weights : (n, j) of spectra against the background, in the unit of what is allowed

    An edge has 1/πf of every frequency across it; between two spectra it counts twice, and in sight of a photosite
    there are several.
    """
    f = cutoff * (np.arange(BAND_STEPS) + 0.5) / BAND_STEPS
    per_um = system.highest_per_um(wavelength_nm) / cutoff
    lens = np.stack([system.lens.otf(f * per_um, np.zeros(1), float(nm)) for nm in wavelength_nm])
    heard = np.abs(product(weights, lens)).max(axis=0, initial=0.0) / (math.pi * f)
    beyond = np.zeros(BAND_STEPS)
    for k in np.arange(BAND_DIRECTIONS)[:, None] + _beside(system, per_um * cutoff):
        x, y = (np.multiply.outer(part, f * per_um) for part in _along(k / BAND_DIRECTIONS))
        passes = heard * np.abs(system.footprint_otf(x, y)).max(axis=0)
        beyond = np.maximum(beyond, np.cumsum(passes[::-1])[::-1] * cutoff / BAND_STEPS)
    loud = np.flatnonzero(IN_SIGHT * beyond > allowed)
    return cutoff * float(loud[-1] + 1) / BAND_STEPS if loud.size else cutoff / BAND_STEPS


def _along(half_turns: float | F64) -> tuple[F64, F64]:
    """Return the unit vector of a direction."""
    return np.cos(math.pi * np.asarray(half_turns)), np.sin(math.pi * np.asarray(half_turns))


def _beside(system: OpticalSystem, cutoff_per_um: float) -> F64:
    """Return directions, parts of the step between two of the twelve, in which the footprint is asked beside each.

    A rectangle passes most along its sides, which are among them; another photosite along any direction, in a
    lobe that is the narrower the more periods it holds (a triangle behind a lens that passes 50 of them: 2°).
    """
    if isinstance(system.photosite, Separable) and system.photosite.separable:
        return np.zeros(1)
    periods = cutoff_per_um * float(np.hypot(*system.photosite.half_extent_um))
    return np.arange(-0.5, 0.5, BAND_DIRECTIONS / (BAND_DIRECTIONS + LOBE * periods))


def _pupil_nodes(system: OpticalSystem, wavelength_nm: F64, pitch_um: float) -> Callable[[Span, Span], float]:
    """Return what tells how many nodes the patterns at all wavelengths take between distances in pitches."""
    lens = system.lens
    if not isinstance(lens, KnowsNodes) or system.more:
        cutoffs = [system.cutoff_per_um(nm) * pitch_um for nm in wavelength_nm.tolist()]

        def summed(x: Span, y: Span) -> float:
            farthest = math.hypot(*(max(map(abs, span)) for span in (x, y)))
            return float(sum(math.prod(rule_of(cutoff * farthest)) for cutoff in cutoffs))

        return summed
    # Their numbers go with the wavelength: a few stand for all. Tiles, most of them alike, ask one by one.
    some = np.unique(np.linspace(0, wavelength_nm.size - 1, NODES_OF).round().astype(int))
    each, times = [lens.pupil_nodes(float(w)) for w in wavelength_nm[some]], wavelength_nm.size / some.size
    return functools.cache(
        lambda x, y: times * sum(nodes(_scaled(x, pitch_um), _scaled(y, pitch_um)) for nodes in each)
    )


def _line_nodes(lens: KnowsLine, wavelength_nm: F64, pitch_um: float) -> Callable[[float], float]:
    """Return what tells how many nodes the patterns at all wavelengths take out to a radius in pitches."""
    each = wavelength_nm.tolist()
    return functools.cache(lambda radius: sum(lens.line_nodes(radius * pitch_um, nm) for nm in each))


def _scaled(span: Span, by: float) -> Span:
    return span[0] * by, span[1] * by


def _light_beyond(system: OpticalSystem, wavelength_nm: F64, pitch_um: float) -> Callable[[float], float]:
    """Return what tells how much light may lie beyond a distance in pitches: all of it where the lens does not say.

    A pattern may have dark rings: what lies beyond is looked for farther out too, and taken twice. A radial curve may
    have negative ones: they count as much as the others.
    """
    lens = system.lens
    ends_nm = {float(wavelength_nm.min()), float(wavelength_nm.max())}
    if isinstance(lens, KnowsTail):
        tail, rings = lens.light_beyond, system.ring_share(wavelength_nm)
        return lambda distance: min(
            1.0, 2.0 * max(float(tail(np.array(distance * pitch_um), nm, rings)) for nm in ends_nm)
        )
    if not isinstance(lens, KnowsEnergy) or system.more:
        return lambda distance: 1.0
    if isinstance(lens, RoundLens) and lens.pattern().signed:
        pattern, blurs = lens.pattern(), [system.blur_um(nm) / pitch_um for nm in ends_nm]
        return lambda distance: max(pattern.absolute(distance / blur) for blur in blurs)
    energy = lens.encircled_energy
    farther = np.linspace(1.0, 1.5, 33)

    def light(distance: float) -> float:
        radius_um = distance * pitch_um * farther
        return min(1.0, 2.0 * max(float(np.abs(1.0 - energy(radius_um, nm)).max()) for nm in ends_nm))

    return light
