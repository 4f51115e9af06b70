"""What is far goes on coarser lattices: a round pattern cut by distance into shells, each with a lattice of its own.

Far out a pattern is a few powers of 1/r, and rings. From some distance on the rings of all edges together matter no
more, and what is smooth beyond a distance D is all but band-limited once a taper of a width like D has cut out its
middle: a lattice of some D/10 holds it. So the first shell is the pattern itself, tapered soon after that distance, on
a fine and small lattice; each one after it is what the taper before took away of the powers, four times as far out and
on a lattice as much coarser, up to the scene's end. The tapers add up to 1.
"""

from __future__ import annotations

import bisect
import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.optics import RoundLens
from camsim.optics.protocols import Round
from camsim.rendering.fourier.sight import Sight
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.swings import Swing, swings
from camsim.rendering.fourier.taper import Hem, taper, taper_margin, tapered
from camsim.rendering.hearing import Heard

RINGS_PART = 5.0 / 6.0  # of what tapers may leave: for the rings that are dropped
SURE = 0.25  # of the rings as tapers have them: twice for a step that shells do not have, and four times to be sure
FARTHER = 4.0  # times as far for every shell: 2 and 8 take a third more
WORTH = 1.2  # times the first shell's end: a scene that goes no farther is not cut
SOON = 0.25  # of its distance: the first taper's width. Its shell has the finest lattice by far
NARROWEST = 2.0  # taper's widths in its own margin's blurs: then it widens the band by half
FRAME = 512  # photosites along a tile, or fewer: what the first taper's width is chosen for
PER_OCTAVE, LEAST = 4, 1.0  # distances tried between one and twice as far; pitches
LEAST_LIGHT = 1e-3  # that a shell is taken for: no precision is worth less
CELL = 0.125  # of a taper's width: what a pattern changes over


@dataclass(frozen=True, slots=True, kw_only=True)
class Shell:
    """A pattern between two tapers, pitches.

    begin  : the taper that cuts out its middle; None: none
    end    : the taper that ends it; None: where the scene does
    tapers : how many share what tapers may leave
    """

    begin: Hem | None
    end: Hem | None
    tapers: int

    def kernel(self, whole: Kernel) -> Kernel:
        """Return what the plan has to know of it, from what it knows of the whole pattern."""
        known = dataclasses.replace(whole, tapers=self.tapers)
        if self.begin is not None:
            blur = CELL * (self.begin.outer - self.begin.inner)
            known = dataclasses.replace(
                known,
                cutoff=self.begin.band,
                passes=self.begin.band,
                blur=blur,
                rings=(),
                carries=max(LEAST_LIGHT, whole.light(self.begin.inner)),
            )
        return known if self.end is None else dataclasses.replace(known, reach=self.end.outer, hem=self.end)

    def of(self, lens: Round, pitch_um: float) -> Round:
        """Return the lens's pattern, or its powers less their middle."""
        if self.begin is None:
            return lens
        assert isinstance(lens, RoundLens)
        return _Powers(lens, self.begin, pitch_um)


@dataclass(frozen=True, slots=True)
class _Powers:
    """The smooth part of a round pattern outside of a taper.

    1 − E(ρ) = Σ c_n/ρⁿ has the slope Σ n·c_n/ρ^{n+1} = 2πρ times the light per square blur.
    """

    lens: RoundLens
    begin: Hem
    pitch_um: float

    def point_spread(self, r_um: F64, wavelength_nm: float) -> F64:
        """Irradiance at ``r_um`` from a point of unit power, 1/µm²."""
        blur_um = self.lens.blur_um(wavelength_nm)
        pitches = np.asarray(r_um, float) / self.pitch_um
        inside = pitches <= self.begin.inner
        rho = np.where(inside, 1.0, pitches * self.pitch_um / blur_um)
        powers = zip((1, 3, 5), self.lens.pattern().powers, strict=True)
        light = sum(n * c / rho ** (n + 2) for n, c in powers) / (2.0 * math.pi * blur_um**2)
        hem = 1.0 - tapered(pitches, self.begin.inner, self.begin.outer, taper(self.begin.sharpness))
        values: F64 = np.where(inside, 0.0, light * hem)
        return values


def shells(sight: Sight, quiet: Callable[[], float] | None) -> tuple[Shell, ...]:
    """Return the shells for edges; none where there is nothing to cut.

    quiet : what tells from where on rings and what is past the powers are within their shares, if that is known: in a
            crowd they do not add up, and those of a spectrum fall silent
    """
    kernel, lens, sides = sight.kernel, sight.system.lens, len(sight.edges)
    if not (kernel.round and kernel.tapered and kernel.rings and isinstance(lens, RoundLens)):
        return ()
    allowed, far = sight.of_tapers, min(kernel.reach, sight.distances[1])
    rings = swings(sight.system, kernel.longest)
    slowest = 1.0 / min((ring.f for ring in rings), default=1.0 / kernel.longest)
    heard = sight.heard(kernel.longest, slowest)
    least = max(LEAST, kernel.longest * lens.pattern().quiet(RINGS_PART * allowed / sides))
    first = _quiet_distance(kernel, heard, RINGS_PART * allowed, least, far)
    if quiet is not None and (first is None or first > WORTH * least):
        first = min(quiet(), math.inf if first is None else first)
    if first is None or first >= far:
        return ()
    count = max(1, math.ceil(math.log(far / first, FARTHER)))
    each = (1.0 - RINGS_PART) * allowed / (2 * count + 1)
    hems = list(_hems(kernel, rings, sides, first, far, each, float(min(*sight.shape, FRAME))))
    if not hems or far < WORTH * hems[0].outer:
        return ()
    tapers = round(allowed / each)
    bounds = [None, *hems, None]
    return tuple(Shell(begin=a, end=b, tapers=tapers) for a, b in itertools.pairwise(bounds))


def _quiet_distance(kernel: Kernel, heard: Heard, allowed: float, least: float, far: float) -> float | None:
    """Return from where on all edges' rings add up to no more than ``allowed``; None: nowhere nearer than ``far``.

    An end's is 1/(4π√(uρ)) of all that goes round, u ≤ 1, and is taken four times. A whole line is taken for four ends,
    twice what it is (113 random scenes at 1e-2 … 3e-8: at most 0.04 of the tolerance with 16 ends).
    """

    def quiet(beyond: float) -> bool:
        away, part = heard.beyond(beyond)
        return SURE * sum(a * float(part @ away**-n) for a, n in kernel.rings) <= allowed

    return first_quiet(quiet, least, far)


def first_quiet(quiet: Callable[[float], bool], least: float, far: float) -> float | None:
    """Return from which distance on it is quiet, ``least`` or farther; None: nowhere nearer than ``far``."""
    steps = range(math.ceil(PER_OCTAVE * math.log2(max(far / least, 1.0))))
    first = bisect.bisect_left(steps, True, key=lambda step: quiet(least * 2.0 ** (step / PER_OCTAVE)))  # rings fade
    return least * 2.0 ** (first / PER_OCTAVE) if first < len(steps) else None


def _hems(
    kernel: Kernel,
    rings: Sequence[Swing],
    sides: int,
    first: float,
    far: float,
    allowed: float,
    frame: float,
) -> Iterator[Hem]:
    """Yield the tapers between shells; each may leave ``allowed`` of an image outside its band, on either side.

    rings : that the first taper ends: it is wide enough for slow ones, as all sides hear them that go through it

    The first one's shell has the finest lattice by far: there (cutoff + margin/width)·(frame + 2·(inner + width)) is
    smallest, or nearly, but for shells that are narrower still where the scene soon ends.
    """
    inner, wide = first, SOON
    while inner < far:
        margin, sharpness = taper_margin(min(max(allowed / max(kernel.light(inner), 1e-300), 1e-14), 1.0))
        outer = inner + max(wide * inner, NARROWEST * margin * kernel.longest)
        if inner == first:
            smooth = max((ring.width(inner, sharpness, allowed / sides) for ring in rings), default=0.0)
            outer = max(outer, inner + max(smooth, math.sqrt(margin * frame / (2.0 * kernel.cutoff))))
        if outer >= far:
            return  # the shell before it goes no farther without it
        yield Hem(inner, outer, sharpness)
        inner, wide = FARTHER * max(inner, 0.5 * outer), 1.0
