"""Photosites behind a round lens, computed again: E(r) integrated along the outlines, averaged over the footprint by a
Gauss rule."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64
from camsim.optics import RoundLens
from camsim.quadrature import gauss_error, gauss_legendre
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.check.along import SHORT
from camsim.rendering.check.pattern import Table, loudness, table_of
from camsim.rendering.check.points import PANEL_BLURS, PANEL_NODES, Asked, Parts, Tables, light_at_points
from camsim.rendering.check.scenery import Pieces
from camsim.rendering.check.wavelengths import condensed
from camsim.rendering.check.zones import FAR_PART, Rule, Zones, zones_of

NEAREST = 12.0  # blurs: where the search for silence begins
FEW = 4.0  # ends that some photosite hears from just outside, wherever it lies
FARTHER = 1.4  # times, at each step of it
LOOKED_AT = 24  # places in the frame where ends are heard
FALLS = 1.5  # at least this power of the distance is what swings lost with
NODE_SECONDS, PIECE_SECONDS, POINT_SECONDS = 4e-9, 5e-8, 1e-4  # of one core, measured
PASSED_SECONDS = 3e-9  # of a piece that lies in another zone
BLOCK_SECONDS = 1e-3  # of a block of nodes: to hand one on takes a tenth of it
ROUND = 5.0  # times as long for a node on a round piece: a sine and a cosine


@dataclass(frozen=True, kw_only=True, eq=False)
class Integrals:
    """The check's settings for a round lens; lengths in pitches.

    sides, spots : of the photosite, (n, 2) of the OLPF, pitches
    pieces, pair, times : of the scene, what lies beside each, and by how much more or less of it
    wavelength_nm, weights : (n,) and (pairs, channels, n) left minus right, of full scale
    budget       : of what the check may be wrong by
    corners      : (4,) low x, low y, high x, high y of the outermost photosites
    """

    lens: RoundLens
    sides: tuple[float, float]
    spots: F64
    pitch_um: float
    pieces: Pieces
    pair: I64
    times: F64
    wavelength_nm: F64
    weights: F64
    budget: ErrorBudget
    corners: F64

    @functools.cached_property
    def rule(self) -> Rule:
        """Nodes (m, 2) and weights (m,) over photosite and spots, that follow the shortest wave."""
        return self._rule(max(self._orders))

    @functools.cached_property
    def zones(self) -> Zones:
        """This rule for what is near, and others of fewer nodes."""
        contrast = np.abs(self.weights).sum(axis=2).max(axis=1)[self.pair] * np.abs(self.times)
        strength, light = contrast * self.pieces.outlines.length, 0.0
        for gap in self._gaps():
            # What is near a listener is far from others: nowhere is it louder there than at the radius.
            light = max(light, float(np.sum(strength / np.maximum(gap, self.radius))))
        return zones_of(
            self._rule,
            order=max(self._orders),
            half=0.5 * max(self.sides),
            light=light / math.tau,
            allowed=FAR_PART * self.budget.allowed("footprint rule"),
        )

    @functools.cached_property
    def _orders(self) -> list[int]:
        """How many nodes follow the shortest wave along either side."""
        shortest = float(self._blur.min())
        orders, allowed = [], math.log((1.0 - FAR_PART) * self.budget.allowed("footprint rule"))
        for side in self.sides:
            order = 1 if side == 0.0 else 3
            while side and gauss_error(order, math.pi * side / shortest) > allowed:
                order += 1
            orders.append(order)
        return orders

    def _rule(self, most: int) -> Rule:
        """Return nodes (m, 2) and weights (m,) over photosite and spots, at most so many along a side."""
        axes = [gauss_legendre(min(order, most)) for order in self._orders]
        (x, wx), (y, wy) = ((0.5 * side * x, 0.5 * w) for side, (x, w) in zip(self.sides, axes, strict=True))
        square = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        nodes = (self.spots[:, None] + square).reshape(-1, 2)
        return nodes, np.tile(np.outer(wx, wy).ravel() / len(self.spots), len(self.spots))

    @functools.cached_property
    def radius(self) -> float:
        """Distance from which on no end, no corner and no line is heard: E is taken from its table as far as that."""
        blur, everything = float(self._blur.max()), self._farthest
        radius = max(NEAREST * blur, 2.0 * self._extent)
        steps = math.ceil(math.log(everything / radius, FARTHER)) if everything > radius else 0
        radii: F64 = radius * FARTHER ** np.arange(steps, dtype=float)
        for radius, beyond in zip(radii.tolist(), self._heard_beyond(radii).tolist(), strict=True):
            loud = self._swing_at(radius) * math.sqrt(blur / radius * max(FEW, beyond))
            if loud / math.tau <= self.budget.allowed("beyond"):
                break
        else:
            radius = max(radius, everything)
        return min(radius, max(everything, NEAREST * blur)) + self._extent

    def _heard_beyond(self, radii: F64) -> F64:
        """Return Σ strength²·(radius/distance)⁵ of all ends and lines beyond each radius, where that is the most."""
        ends, strength = self._ends
        most = np.zeros_like(radii)
        for place in self._listeners if radii.size else ():  # one by one: there may be millions of ends
            h, beside = self._feet(place)
            distance = np.concatenate([np.hypot(*(ends - place).T), np.abs(h[beside])])
            loud = np.maximum(distance / radii[0], 1.0) ** -5.0
            loud *= np.concatenate([strength**2, np.full(distance.size - len(ends), 4.0)])
            shells = np.bincount(np.searchsorted(radii, distance), loud, minlength=radii.size + 1)
            most = np.maximum(most, (radii / radii[0]) ** 5 * np.cumsum(shells[::-1])[-2::-1])
        return most

    @functools.cached_property
    def seconds_each(self) -> float:
        """What one photosite is expected to take."""
        zones = list(zip(itertools.pairwise(self.zones.ends(np.array([self.radius]))), self.zones.rules, strict=True))
        passed = len(self.pieces.outlines.x) * PASSED_SECONDS
        seconds = POINT_SECONDS + passed * sum(len(points) for _, (points, _) in zones)
        for gap in self._gaps():
            nodes = self._nodes_on(gap) * NODE_SECONDS + PIECE_SECONDS
            for (low, high), (points, _) in zones:
                here = (low <= gap) & (gap < high)
                seconds += len(points) * float(nodes[here].sum()) / len(self._listeners)
        return seconds

    def _nodes_on(self, gap: F64) -> F64:
        """Return how many nodes each piece takes that lies so far away; those on round pieces as many times as long."""
        o = self.pieces.outlines
        length, bent = o.length, o.turn_rad != 0.0
        near = np.where(gap < self.radius, np.minimum(length, 2.0 * self.radius), 0.0)
        panels = np.ceil(near / (PANEL_BLURS * float(self._blur.min())))
        # Beyond the table a round piece takes panels that double in length on either side, a short one but a few nodes.
        beyond = PANEL_NODES * (2.0 + 2.0 * np.log2(1.0 + length / self.radius))
        for count, short in SHORT:
            beyond = np.where((gap > self.radius) & (0.5 * length < short * (gap + 0.5 * length)), count, beyond)
        nodes: F64 = PANEL_NODES * panels * np.where(bent, ROUND, 1.0) + ROUND * beyond * bent
        return nodes

    def _gaps(self) -> Iterator[F64]:
        """Yield how far all of each piece lies at least from one listener after the other."""
        for place in self._listeners:  # one by one: there may be millions of pieces
            yield self._parts.gaps(place[None])[0]

    def values(self, points: F64, sets: I64) -> F64:
        """Return the light at points (m, 2) besides the background's, each in its channel."""
        radius = np.array([self._radius_at(point) for point in points])
        table = self._table(float(radius.max()), float(radius.max()))
        pairs, channels = self.weights.shape[:2]
        tables = Tables(
            table.cells.reshape(pairs, channels, *table.cells.shape[1:]),
            table.step,
            table.far.reshape(pairs, channels, 4),
        )
        values: F64 = np.zeros(len(points))
        worth = math.ceil(BLOCK_SECONDS * len(self.rule[0]) / self.seconds_each)
        # All of what is farther is seen by its smooth powers, wherever on the photosite.
        ends = self.zones.ends(radius + self._extent)
        for (least, most), (nodes, weights) in zip(itertools.pairwise(ends), self.zones.rules, strict=True):
            if (least < most).any():
                asked = Asked(points, sets, radius, nodes, least, most)
                panel = PANEL_BLURS * float(self._blur.min())
                values += light_at_points(asked, self.pieces.outlines, self._parts, tables, panel, worth) @ weights
        return values

    @functools.cached_property
    def _parts(self) -> Parts:
        return Parts.of(self.pieces.outlines, self.pair, self.times)

    @functools.cached_property
    def _extent(self) -> float:
        """How far the rule reaches from a photosite's middle."""
        return float(np.hypot(*self.rule[0].T).max())

    @functools.cached_property
    def _blur(self) -> F64:
        return self._blur_at(self.wavelength_nm)

    def _blur_at(self, wavelength_nm: F64) -> F64:
        return np.array([self.lens.blur_um(float(w)) for w in wavelength_nm]) / self.pitch_um

    def _table(self, least: float, wanted: float) -> Table:
        """Return the lens tabulated out to ``least`` or farther: one that is there, or a new one out to ``wanted``."""
        there = [table for radius, table in self._tables if radius >= least]
        if not there:
            self._tables.append((wanted, self._tabulated(wanted)))
            there = [self._tables[-1][1]]
        return there[0]

    @functools.cached_property
    def _tables(self) -> list[tuple[float, Table]]:
        return []

    def _tabulated(self, radius: float) -> Table:
        """Tabulate the lens out to a distance, with as many wavelengths as it takes there."""
        phase = math.tau * radius * float(1.0 / self._blur.min() - 1.0 / self._blur.max())
        allowed = self.budget.allowed("own wavelengths")
        nm, weights = condensed(self.wavelength_nm, self.weights, phase=phase, allowed=allowed)
        return table_of(self.lens, self._blur_at(nm), weights.reshape(-1, nm.size), radius, self.budget.tolerance)

    @functools.cached_property
    def _listeners(self) -> F64:
        """Places (n, 2) of the frame: ends of outlines, moved into it, and its middle."""
        ends = self._ends[0]
        some = ends[:: max(1, len(ends) // LOOKED_AT)]
        low, high = self.corners[:2], self.corners[2:]
        return np.concatenate([np.clip(some, low, high), [0.5 * (low + high)]])

    @property
    def _farthest(self) -> float:
        """No piece reaches farther than this from any photosite."""
        o = self.pieces.outlines
        straight = o.turn_rad == 0.0
        more = np.where(straight, 0.0, o.dx)
        x, y = np.concatenate([o.x, o.x + straight * o.dx]), np.concatenate([o.y, o.y + straight * o.dy])
        x0, y0, x1, y1 = self.corners
        across = np.maximum(np.abs(x - x0), np.abs(x - x1)) + np.tile(more, 2)
        down = np.maximum(np.abs(y - y0), np.abs(y - y1)) + np.tile(more, 2)
        return float(np.hypot(across, down).max(initial=0.0))

    @functools.cached_property
    def _ends(self) -> tuple[F64, F64]:
        """Ends of pieces (n, 2), and how strong each is: how its direction jumps, at most as at a right angle (1)."""
        o = self.pieces.outlines
        straight = o.turn_rad == 0.0
        begin, finish = o.from_rad, o.from_rad + o.turn_rad
        cos, sin = np.cos([begin, finish]), np.sin([begin, finish])
        first = np.stack([o.x + o.dx * ~straight * cos[0], o.y + o.dx * ~straight * sin[0]])
        last = np.stack([o.x + o.dx * np.where(straight, 1.0, cos[1]), o.y + np.where(straight, o.dy, o.dx * sin[1])])
        size = np.where(straight, np.hypot(o.dx, o.dy), 1.0)
        leaves, comes = (
            np.stack([np.where(straight, o.dx / size, -sin[k]), np.where(straight, o.dy / size, cos[k])])
            for k in (0, 1)
        )
        x, y = np.round(np.concatenate([first, last], axis=1), 9)
        places, index = np.unique(x + 1j * y, return_inverse=True)
        jump = np.zeros((places.size, 2))
        np.add.at(jump, index, np.concatenate([leaves, -comes], axis=1).T)
        return places.view(float).reshape(-1, 2), np.minimum(np.hypot(*jump.T) / math.sqrt(2.0), 1.0)

    def _feet(self, place: F64) -> tuple[F64, np.ndarray]:
        """Return (pieces,): distance from each straight piece's line, and whether its foot lies on the piece."""
        o = self.pieces.outlines
        straight = o.turn_rad == 0.0
        length = np.where(straight, np.hypot(o.dx, o.dy), 1.0)
        dx, dy = o.x - place[0], o.y - place[1]
        h = (dx * o.dy - dy * o.dx) / length
        s = -(dx * o.dx + dy * o.dy) / length
        return h, straight & (s > 0.0) & (s < length)

    def _radius_at(self, place: F64) -> float:
        """Return how far E is taken from its table for one photosite: farther where rings meet in it."""
        o, blur, base = self.pieces.outlines, float(self._blur.max()), self.radius
        if not len(o.x):
            return base
        allowed = self.budget.allowed("meeting")
        gap = np.hypot(o.x - place[0], o.y - place[1])
        about = (o.turn_rad > 0.0) & (gap < 0.3 * o.dx) & (o.dx > base)
        radius = base
        if about.any():
            loud = self._swing * (base / np.maximum(o.dx, base)) ** FALLS * o.turn_rad / math.tau > allowed
            radius = float((o.dx + gap)[about & loud].max(initial=base - blur)) + blur
        h, beside = self._feet(place)
        length = np.hypot(o.dx, o.dy)
        far = beside & (np.abs(h) > base)
        if np.count_nonzero(far) > 2:
            distance = np.abs(h[far])
            share = np.minimum(length[far], np.sqrt(blur * distance)) / distance / math.tau
            shell = np.floor(distance / (0.5 * blur)).astype(np.int64)
            _, index = np.unique(shell, return_inverse=True)
            together = np.bincount(index.ravel(), weights=share)[index.ravel()]
            loud = self._swing * (base / distance) ** FALLS * together > allowed
            radius = max(radius, float(distance[loud].max(initial=base)) + blur)
        return radius

    @functools.cached_property
    def _swing(self) -> float:
        return self._swing_at(self.radius)

    def _swing_at(self, radius: float) -> float:
        """Return how far E swings about its smooth powers near a distance."""
        blur = float(self._blur.max())
        more = self._extent + 6.0 * blur
        # Twice as far: the search goes on from here, and most photosites take a table that is there.
        return loudness(self._table(radius + more, 2.0 * radius + more), radius, blur, *self.rule)
