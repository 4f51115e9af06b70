"""A lens with aberrations as a round lens, moved, and what it has besides: a pattern of no light in all, and short.

A pattern's tail comes from the pupil's rim. Where that is a circle, so is the tail, moved by the wavefront's slope
there. With f in 1/λN the transfer along u begins 1 − (4/π)·f·⟨exp(4πi·f·s)⟩, s the slope ∂W/∂u on the rim in waves per
radius and ⟨⟩ its mean, weighed by |normal·u|; terms that are even and smooth in f leave nothing far away. So, x λN
from a straight edge, an aberrated pattern shows (2/π³)·⟨1/(x − 2s)⟩ where a round one shows (2/π³)/x: rays of the rim,
each where its slope sends it. With the mean slope taken as a move of 2·⟨s⟩·λN, what is left falls as

    (4/π³)·⟨s⟩/x² + (8/π³)·⟨s²⟩/x³ + …        (s about the move)

where the first term is what no move can take: three-leaved and higher odd aberrations. The rings differ in phase, and
in size by slopes over x. Nearer than the rays of all of the pupil go, 2·max|s|, all may differ.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
import scipy

from camsim.arrays import F64
from camsim.optics.protocols import Round, RoundLens, Span
from camsim.optics.rim import Bent, Rim, rim_of
from camsim.optics.rim_light import COARSE, FINE, Circle, light_between_rings, light_without_waves, wavefront_about
from camsim.radial_profile import MIDDLE, on_lattice

TAIL = 2.0 / math.pi**3
RING = 1.0 / (2.0 * math.pi**4)  # what a line hears of an Airy pattern's rings, times x^(−5/2) (boundary/settings.py)
STEEPER = 30.0  # rings · waves of slope / x: what amplitudes at the rim differ by; 27 was measured of coma
MORE = 1.2  # directions between, and the next terms: 1.02 was measured
RAYS, BEYOND_RAYS = 4.0, 3.0  # slopes, and λN more: as near as the tail is taken to be the rim's alone
FARTHEST = 1e7  # λN: where a reach is looked for
HALVINGS = 14  # a reach is found to a thousandth
FEWEST_ROUND, MOST_ROUND = 32, 256  # directions of the light between rings


class Core(RoundLens, Round, Protocol):
    """A round lens that knows its pattern."""


class Split(NamedTuple):
    """A lens as two: ``core`` with its pattern moved by ``moved_um`` (x, y), and ``rest``, None where there is none."""

    core: Core
    moved_um: tuple[float, float]
    rest: Difference | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """What a lens has besides a round one that is moved: a transfer that is 0 at 0, a pattern of either sign.

    lens        : the whole;  core: the round part;  obstruction: of both, 0 … 1
    moved_um    : where the core's pattern has its centre
    scale       : times as far as need be: the reach, and from where on the rim's light is taken for the pattern
    off_um      : how far from the move distances are counted; 0: about it
    """

    place: ClassVar[str] = "lens"

    lens: Bent
    core: Core
    obstruction: float
    moved_um: tuple[float, float]
    scale: float = 1.0
    off_um: float = 0.0

    @property
    def about_axis(self) -> Difference:
        """The same with distances counted about the axis, where its pattern is moved and nothing else is."""
        return replace(self, off_um=math.hypot(*self.moved_um))

    def blur_um(self, wavelength_nm: float) -> float:
        """The length of the pattern without aberrations, µm: λN."""
        return self.lens.blur_um(wavelength_nm)

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """The frequency beyond which nothing passes, cycles/µm."""
        return self.lens.cutoff_per_um(wavelength_nm)

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """Transfer of the whole less that of the core."""
        turn = np.exp(-2j * np.pi * (fx_per_um * self.moved_um[0] + fy_per_um * self.moved_um[1]))
        difference: F64 = self.lens.otf(fx_per_um, fy_per_um, wavelength_nm) - turn * self.core.otf(
            fx_per_um, fy_per_um, wavelength_nm
        )
        return difference

    def point_spread_rows(
        self, x_um: F64, y_um: F64, wavelength_nm: float, precision: float
    ) -> Iterator[tuple[slice, F64]]:
        """Yield rows of the irradiance (y, x) per µm² of unit power, less the core's; see ``OfPupil``."""
        from camsim.kernels import shared  # with Numba, which no lens needs before it is rendered
        from camsim.kernels.round import add_round

        core = functools.partial(self.core.point_spread, wavelength_nm=wavelength_nm)
        places = x_um - self.moved_um[0], y_um - self.moved_um[1]
        powers, x, y = on_lattice(core, self.blur_um(wavelength_nm), *places)
        less = -powers

        def less_core(pattern: F64, y: F64, begin: int, stop: int) -> None:
            add_round(pattern[begin:stop], less, MIDDLE, x, y[begin:stop])

        for rows, pattern in self.lens.point_spread_rows(x_um, y_um, wavelength_nm, precision):
            shared(len(pattern), functools.partial(less_core, pattern, y[rows].copy()))
            yield rows, pattern

    def pupil_nodes(self, wavelength_nm: float) -> Callable[[Span, Span], float]:
        """Return what tells how many nodes the pattern takes from where to where along x and along y in µm."""
        return self.lens.pupil_nodes(wavelength_nm)

    def waves_turned(self, low_nm: float, high_nm: float) -> float:
        """Return by how many waves the path difference turns between two wavelengths, over the pupil."""
        return self.lens.waves_turned(low_nm, high_nm)

    def steepest_waves(self, wavelength_nm: float) -> float:
        """Return how steep the path difference is about the move, anywhere in the pupil, waves per radius."""
        return _rim_of(self, wavelength_nm).inside_waves

    def light_beyond(self, distance_um: F64, wavelength_nm: float, rings: float = 1.0) -> F64:
        """Return how much a straight edge of contrast 1 may show at distances and beyond; 1 where nothing is known.

        The edge is so far away, or is nearer and goes on so far ahead.
        rings : what is left of the rings by what else stands in the light's way
        """
        rim = _rim_of(self, wavelength_nm)
        x = (np.asarray(distance_um, float) - self.off_um) / self.blur_um(wavelength_nm)
        nearest = max(RAYS * rim.inside_waves + BEYOND_RAYS, 0.5)
        far = np.maximum(x, nearest)[..., None, None]
        tail = np.abs(np.sum(rim.share / (far - 2.0 * rim.slope_waves), axis=-1) - 1.0 / far[..., 0]).max(axis=-1)
        far = far[..., 0, 0]
        first, second = rim.ahead_waves
        ahead = first / far**2 + second / far**3
        light = MORE * np.maximum(TAIL * tail / (1.0 - self.obstruction), ahead) + self._swing(rim, far, rings)
        bound: F64 = np.where(x < nearest, 1.0, np.minimum(light, 1.0))
        return bound

    @property
    def slowest_ring(self) -> float:
        """Frequency of the slowest ring times λN: across the hole, or of its rim and the outer one on one side."""
        hole = self.obstruction
        return min(hole, 0.5 * (1.0 - hole)) if hole else 1.0

    def rings_beyond(self, distance_um: F64, wavelength_nm: float, rings: float) -> F64:
        """Return how much of that is rings.

        Behind an obstruction the two rims make slower ones, which nothing else need stop: of f times the frequency
        a line hears f^(−3/2) times as much, of the inner rim's amplitude √ε.
        """
        x = np.maximum((np.asarray(distance_um, float) - self.off_um) / self.blur_um(wavelength_nm), 0.5)
        swing, hole = self._swing(_rim_of(self, wavelength_nm), x, rings), self.obstruction
        if hole:
            times = hole**-0.5 + 2.0 * hole**0.5 * sum((0.5 * (1.0 + sign * hole)) ** -1.5 for sign in (1.0, -1.0))
            swing = swing + 2.0 * MORE * RING * times / (1.0 - hole) * x**-2.5
        return swing

    def _swing(self, rim: Rim, far: F64, rings: float) -> F64:
        loud = min(2.0, rim.rings_rad) + STEEPER * rim.steepest_waves / far
        swing: F64 = MORE * rings * RING * loud * far**-2.5 / (1.0 - self.obstruction)
        return swing

    def rim_light(self, distance_um: F64, wavelength_nm: float, directions: int) -> F64:
        """Return the light between the rings, 1/µm², at distances (n,) and in so many even directions from x on."""
        return self._between_rings(distance_um, wavelength_nm, directions, COARSE)

    def rim_known(self, allowed: float, wavelength_nm: float) -> tuple[float, int]:
        """Return from where on that is right but for so much light in all, µm, and in how many directions it is known.

        Nowhere: from infinity on.
        """
        return _known(self, allowed, wavelength_nm)

    def _between_rings(self, distance_um: F64, wavelength_nm: float, directions: int, nodes: tuple[int, int]) -> F64:
        blur_um, circles = self.blur_um(wavelength_nm), (1.0, self.obstruction) if self.obstruction else (1.0,)
        rims = _rims_of(self, circles, wavelength_nm)
        if rims is None:
            return np.full((len(distance_um), directions), np.nan)
        angle = 2.0 * np.pi * np.arange(directions) / directions
        x, y = (np.multiply.outer(distance_um, way(angle)) for way in (np.cos, np.sin))
        from_core = np.hypot(x - self.moved_um[0], y - self.moved_um[1])
        light: F64 = light_between_rings(rims, distance_um / blur_um, directions, nodes)
        light = light - light_without_waves(circles, from_core / blur_um)
        return light / blur_um**2

    def reach_um(self, lost_fraction: float, wavelength_nm: float, rings: float = 1.0) -> float:
        """Return a distance beyond which ``light_beyond`` is at most that, µm."""
        return self.scale * _reach_um(self, lost_fraction, wavelength_nm, rings)


@dataclass(frozen=True, slots=True, kw_only=True)
class RoundDifference(Difference):
    """What a lens has besides a round one where its wavefront is one of revolution: a round pattern, not moved."""

    def point_spread(self, r_um: F64, wavelength_nm: float) -> F64:
        """Irradiance at ``r_um`` from a point of unit power, less the core's, 1/µm²."""
        own = self.lens.point_spread_round(r_um, wavelength_nm)
        difference: F64 = own - self.core.point_spread(r_um, wavelength_nm)
        return difference

    def line_nodes(self, r_um: float, wavelength_nm: float) -> float:
        """Return how many nodes that takes out to a radius."""
        return self.lens.line_nodes(r_um, wavelength_nm)

    @property
    def on_lattice(self) -> Difference:
        """The same as any other, whose pattern is taken on a lattice: no farther than it is asked for either way."""
        known = {field.name: getattr(self, field.name) for field in fields(Difference)}
        return Difference(**known)


@functools.lru_cache(maxsize=256)
def _reach_um(rest: Difference, lost_fraction: float, wavelength_nm: float, rings: float) -> float:
    blur_um = rest.blur_um(wavelength_nm)
    low, high = 0.0, math.log(FARTHEST)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        loud = rest.light_beyond(np.array(math.exp(middle) * blur_um), wavelength_nm, rings) > lost_fraction
        low, high = (middle, high) if loud else (low, middle)
    return math.exp(high) * blur_um


@functools.lru_cache(maxsize=256)
def _known(rest: Difference, allowed: float, wavelength_nm: float) -> tuple[float, int]:
    """Try distances one after the other, from as near as the rim may have the light to itself."""
    blur_um = rest.blur_um(wavelength_nm)
    r = blur_um * (RAYS * _rim_of(rest, wavelength_nm).inside_waves + BEYOND_RAYS) + rest.off_um
    while r < FARTHEST * blur_um:
        coarse, fine = (
            rest._between_rings(np.array([r]), wavelength_nm, MOST_ROUND, rule)[0] for rule in (COARSE, FINE)
        )
        # What falls as 1/r⁴ or faster: πr² times as much lies beyond.
        wrong, waves = math.pi * r * r * float(np.abs(coarse - fine).max()), np.abs(scipy.fft.rfft(coarse)) / MOST_ROUND
        if wrong <= allowed:
            loud = np.flatnonzero(math.pi * r * r * waves > allowed)
            highest = int(loud[-1]) + 1 if loud.size else 1
            directions = max(FEWEST_ROUND, 8 * math.ceil(2.5 * highest / 8.0))
            if directions <= MOST_ROUND:
                return r, directions
        r *= 2.0**0.5
    return math.inf, MOST_ROUND


@functools.lru_cache(maxsize=256)
def _rims_of(rest: Difference, circles: tuple[float, ...], wavelength_nm: float) -> tuple[Circle, ...] | None:
    """Return the wavefront about the pupil's circles."""

    def waves(x: F64, y: F64) -> F64:
        return rest.lens.waves(x, y, wavelength_nm)

    found = [wavefront_about(waves, radius) for radius in circles]
    known = tuple(one for one in found if one is not None)
    return known if len(known) == len(found) else None


@functools.lru_cache(maxsize=256)
def _rim_of(rest: Difference, wavelength_nm: float) -> Rim:
    # The move is one length for all wavelengths: where they differ (lateral colour) it is no wavelength's mean.
    moved_waves = np.array(rest.moved_um) / (2.0 * rest.blur_um(wavelength_nm))
    return rim_of(rest.lens, rest.obstruction, wavelength_nm, moved_waves)
