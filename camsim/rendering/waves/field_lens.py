"""A field-varying lens as a low-rank sum: few basis transfers, with weights that vary from photosite to photosite.

    I(x) = Σ_m u_m(x) · Σ_f S(f)·T_m(f)·exp(2πi f·x)

Over a part of the frame the transfer is interpolated by a polynomial of the position, through Chebyshev points. A few
mixtures T_m span the transfers at these points in all channels; the weights u_m are polynomials too.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
import scipy

from camsim.core.arrays import C128, F64, I64, Floats, distinct
from camsim.core.cached import cached_property
from camsim.core.kernels import shared
from camsim.numerics.matrix_products import product, real_product
from camsim.numerics.quadrature import chebyshev, interpolation
from camsim.optics import OpticalSystem
from camsim.optics.airy import Airy
from camsim.optics.placed import Revolves
from camsim.optics.protocols import Varies
from camsim.optics.transfer_table import NO_BORDER
from camsim.rendering.modes import spanning
from camsim.rendering.waves.field_transfers import Rule, Wavefronts
from camsim.rendering.waves.image import FrequencyImage, Source, tiles
from camsim.rendering.waves.kernels import mix
from camsim.rendering.waves.levels import Level
from camsim.rendering.waves.transfers import Footprint

NODES = 1, 2, 4, 6, 8  # Chebyshev points along a side of a part of the frame
FAR_NODES = *NODES, 10, 12, 16  # along a side of the whole frame, for low frequencies
TRIED = np.array([[-0.83, 0.41], [0.37, -0.71], [0.92, 0.88], [-0.15, 0.07]])  # test points of a part, −1 … 1
LOOKED_AT = 48  # radial frequencies at which transfers are compared
BANDS = 4, 8, 14, 21, 28, 36, 48  # ends of frequency bands among these, each with its number of mixtures
POINTS, OF_RADII, FAR_POINTS = 320, 5, 32  # along a table's radius: at least; per radius of the rule; of coarse levels
TABLE_DIRECTIONS = 32, 48, 64, 96, 128, 192, 256, 384, 512  # directions of a table over half a turn
OF_RULE, OF_PLACES, OF_MIXTURES, OF_BAND, OF_DIRECTIONS = 1.0, 2.0, 1.0, 0.4, 0.6  # shares of the allowed error
CUBIC = 0.0234  # error of cubic interpolation, over the fourth power of a harmonic's phase step
ALIKE_UM = 1e-6  # image heights closer than this are equal
NEAR_EVERY = 2  # largest spacing, photosites, of levels that are summed tile by tile
MOST_CACHED, MOST_SHARED = 200, 8  # image heights whose transfers are cached, and parts of the frame
SAME = 1e-9  # difference of waves, and of transfers, that is rounding
FEW = 12  # transfers of channels and places
GROWING = 2.5  # arcosh of the largest growth of a polynomial beyond its part of the frame
AddsFar: TypeAlias = Callable[[F64, tuple[slice, slice]], None]
Table: TypeAlias = tuple[tuple[C128, I64], float, tuple[float, float, int, F64]]


@dataclass(frozen=True, kw_only=True, eq=False)
class VaryingLens:
    """A field-varying lens at wavelength nodes.

    lens    : gives the lens at every place
    system  : its custom stages are the same at every place
    allowed : largest error of a transfer
    planes_nm : tilts, Zernikes 1 and 2, that are taken out of the wavefront everywhere; photosites are displaced
                instead
    """

    lens: Varies
    system: OpticalSystem
    wavelength_nm: F64
    pitch_um: float
    allowed: float
    planes_nm: tuple[float, float] = (0.0, 0.0)

    is_round, is_pupil = False, True

    def size(self, frequency: F64, light: F64) -> F64:
        """Return the largest transfer (n,) at any place, at frequencies (n,) in cycles/pitch; light: (j,) weights."""
        perfect, zero = Airy(f_number=self._f_number), np.zeros_like(frequency)
        each = [perfect.otf(frequency / self.pitch_um, zero, nm) for nm in self.wavelength_nm.tolist()]
        size: F64 = np.einsum("j,jn->n", light, np.stack(each))
        return size

    def mixed(self, weights: F64, allowed: float) -> F64:
        """Return mixtures (k, kinds) as ``Lens.mixed`` does, but for any transfer."""
        return spanning(weights, allowed)

    @property
    def blurs(self) -> F64:
        """λN at every wavelength, pitches."""
        return self._f_number * self.wavelength_nm / (1e3 * self.pitch_um)

    @property
    def _f_number(self) -> float:
        number: float = self.lens.f_number  # type: ignore[attr-defined]  # as every lens of a camera
        return number

    @property
    def moved(self) -> F64:
        """Displacement of the PSF along x and y by the tilts, pitches."""
        return np.array(self.planes_nm[::-1]) * (4.0 * self._f_number / (1e3 * self.pitch_um))

    def _fronts(self, places_um: F64, wavelength_nm: F64) -> Wavefronts:
        lenses = [self.lens.at(*place) for place in places_um.tolist()]
        return Wavefronts.of(lenses, wavelength_nm).less(self.planes_nm, wavelength_nm)

    @property
    def _revolves(self) -> bool:
        return isinstance(self.lens, Revolves) and self.lens.turns

    def mixtures(self, corners_um: F64, cut: float, weights: F64, counts: Sequence[int]) -> Mixtures | None:
        """Return the mixtures for a part of the frame; None where the lens changes too fast for the largest count.

        corners_um : (2, 2) low and high corner;  cut: highest frequency, cycles/pitch
        weights    : (kinds, channels, j);  counts: numbers of Chebyshev points along a side to try

        Parts on either side of the axis of a symmetric lens share their mixtures.
        """
        if not self._symmetric(float(np.hypot(*np.abs(corners_um).max(axis=0)))):
            return self._mixtures(corners_um, cut, weights, counts)
        left, up = (corners_um.sum(axis=0) < 0.0).tolist()
        there = np.where([left, up], -corners_um[::-1], corners_um)
        key = tuple(np.rint(there / ALIKE_UM).ravel().tolist()), cut, id(weights), tuple(counts)
        if key not in self._shared:
            while len(self._shared) >= MOST_SHARED:
                del self._shared[next(iter(self._shared))]
            self._shared[key] = self._mixtures(there, cut, weights, counts)
        found = self._shared[key]
        return found if found is None or not (left or up) else found.mirrored(left, up)

    @cached_property
    def _shared(self) -> dict[Any, Mixtures | None]:
        return {}

    def _symmetric(self, height_um: float) -> bool:
        """Whether the lens at an image height and the footprint are symmetric about the x and the y axis."""
        if not self._revolves or self.system.more:
            return False
        x, y = (np.array([1.0, -0.6]) * part for part in (0.5, 0.3))
        lens = self.lens.at(height_um, 0.0)
        f = 0.4 / self.pitch_um * np.array([[0.9, 0.3], [0.5, 0.7]])
        sizes = [np.abs(self.system.footprint_otf(sign * f[:, 0], f[:, 1])) for sign in (1.0, -1.0)]
        waves = [lens.waves(x, sign * y, float(self.wavelength_nm[0])) for sign in (1.0, -1.0)]
        return all(float(np.abs(one - other).max()) < SAME for one, other in (sizes, waves))

    def _mixtures(self, corners_um: F64, cut: float, weights: F64, counts: Sequence[int]) -> Mixtures | None:
        rule = self._rule(corners_um, min(1.0, cut * float(self.blurs.max())))
        part = _Part(self, rule, corners_um, cut, weights)
        if (corners_um[0] == corners_um[1]).all():
            known = part.at(_grid(1))
            return part.mixed(known, part.displayed(known), 1)
        tried = part.displayed(part.at(TRIED))
        for count in counts:
            known = part.at(_grid(count))
            between = [np.outer(_weights(count, y), _weights(count, x)).ravel() for x, y in TRIED[:, :, None]]
            displayed = part.displayed(known)
            off = real_product(np.stack(between), displayed.reshape(len(displayed), -1)).reshape(tried.shape) - tried
            if part.seen(off).max() <= OF_PLACES * self.allowed:
                return part.mixed(known, displayed, count)
        return None

    def _rule(self, corners_um: F64, outer: float) -> Rule:
        """Return the quadrature and the sampling of transfers over a part of the frame."""
        (left, top), (right, bottom) = corners_um.tolist()
        places = [(x, y) for x in (left, 0.5 * (left + right), right) for y in (top, 0.5 * (top + bottom), bottom)]
        if self._revolves:
            away = distinct(np.hypot(*np.array(places).T))
            places = [(away[0], 0.0), (away[away.size // 2], 0.0), (away[-1], 0.0)]
        places = list(dict.fromkeys(places))
        some = distinct(np.linspace(0, self.wavelength_nm.size - 1, 3).astype(int))
        fronts = self._fronts(np.array(places), self.wavelength_nm[some])
        return Rule.of(fronts, OF_RULE * self.allowed, outer)

    def transfers(self, rule: Rule, places_um: F64) -> C128:
        """Return harmonics (places, j, radii, 2·directions) of transfers at places (n, 2)."""
        if not self._revolves:
            return self._of(rule, self._fronts(places_um, self.wavelength_nm))
        away = np.round(np.hypot(*places_um.T) / ALIKE_UM) * ALIKE_UM
        heights, which = np.unique(away, return_inverse=True)
        item = self._along(rule, tuple(heights.tolist()))[which]
        angle = np.arctan2(places_um[:, 1], places_um[:, 0])
        order = np.fft.fftfreq(2 * rule.directions, 1.0 / (2 * rule.directions))
        turned: C128 = item * np.exp(-1j * np.outer(angle, order))[:, None, None, :]
        return turned

    def _along(self, rule: Rule, heights_um: tuple[float, ...]) -> C128:
        """Return the harmonics at image heights along x, cached: the frame's four quadrants share them."""
        cached = self._harmonics_at
        fresh = [height for height in heights_um if (rule, height) not in cached]
        if len(cached) > MOST_CACHED:
            cached.clear()
            fresh = [*heights_um]
        if fresh:
            fronts = Wavefronts.of([self.lens.at(height, 0.0) for height in fresh], self.wavelength_nm)
            cached.update(zip([(rule, height) for height in fresh], self._of(rule, fronts), strict=True))
        return np.stack([cached[rule, height] for height in heights_um])

    def _of(self, rule: Rule, fronts: Wavefronts) -> C128:
        harmonics = rule.on_lattice(fronts)
        return harmonics.reshape(-1, self.wavelength_nm.size, *harmonics.shape[1:])

    @cached_property
    def _harmonics_at(self) -> dict[tuple[Rule, float], C128]:
        return {}


class _Part:
    """A part of the frame, and the transfers there."""

    def __init__(self, lens: VaryingLens, rule: Rule, corners_um: F64, cut: float, weights: F64) -> None:
        self.lens, self.rule, self.corners_um, self.cut, self.weights = lens, rule, corners_um, cut, weights
        frequency = cut * (np.arange(LOOKED_AT) + 0.5) / LOOKED_AT
        self._looked_at = [rule.between(frequency * blur) for blur in lens.blurs.tolist()]
        angle = np.pi * np.arange(rule.directions) / rule.directions
        per_um = frequency[:, None] / lens.pitch_um
        footprint = np.abs(lens.system.footprint_otf(per_um * np.cos(angle), per_um * np.sin(angle)))
        self._edge = footprint / (np.pi * (np.arange(LOOKED_AT)[:, None] + 0.5))

    def at(self, places: F64) -> C128:
        """Return harmonics at places (n, 2), in coordinates −1 … 1 of the part."""
        low, high = self.corners_um
        return self.lens.transfers(self.rule, 0.5 * (low + high) + 0.5 * (high - low) * places)

    def displayed(self, harmonics: C128) -> C128:
        """Return transfers (places, channels, kinds, n, directions) at the frequencies that are compared."""
        out = np.zeros((len(harmonics), *self.weights.shape[1::-1], LOOKED_AT, harmonics.shape[3]), complex)
        for j, matrix in enumerate(self._looked_at):
            item = real_product(matrix, harmonics[:, j])
            out += self.weights.T[j, None, :, :, None, None] * item[:, None, None]
        displayed: C128 = scipy.fft.ifft(out, axis=-1)[..., : self.rule.directions] * (2 * self.rule.directions)
        return displayed

    def seen(self, off: C128) -> F64:
        """Return a bound on an edge's error, ∫ |T|/πf df, from the errors T of transfers (…, kinds, n, directions)."""
        seen: F64 = np.einsum("...nd,nd->...d", np.abs(off), self._edge).max(axis=-1).sum(axis=-1)
        return seen

    def mixed(self, harmonics: C128, displayed: C128, count: int) -> Mixtures:
        """Return the few mixtures that span the transfers of all places and channels."""
        flat = displayed.reshape(displayed.shape[0] * displayed.shape[1], *displayed.shape[2:])
        vectors, numbers = np.empty((len(flat), 0)), np.empty(len(BANDS), np.int64)
        # Of many transfers many modes are left out, which are at their largest at different places.
        many = min(max(1.0, math.sqrt(len(flat) / FEW)), 2.0)
        allowed = OF_MIXTURES * many * self.lens.allowed / math.sqrt(len(BANDS))
        beyond = np.cumsum(np.einsum("pknd,nd->pknd", np.abs(flat), self._edge)[:, :, ::-1].max(axis=-1), axis=2)
        passing = LOOKED_AT - int(np.count_nonzero(beyond.sum(axis=1).max(axis=0) <= OF_BAND * self.lens.allowed))
        # High frequencies need the fewest mixtures: photosites pass little of them.
        for k, (begin, end) in reversed([*enumerate(pairwise((0, *BANDS)))]):
            band, edge = flat[..., begin:end, :], self._edge[begin:end]
            rest = np.ascontiguousarray(band).reshape(len(flat), -1)
            rest = rest - real_product(vectors, real_product(np.ascontiguousarray(vectors.T), rest))
            strength = (rest.reshape(band.shape) * np.sqrt(edge)).reshape(len(flat), -1).view(np.float64)
            fresh = np.linalg.eigh(product(strength, strength.T))[1][:, ::-1]
            modes = real_product(np.ascontiguousarray(fresh.T), rest).reshape(-1, *band.shape[1:])
            # The modes that are left out add up with random signs.
            seen = np.einsum("...nd,nd->...d", np.abs(modes), edge).max(axis=-1).sum(axis=-1)
            beyond = np.sqrt(np.cumsum(((seen * fresh) ** 2)[:, ::-1], axis=1)[:, ::-1].max(axis=0))
            retained = int(np.count_nonzero(beyond[: len(flat) - vectors.shape[1]] > allowed))
            retained = max(retained, 1 - k - vectors.shape[1])  # at least one, however little light there is
            vectors = np.linalg.qr(np.concatenate([vectors, fresh[:, :retained]], axis=1))[0]
            numbers[k] = vectors.shape[1]
        retained = vectors.shape[1]
        item = vectors.reshape(*displayed.shape[:2], retained)
        left = item.swapaxes(1, 2).reshape(-1, self.weights.shape[1])
        taken = product(left, self.weights.swapaxes(0, 1).reshape(left.shape[1], -1))
        taken = taken.reshape(-1, retained, len(self.weights), self.weights.shape[2]).transpose(3, 1, 2, 0)
        harmonics = harmonics[..., : self.rule.directions + 1]  # those of negative order follow, see ``_finer``
        flat = harmonics.reshape(*harmonics.shape[:2], -1)
        made = np.stack([real_product(taken[j].reshape(-1, len(harmonics)), flat[:, j]) for j in range(len(taken))])
        made = np.moveaxis(made.reshape(*taken.shape[:3], *harmonics.shape[2:]), 3, 1)  # radii first
        return Mixtures(
            lens=replace(self.lens),  # without its caches, of which this becomes a part: no garbage of 200 MB
            rule=self.rule,
            harmonics=made,
            table_directions=self._table_directions(displayed),
            numbers=np.maximum(numbers, 1),
            cut=self.cut,
            passes=self.cut * max(passing, 1) / LOOKED_AT,
            count=count,
            taken=np.moveaxis(item, 0, 2),
        )

    def _table_directions(self, displayed: C128) -> int:
        """Return how many directions a table needs for cubic interpolation."""
        whole = np.concatenate([displayed, displayed.conj()], axis=-1)
        count = whole.shape[-1]
        size = np.abs(scipy.fft.fft(whole, axis=-1)).reshape(-1, count).max(axis=0) / count
        order = np.abs(np.fft.fftfreq(count, 1.0 / count))
        left = [CUBIC * float(np.sum(size * (np.pi * order / count) ** 4)) for count in TABLE_DIRECTIONS]
        fits = (
            count
            for count, item in zip(TABLE_DIRECTIONS, left, strict=True)
            if item <= OF_DIRECTIONS * self.lens.allowed
        )
        return max(next(fits, TABLE_DIRECTIONS[-1]), self.rule.directions)


@dataclass(frozen=True, kw_only=True, eq=False)
class Mixtures:
    """The lens of a part of the frame, with the interface of the lenses of frequency sums.

    harmonics : (j, radii, m, kinds, directions + 1);  table_directions: of a table
    numbers   : how many of the first mixtures frequencies up to each of ``BANDS`` use;  cut: the end of these
    passes    : highest frequency that is needed, cycles/pitch
    count     : Chebyshev points along a side;  taken: (channels, m, count²) weight of each mixture at these points
    like      : the mixtures of which these are a mirror image, and whether along x and along y
    """

    lens: VaryingLens
    rule: Rule
    harmonics: C128
    table_directions: int
    numbers: I64
    cut: float
    passes: float
    count: int
    taken: F64
    like: tuple[Mixtures, bool, bool] | None = None

    is_round, is_pupil = False, True

    def mirrored(self, left: bool, up: bool) -> Mixtures:
        """Return the mixtures of the part on the other side of the axis along x, along y, or both."""
        square = self.taken.reshape(*self.taken.shape[:2], self.count, self.count)
        taken = square[..., :: -1 if up else 1, :: -1 if left else 1].reshape(self.taken.shape)
        return replace(self, taken=taken, like=(self, left, up))

    @property
    def number(self) -> int:
        """Number of mixtures."""
        return int(self.harmonics.shape[2])

    def polar(self, level: Level, weights: F64) -> Table:
        """Return the table of ``Lens.polar`` with mixtures as channels; the weights are included already."""
        if self.like is None:
            if level not in self._tables:
                self._tables[level] = self._made(level)
            return self._tables[level]
        one, left, up = self.like
        (table, there), per, turn = one.polar(level, weights)
        # T(−f) is the conjugate of T(f); the first direction is −π/2, and the table has one more before it.
        half = table[:, 1:-2]
        if left != up:
            half = np.concatenate([half[:, :1].conj(), half[:, :0:-1]], axis=1)
        return (_closed(half.conj() if left else half), there), per, turn

    @cached_property
    def _tables(self) -> dict[Level, Table]:
        return {}

    def _made(self, level: Level) -> Table:
        points = max(POINTS, OF_RADII * self.rule.radii) if level.takes is None else FAR_POINTS
        frequency = np.linspace(0.0, level.cut, points + 1)
        shape = self.harmonics.shape[2:]
        total = np.zeros((points + 1, *shape), complex)
        more = self.lens.system.more
        out = np.zeros((*total.shape[:3], self.table_directions), complex) if more else None
        for item, blur, nm in zip(self.harmonics, self.lens.blurs, self.lens.wavelength_nm.tolist(), strict=True):
            along = real_product(self.rule.between(frequency * blur), item.reshape(len(item), -1)).reshape(-1, *shape)
            if out is None:
                total += along
                continue
            angle = np.pi * np.arange(self.table_directions) / self.table_directions - 0.5 * np.pi
            fx, fy = (np.outer(frequency / self.lens.pitch_um, way) for way in (np.cos(angle), np.sin(angle)))
            passes = functools.reduce(np.multiply, (stage.otf(fx, fy, nm) for stage in more))
            out += _finer(along, self.table_directions) * passes[:, None, None]
        half = np.moveaxis(_finer(total, self.table_directions) if out is None else out, 3, 1).swapaxes(2, 3)
        band = np.searchsorted(np.array(BANDS[:-1]) * (self.cut / LOOKED_AT), frequency, side="right")
        turn = -0.5 * math.pi, 1.0 / math.pi, self.table_directions, NO_BORDER
        return (_closed(half), self.numbers[band]), points / level.cut, turn

    def add(self, image: F64, each: Iterable[Floats], places: tuple[F64, F64]) -> None:
        """Add the images (rows, cols) of all mixtures, weighted at each point, to an image (channels, rows, cols).

        places : of rows and of columns, −1 … 1 over the part of the frame
        """
        down, across = (_weights(self.count, one) for one in places)  # (rows, count), (cols, count)
        amounts = np.einsum("ra,cmab->mrcb", down, self.taken.reshape(*self.taken.shape[:2], self.count, self.count))
        turned = np.ascontiguousarray(across.T)
        for one, amount in zip(each, amounts, strict=False):  # none without light
            shared(image.shape[1], functools.partial(mix, image, one, np.ascontiguousarray(amount), turned))


def _closed(half: C128) -> C128:
    """Return a table (points, directions, …) over half a turn with one direction more before it and two past it."""
    return np.ascontiguousarray(np.concatenate([half[:, -1:].conj(), half, half[:, :2].conj()], axis=1))


def _finer(harmonics: C128, directions: int) -> C128:
    """Return harmonics evaluated at ``directions`` directions over half a turn from −π/2 on.

    harmonics : (…, n + 1) of order 0 … n − 1, and −n;  half a turn on, a transfer is its conjugate, and so a harmonic
                of order −m is (−1)^m times the conjugate of that of order m
    """
    half = harmonics.shape[-1] - 1
    order = np.arange(half + 1)
    turned = harmonics * np.exp(-0.5j * np.pi * np.where(order < half, order, -half))
    wide = np.zeros((*harmonics.shape[:-1], 2 * directions), complex)
    wide[..., :half], wide[..., -half] = turned[..., :half], turned[..., half]
    wide[..., 1 - half :] = (turned[..., 1:half].conj() * (-1.0) ** order[1:half])[..., ::-1]
    finer: C128 = scipy.fft.ifft(wide, axis=-1)[..., :directions] * (2 * directions)
    return finer


def _grid(count: int) -> F64:
    """Return the Chebyshev points (count², 2) of a part, row by row."""
    x = _places(count)
    return np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)


def _places(count: int) -> F64:
    return chebyshev(count) if count > 1 else np.zeros(1)


def _weights(count: int, places: F64) -> F64:
    """Return the interpolation matrix (places, count) to places in −1 … 1."""
    return interpolation(chebyshev(count), places) if count > 1 else np.ones((places.size, 1))


def _even(count: int) -> F64:
    return np.linspace(-1.0, 1.0, count) if count > 1 else np.zeros(1)


class MixedImage(FrequencyImage):
    """One source behind the mixtures of a part of the frame."""

    def far(self, origin: tuple[float, float], shape: tuple[int, int], mixtures: Mixtures) -> AddsFar:
        """Return what adds all levels but the first to parts of an image (channels, rows, cols) of a frame.

        Images are mixed on coarse points where the mixtures' polynomials grow little on those beyond the frame.
        """
        each, every = self._far(self.levels[1:], origin, shape, mixtures.number)
        assert each is not None
        half = [max(0.5 * (count - 1), 0.5) for count in shape]
        outside = every * len(self.taps(1)[0])
        if (mixtures.count - 1) * math.acosh(1.0 + outside / min(half)) > GROWING:

            def add(image: F64, part: tuple[slice, slice]) -> None:
                places = [_even(count)[one] for count, one in zip(shape, part, strict=True)]
                mixtures.add(image, self._between(each, every, part), (places[0], places[1]))

            return add
        places = [
            (every * np.arange(points) - outside - 0.5 * (count - 1)) / one
            for points, count, one in zip(each.shape[1:], shape, half, strict=True)
        ]
        mixed = np.zeros((mixtures.taken.shape[0], *each.shape[1:]))
        mixtures.add(mixed, each, (places[0], places[1]))

        def between(image: F64, part: tuple[slice, slice]) -> None:
            image += self._between(mixed, every, part)

        return between


@dataclass(frozen=True, kw_only=True, eq=False)
class VaryingImage:
    """Sources behind a field-varying lens; attributes as of ``FrequencyImage``."""

    sources: Sequence[tuple[Source, F64, VaryingLens]]
    footprint: Footprint
    levels: Sequence[Level]
    leak: float

    def planes(self, origin: tuple[float, float], shape: tuple[int, int]) -> Iterator[tuple[slice, slice, F64]]:
        """Yield tiles of the image, as of ``FrequencyImage``."""
        channels = self.sources[0][1].shape[1]
        near = [level for level in self.levels if level.every <= NEAR_EVERY]
        coarse = [near[-1], *self.levels[len(near) :]]
        far = [self._far(one, coarse, origin, shape) for one in self.sources] if len(coarse) > 1 else []
        nearby = [self.levels if one is None else near for one in far] or [near] * len(self.sources)
        for row, col, height, width in tiles(shape):
            image = np.zeros((channels, height, width))
            part = slice(row, row + height), slice(col, col + width)
            for one, levels in zip(self.sources, nearby, strict=True):
                self._add_near(image, one, levels, (origin[0] + col, origin[1] + row))
            for add in filter(None, far):
                add(image, part)
            yield *part, image

    def at(self, origin: tuple[float, float], rows: I64, cols: I64) -> F64:
        """Return the light (channels, n) to add to the background at n photosites, each with the lens at its place."""
        image = np.zeros((self.sources[0][1].shape[1], rows.size, 1))
        for k, (row, col) in enumerate(zip(rows.tolist(), cols.tolist(), strict=True)):
            for one in self.sources:
                self._add_near(image[:, k : k + 1], one, self.levels, (origin[0] + col, origin[1] + row))
        return image[..., 0]

    def _add_near(
        self, image: F64, one: tuple[Source, F64, VaryingLens], near: Sequence[Level], at: tuple[float, float]
    ) -> None:
        """Add a source's light from the fine levels to a tile, which is split where the lens changes fast."""
        source, weights, lens = one
        height, width = image.shape[1:]
        mixtures = lens.mixtures(_corners_um(at, (height, width), lens), self.levels[0].cut, weights, NODES)
        if mixtures is None:
            for rows in _halves(height):
                for cols in _halves(width):
                    self._add_near(image[:, rows, cols], one, near, (at[0] + cols.start, at[1] + rows.start))
            return
        among, whole = self._among(source, weights, mixtures, near), (slice(0, height), slice(0, width))
        x, y = np.array(at) - lens.moved
        first = replace(near[0], cut=min(near[0].cut, mixtures.passes))
        each = among.each(first, (x, y), (width, height), mixtures.number)
        mixtures.add(image, each, (_even(height), _even(width)))
        if len(near) > 1:
            among.far((x, y), (height, width), mixtures)(image, whole)

    def _far(
        self,
        one: tuple[Source, F64, VaryingLens],
        levels: Sequence[Level],
        origin: tuple[float, float],
        shape: tuple[int, int],
    ) -> AddsFar | None:
        """Return what adds the light of all levels but the first to parts of the frame.

        None: the lens changes too fast for one set of mixtures.
        """
        source, weights, lens = one
        mixtures = lens.mixtures(_corners_um(origin, shape, lens), levels[1].cut, weights, FAR_NODES)
        if mixtures is None:
            return None
        among = self._among(source, weights, mixtures, levels)
        x, y = np.array(origin) - lens.moved
        return among.far((x, y), shape, mixtures)

    def _among(self, source: Source, weights: F64, mixtures: Mixtures, levels: Sequence[Level]) -> MixedImage:
        return MixedImage(
            sources=[(source, weights, mixtures)],  # type: ignore[list-item]  # has the interface of a lens
            footprint=self.footprint,
            levels=levels,
            leak=self.leak,
        )

    @property
    def in_parts(self) -> bool:
        """Whether all sources can transform parts of a lattice."""
        return all(source.in_parts for source, *_ in self.sources)

    @cached_property
    def box(self) -> tuple[F64, F64]:
        """Low and high corner of all sources."""
        boxes = [source.box for source, *_ in self.sources]
        return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)


def _halves(count: int) -> list[slice]:
    middle = count // 2
    return [slice(0, middle), slice(middle, count)] if middle else [slice(0, count)]


def _corners_um(at: tuple[float, float], shape: tuple[int, int], lens: VaryingLens) -> F64:
    """Return the centres of the first and the last photosite of a part, µm."""
    low = np.array(at)
    return lens.pitch_um * np.stack([low, low + np.array([shape[1], shape[0]]) - 1.0])
