"""Far scenery behind an aberrated lens: the smooth light of its pupil's rim, edge by edge, without a transform.

What differs from a round lens falls so slowly that it is asked for thousands of λN away, on a lattice as fine as it is
near. But it is rings, which edges hear no more from some distance on, and the light between them, which is known
(optics/rim_light.py). From a photosite outwards that gains G(r, φ) = ∫(1 − taper)·light·r dr; a region's light is ∮G dφ
along its outline. The pattern itself, tapered soon after the distance, is left to a transform of no longer period.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import F64, U8
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.optics.protocols import KnowsRim
from camsim.products import product
from camsim.quadrature import chebyshev, gauss_legendre, interpolation
from camsim.rendering.engine import Cost
from camsim.rendering.fourier.rim_kernels import PAD, STEP_RAD, Gained, add_rim, panel_of
from camsim.rendering.fourier.shells import RINGS_PART, WORTH, first_quiet
from camsim.rendering.fourier.sight import FarLight, Sight
from camsim.rendering.fourier.taper import Hem, hem_from, taper, tapered
from camsim.rendering.spectral import Signals, fuse, nodes_that_follow

SMOOTH = 0.7  # of the slowest ring's frequency, what the taper's band may have at most
LINES = 2.0  # of what a line hears of rings: twice what it is
OF_TAPER = 0.02  # of what tapers may leave: what the light between rings is known to
PLACES = 12  # Chebyshev, along 1/r: of powers that fall by eight each
CELLS, TURNS = 512, 512  # of what is gained, along 1/r and round about
FUSED_OFF = 1e-3  # wavelengths that it is summed from: without rings it changes with them as powers do
WIDER = (1.0, 2.0, 4.0)  # times as wide as is best for what is near alone
SMALLEST = 8  # photosites along a window
SPREAD = 1e-3  # of a cycle over a photosite's half extent: at which its second moments are asked
SECONDS_PER_EDGE, SECONDS_PER_PANEL = 6e-7, 5.5e-7  # of one core, of one place
SECONDS_PER_TABLE, SECONDS_PER_LIGHT = 0.03, 2e-4  # and of a direction
TINY = 1e-9  # pitches


@dataclass(frozen=True, kw_only=True, eq=False)
class RimLight(FarLight):
    """The light from beyond a taper, as a lens's rim throws it.

    directions : in which it is asked;  leave: what places between those that are may be wrong by, of that light
    """

    directions: int
    leave: float

    def rendered(
        self, origin: tuple[float, float], channel: U8, progress: Callable[[float], None] = lambda done: None
    ) -> F64:
        """Render every photosite in its own channel, less the background; see ``FourierImage.rendered``."""
        pairs, _ = self.edges.pairs()
        _, density = self._fused
        image, contrast = np.zeros(channel.shape), density[pairs[:, 0]] - density[pairs[:, 1]]
        size, _ = self._size((channel.shape[-2], channel.shape[-1]))
        for own in np.unique(channel).tolist():
            gained, mine = self._gained(contrast[:, own]), channel == own
            if size:
                for rows, cols in _windows(channel.shape[-2], channel.shape[-1], size):
                    light = self._between(gained, origin, rows, cols)
                    np.copyto(image[..., rows, cols], light, where=mine[..., rows, cols])
                continue
            *_, down, across = np.nonzero(mine)
            centres = np.array(origin) + np.stack([across, down], axis=1)
            image[mine] = self._at(gained, centres[:, None] - self._offsets)
        progress(1.0)
        return image

    def _at(self, gained: Gained, places: F64) -> F64:
        """Return the light at places (n, m, 2), of m the mean."""
        _, pair = self.edges.pairs()
        values, weight = np.zeros(len(places)), 1.0 / places.shape[1]
        add = functools.partial(add_rim, gained, self.edges.start, self.edges.end, pair, places, weight, values)
        shared(len(values), add, least=max(1, 1000 // (1 + len(self.edges))))
        return values

    def _between(self, gained: Gained, origin: tuple[float, float], rows: slice, cols: slice) -> F64:
        """Return the light of a window's photosites by few places: it changes no faster than its taper."""
        axes = []
        for own, corner, offset in zip((cols, rows), origin, self._offsets.T, strict=True):
            centres = corner + np.arange(own.start, own.stop)
            low, high = centres[0] - offset.max(), centres[-1] - offset.min()
            places = chebyshev(self._places(high - low))
            half = 0.5 * (high - low) or 1.0
            between = [interpolation(places, (centres - by - 0.5 * (low + high)) / half) for by in offset.tolist()]
            axes.append((0.5 * (low + high) + half * places, between))
        (x, across), (y, down) = axes
        lattice = np.stack(np.meshgrid(x, y), axis=-1)
        values = self._at(gained, lattice.reshape(-1, 1, 2)).reshape(y.size, x.size)
        each = [product(product(to_rows, values), to_cols.T) for to_rows, to_cols in zip(down, across, strict=True)]
        mean: F64 = np.mean(each, axis=0)
        return mean

    def _places(self, extent: float) -> int:
        """Return how many Chebyshev places follow it along so many pitches."""
        return nodes_that_follow(2.0 * math.pi * self.hem.band * extent, self.leave) if extent else 1

    def _size(self, shape: tuple[int, int]) -> tuple[int, float]:
        """Return the size of windows that take the fewest places, and how many these are; 0: each photosite's own."""
        spread = np.ptp(self._offsets, axis=0)[::-1]
        best, size = (0, float(len(self._offsets)) * shape[0] * shape[1]), max(shape)
        while size >= SMALLEST:
            along = [
                -(-count // size) * self._places(min(size, count) - 1.0 + more)
                for count, more in zip(shape, spread.tolist(), strict=True)
            ]
            places = float(along[0] * along[1] * self.density.shape[1])
            best, size = min(best, (size, places), key=lambda one: one[1]), size // 2
        return best

    def expected(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]:
        """Return what rows and columns are expected to take; no frequencies."""
        tables = len(self.edges.pairs()[0]) * self.density.shape[1]
        of_place = SECONDS_PER_EDGE * len(self.edges) + SECONDS_PER_PANEL * self._panels(origin, shape)
        seconds = self._size(shape)[1] * of_place
        seconds += SECONDS_PER_TABLE * tables + self._light_seconds
        held = 8.0 * TURNS * CELLS * (tables + 4.0)
        return Cost(seconds=seconds, memory_bytes=held + 16.0 * shape[0] * shape[1]), 0.0

    def _panels(self, origin: tuple[float, float], shape: tuple[int, int]) -> float:
        """Return how many panels all edges take, seen from the frame's middle; see ``rim_kernels``."""
        middle = np.array(origin) + 0.5 * (np.array(shape[::-1]) - 1.0)
        start, way = self.edges.start - middle, self.edges.end - self.edges.start
        length = np.maximum(np.hypot(*way.T), TINY)
        distance = np.maximum(np.abs(start[:, 0] * way[:, 1] - start[:, 1] * way[:, 0]) / length, TINY)
        along = np.sum(start * way, axis=1) / length
        first, last = np.arctan2(along, distance), np.arctan2(along + length, distance)
        nearest = np.where((first <= 0.0) & (last >= 0.0), 1.0, np.maximum(np.cos(first), np.cos(last)))
        # What lies nearer than the taper is left out.
        near, begin, end = (
            np.minimum(part / distance, 1.0 / self.hem.inner) for part in (nearest, np.cos(first), np.cos(last))
        )
        changed = (2.0 * near - begin - end) / panel_of(self.hem.inner, self.hem.outer)
        return float(np.sum(np.ceil((last - first) / STEP_RAD + changed)))

    @property
    def _light_seconds(self) -> float:
        return SECONDS_PER_LIGHT * self.directions * len(self._fused[0])

    @cached_property
    def _offsets(self) -> F64:
        """Places (n, 2) that stand for OLPF and photosite as far as second moments tell, pitches."""
        spots, photosite = self.system.spots_um(), self.system.photosite
        half = np.hypot(*photosite.half_extent_um)
        if half == 0.0:
            return spots / self.pitch_um
        # An OTF is 1 − 2πi f·⟨u⟩ − 2π²⟨(f·u)²⟩; along both axes at once it has ⟨xy⟩ in it.
        f = SPREAD / half
        otf = photosite.otf(f * np.array([1.0, 0.0, 1.0]), f * np.array([0.0, 1.0, 1.0]), 0.0)
        middle = -np.imag(otf[:2]) / (2.0 * np.pi * f)
        xx, yy, both = (1.0 - np.real(otf)) / (2.0 * np.pi**2 * f * f)
        xy = 0.5 * (both - xx - yy)
        sizes, ways = np.linalg.eigh(np.array([[xx, xy], [xy, yy]]) - np.outer(middle, middle))
        arms = ways.T * np.sqrt(2.0 * np.maximum(sizes, 0.0))[:, None]
        offsets: F64 = (spots[:, None] + middle + np.concatenate([arms, -arms])).reshape(-1, 2) / self.pitch_um
        return offsets

    @cached_property
    def _fused(self) -> tuple[F64, F64]:
        """Fewer wavelengths (j,), and densities on them (spectra, channels, j)."""
        scale = np.ones(self.density.shape[1])
        signals = Signals(wavelength_nm=self.wavelength_nm, density=self.density, scale=scale)
        return fuse(signals, phase=0.0, allowed=FUSED_OFF)

    @cached_property
    def _light(self) -> tuple[F64, F64]:
        """Chebyshev places of 1/r (n,), per pitch, and the light there times r⁴: (j, n, directions), pitches²."""
        lens = self.system.lens
        assert isinstance(lens, KnowsRim)
        over_r = 0.5 / self.hem.inner * (1.0 + np.cos(np.pi * (np.arange(PLACES) + 0.5) / PLACES))
        wavelength_nm, _ = self._fused
        light = [lens.rim_light(self.pitch_um / over_r, nm, self.directions) for nm in wavelength_nm.tolist()]
        return over_r, np.array(light) * self.pitch_um**2 / over_r[:, None] ** 4

    @cached_property
    def _cells(self) -> tuple[F64, F64]:
        """Nodes (n,) along 1/r, four in every cell, and what light times r⁴ there adds: (directions, n)."""
        step, (x, w) = 1.0 / self.hem.inner / CELLS, gauss_legendre(4)
        u = step * (np.arange(-PAD, CELLS)[:, None] + 0.5 * (1.0 + x))
        # Cosines and sines of even directions are the same few numbers.
        quarter = TURNS // 4
        cosines = np.cos(2.0 * np.pi * np.arange(quarter + 1) / TURNS)
        r, shape = 1.0 / np.maximum(u.ravel(), step * SPREAD), taper(self.hem.sharpness)
        along = tapered(np.multiply.outer(cosines, r), self.hem.inner, self.hem.outer, shape)
        first = along * along[::-1]
        kept = np.concatenate([first, first[-2:0:-1]])
        weight = (1.0 - np.concatenate([kept, kept])) * u.ravel() * np.tile(0.5 * step * w, len(u))
        return u.ravel(), weight

    def _gained(self, contrast: F64) -> Gained:
        """Return what pairs of spectra gain of the light; contrast (pairs, j)."""
        (over_r, light), (u, weight) = self._light, self._cells
        follow = scipy.interpolate.BarycentricInterpolator(over_r, np.eye(PLACES))(u)
        splines = np.zeros((len(contrast), TURNS, CELLS + 1 + 2 * PAD))
        for own, weights in zip(splines, contrast, strict=True):
            there = np.einsum("j,jnd->nd", weights, light)
            finer = scipy.fft.irfft(scipy.fft.rfft(there), TURNS) * (TURNS / there.shape[1])
            cells = np.sum((product(finer.T, follow.T) * weight).reshape(TURNS, -1, 4), axis=-1)
            own[:, : CELLS + PAD] = np.cumsum(cells[:, ::-1], axis=1)[:, ::-1]
            scipy.ndimage.spline_filter(own, order=5, output=own, mode="grid-wrap")
        return Gained(splines, 1.0 / self.hem.inner, self.hem.inner, self.hem.outer)


def _windows(rows: int, cols: int, size: int) -> Iterator[tuple[slice, slice]]:
    """Yield windows of a frame."""
    for row, col in itertools.product(range(0, rows, size), range(0, cols, size)):
        yield slice(row, min(row + size, rows)), slice(col, min(col + size, cols))


def rim_hems(sight: Sight) -> list[tuple[Hem, int, float]]:
    """Return tapers, beyond each of which the light of the rim is all that edges show; none where it is not known.

    And in how many directions that is to be asked, and what part of it may be wrong. Wider tapers leave more to be
    transformed, and what is beyond them changes more slowly.
    """
    system, kernel, wavelength_nm, pitch_um = sight.system, sight.kernel, sight.wavelength_nm, sight.pitch_um
    lens = system.lens
    if kernel.round or system.more or not isinstance(lens, KnowsRim) or not len(sight.edges):
        return []
    allowed, far = sight.of_tapers, min(kernel.reach, sight.distances[1])
    some_nm = {float(wavelength_nm[k]) for k in (0, wavelength_nm.size // 2, -1)}
    share, longest = system.ring_share(wavelength_nm), sight.longest
    slowest = longest / lens.slowest_ring
    heard = sight.heard(longest, slowest)

    def quiet(beyond: float) -> bool:
        """Whether rings of edges beyond a distance are within their share."""
        away, part = heard.beyond(beyond)
        loud = np.max([lens.rings_beyond(away * pitch_um, nm, share) for nm in some_nm], axis=0)
        return LINES * float(part @ loud) <= RINGS_PART * allowed

    loud_until = first_quiet(quiet, longest, far)
    if loud_until is None or far < WORTH * lens.scale * loud_until:
        return []
    known = [lens.rim_known(OF_TAPER * allowed, nm) for nm in some_nm]
    inner = lens.scale * max(loud_until, max(from_um for from_um, _ in known) / pitch_um)
    if far < WORTH * inner:
        return []
    light = max(kernel.light(inner), 1e-300)
    # Outside of the taper's band there is as little of what is far as of what is near.
    hem = hem_from(inner, 0.5 * (1.0 - RINGS_PART) * allowed / light, max(sight.shape), kernel.cutoff)
    # And it is no end of rings, the slowest either.
    hem = hem._replace(outer=inner + (hem.outer - inner) * max(1.0, hem.band * slowest / SMOOTH))
    hems = [hem._replace(outer=inner + times * (hem.outer - inner)) for times in WIDER]
    directions, leave = max(directions for _, directions in known), min(OF_TAPER * allowed / light, 0.1)
    return [(own, directions, leave) for own in hems if far >= WORTH * own.outer]
