"""Product rules over smooth images of the unit square, cut into panels where a wavefront takes many nodes.

The corners of a square are 2^(n/2) times as far up a Zernike polynomial as its rim is: as dense all over as there, a
rule has twenty times as many nodes. So what takes more than ``MOST_SPARE`` along a line, besides waves, is halved.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from camsim.arrays import F64, I64
from camsim.optics.follow import Turns, from_0, nodes_before, nodes_of, not_followed, spare_nodes
from camsim.optics.pupil import Pupil
from camsim.quadrature import GOLDEN

# Nodes that a wavefront takes along a panel: with 110 … 270 all take as many, with 70 there are twice the panels.
MOST_SPARE = 170.0
MOST_PANELS = 1024  # found in three seconds
# Of a panel, along which the wavefront is looked at: its ends, and steps of the golden section. On even ones sin 12θ,
# and all that it is multiplied by, may be nothing.
LINES: F64 = np.concatenate([[0.0, 1.0], GOLDEN * np.arange(1, 8) % 1.0])
GROUPS = 8  # of an image's lines along t, from one of which to the next the number of nodes may change
LOOKED, STEPS = 3, 16  # lines along which it is looked how fast waves turn, and at how many steps of each
BENT_SPARE = 14  # of lines that end on a circle: with 6 1e-10 of the light was lost, with 10 2e-12


class OverPupil(Protocol):
    """A lens of one opening, and the path difference over it."""

    @property
    def pupil(self) -> Pupil: ...  # noqa: D102

    def __hash__(self) -> int: ...

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64: ...  # noqa: D102


class Patch(Protocol):
    """A part of an opening as a smooth image of the unit square."""

    @property
    def bent(self) -> bool:
        """Whether lines along t end on a circle."""

    @property
    def first_half(self) -> float:
        """How much of it, from u = 0 on, counts where of two opposite points only one does: 0, ½ or 1."""

    def at(self, u: F64, t: F64) -> tuple[F64, F64, F64]:
        """Return x, y and the area of the image over that of the square."""

    def __hash__(self) -> int: ...


@dataclass(frozen=True, eq=False, slots=True)
class Panels:
    """Parts of images, and what tells how many nodes each takes.

    patches   : the images
    which     : (n,) the image of each panel;  begin, size: (n, 2) its place, u and t
    spare     : (n, 2) nodes that the wavefront takes along u and along t, besides those of waves
    group     : (m,) the panel of each group of lines along t;  ends: (m, 2) its u, 0 … 1 of the panel
    along_u   : (n, s, 2) ways (x, y) along u, as if all of the panel were like so many parts of it
    along_t   : (m, s, 2) along t, of each group
    """

    patches: tuple[Patch, ...]
    which: I64
    begin: F64
    size: F64
    spare: I64
    group: I64
    ends: F64
    along_u: F64
    along_t: F64

    @classmethod
    def of(cls, patches: tuple[Patch, ...], which: I64, begin: F64, size: F64, spare: I64) -> Panels:
        """Complete them."""
        groups = np.maximum(1, np.int64(np.round(GROUPS * size[:, 0])))
        group = np.repeat(np.arange(len(groups)), groups)
        ends = np.concatenate([np.stack([np.arange(k), np.arange(1, k + 1)], axis=1) / k for k in groups.tolist()])
        line, step = np.linspace(0.0, 1.0, LOOKED)[:, None], np.linspace(0.0, 1.0, STEPS + 1)
        every = np.arange(len(which))
        along_u = _ways(_at(patches, which, begin, size, every, step, line))
        of_group = ends[:, :1, None] + np.diff(ends)[:, :, None] * line
        along_t = _ways(_at(patches, which, begin, size, group, of_group, step))
        return cls(patches, which, begin, size, spare, group, ends, along_u, along_t)


class _Piece(NamedTuple):
    """Some lines along t of a panel with so many nodes each: of all its ``lines``, ``first`` … ``stop``."""

    panel: int
    lines: int
    first: int
    stop: int
    along: int


class PanelRule(NamedTuple):
    """Nodes of panels for waves that turn by so much."""

    panels: Panels
    turns: Turns

    @property
    def total(self) -> float:
        """How many nodes there are."""
        return float(sum((piece.stop - piece.first) * piece.along for piece in _pieces(self)))

    def parts(self, at_once: int, half: bool = False) -> Iterator[tuple[F64, F64, F64]]:
        """Yield x, y and weights, at most about ``at_once`` at a time; ``half``: of two opposite nodes only one."""
        yield from joined(self._parts(at_once, half), at_once)

    def _parts(self, at_once: int, half: bool) -> Iterator[tuple[F64, F64, F64]]:
        panels = self.panels
        for panel, lines, begin, end, along in _pieces(self):
            patch = panels.patches[panels.which[panel]]
            (first_u, first_t), (size_u, size_t) = panels.begin[panel].tolist(), panels.size[panel].tolist()
            u, share = from_0(lines)
            u, share = first_u + size_u * u, size_u * share
            if half and first_u + size_u > patch.first_half:
                # Halves are whole panels, but where one goes over the middle.
                end = min(end, (lines + 1) // 2) if first_u < patch.first_half else begin
                if lines % 2:
                    share[lines // 2] *= 0.5  # the line through the middle is its own opposite
            t, weights = from_0(along)
            t, weights = first_t + size_t * t, size_t * weights
            most = max(at_once // along, 1)
            for first in range(begin, end, most):
                some = slice(first, min(first + most, end))
                x, y, area = patch.at(u[some, None], t)
                own = area * np.multiply.outer(share[some], weights)
                yield x.ravel(), y.ravel(), own.ravel()


@functools.lru_cache(maxsize=256)
def _pieces(rule: PanelRule) -> list[_Piece]:
    """Return them: prices ask for the same rule again and again."""
    panels, turns = rule.panels, rule.turns
    bent = np.array([patch.bent for patch in panels.patches])[panels.which]
    lines = nodes_of(_most(turns, panels.along_u), panels.spare[:, 0] + BENT_SPARE * bent)
    along = nodes_of(_most(turns, panels.along_t), panels.spare[panels.group, 1])
    first, stop = nodes_before(lines[panels.group, None], panels.ends).T
    found: list[_Piece] = []
    each = np.stack([panels.group, lines[panels.group], first, stop, along], axis=1)
    for piece in map(_Piece._make, each.tolist()):
        if found and found[-1].panel == piece.panel and found[-1].along == piece.along:
            found[-1] = found[-1]._replace(stop=piece.stop)
        else:
            found.append(piece)
    return found


@functools.lru_cache(maxsize=256)
def panels_of(lens: OverPupil, wavelength_nm: float, patches: tuple[Patch, ...]) -> Panels:
    """Return an opening's panels for a wavefront: halved until few nodes more than waves take change no integral."""
    which, begin, size = np.arange(len(patches)), np.zeros((len(patches), 2)), np.ones((len(patches), 2))
    line, done = LINES[:, None], []
    while which.size:

        def waves(u: F64, t: F64, some: I64, which: I64 = which, begin: F64 = begin, size: F64 = size) -> F64:
            x, y, _ = _at(patches, which, begin, size, some, u, t)
            return lens.waves(x, y, wavelength_nm)

        along_u = spare_nodes(lambda u, some: waves(u, line, some), size[:, 0], MOST_SPARE)
        along_t = spare_nodes(lambda t, some: waves(line, t, some), size[:, 1], MOST_SPARE)
        spare = np.stack([along_u, along_t], axis=1)
        whole = (spare > 0).all(axis=1)
        done.append((which[whole], begin[whole], size[whole], spare[whole]))
        which, begin, size, cut = which[~whole], begin[~whole], size[~whole], spare[~whole] == 0
        for axis in (0, 1):
            which, begin, size, cut = _halved(axis, which, begin, size, cut)
        if sum(len(some) for some, *_ in done) + which.size > MOST_PANELS:
            corners = ", whose corners lie outside of the circle that coefficients are for" * (
                lens.pupil.outer_radius > 1.0
            )
            raise not_followed(wavelength_nm, f"over the pupil{corners}", f"{MOST_PANELS} parts of it")
    return Panels.of(patches, *(np.concatenate(own) for own in zip(*done, strict=True)))


def _halved(axis: int, which: I64, begin: F64, size: F64, cut: np.ndarray) -> tuple[I64, F64, F64, np.ndarray]:
    """Return panels of which those to be cut along an axis are halved."""
    some, step = cut[:, axis], np.eye(2)[axis]
    size = np.where(some[:, None], size * (1.0 - 0.5 * step), size)
    after = begin[some] + step * size[some]
    return (
        np.concatenate([which, which[some]]),
        np.concatenate([begin, after]),
        np.concatenate([size, size[some]]),
        np.concatenate([cut, cut[some]]),
    )


def _at(
    patches: tuple[Patch, ...], which: I64, begin: F64, size: F64, own: I64, u: F64, t: F64
) -> tuple[F64, F64, F64]:
    """Return x, y and area at places u and t, 0 … 1 of panels ``own``, whose axis is the first."""
    u, t = (begin[own, axis, None, None] + size[own, axis, None, None] * v for axis, v in ((0, u), (1, t)))
    shape = np.broadcast_shapes(u.shape, t.shape)
    found = np.empty((3, *shape))
    for number, patch in enumerate(patches):
        some = which[own] == number
        found[:, some] = np.stack(np.broadcast_arrays(*patch.at(u[some], t[some])))
    return found[0], found[1], found[2]


def _ways(places: tuple[F64, F64, F64]) -> F64:
    """Return ways (panels, steps of all lines, 2) along the last axis, as if all of a line were like each step."""
    x, y, _ = places
    ways = STEPS * np.stack([np.diff(x), np.diff(y)], axis=-1)
    return ways.reshape(len(ways), -1, 2)


def _most(turns: Turns, ways: F64) -> F64:
    most: F64 = turns.along(ways[..., 0], ways[..., 1]).max(axis=-1)
    return most


def joined(parts: Iterable[tuple[F64, F64, F64]], at_once: int) -> Iterator[tuple[F64, F64, F64]]:
    """Yield x, y and weights of parts in a row together, about ``at_once`` nodes at a time.

    Each that is yielded takes a transform of its own where the lattice is small.
    """
    held: list[tuple[F64, F64, F64]] = []
    count = 0
    for part in parts:
        if held and count + part[0].size > at_once:
            joint, held, count = [_together(held)], [], 0
            yield joint.pop()  # and nothing is kept of it
        held.append(part)
        count += part[0].size
    if held:
        yield _together(held)


def _together(parts: list[tuple[F64, F64, F64]]) -> tuple[F64, F64, F64]:
    x, y, weights = (np.concatenate(each) for each in zip(*parts, strict=True))
    return x, y, weights
