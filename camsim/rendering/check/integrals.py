"""Photosites behind a round lens again: E(r) integrated along outlines, averaged over the footprint by a Gauss rule."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64
from camsim.kept import cached_property
from camsim.optics import RoundLens
from camsim.quadrature import gauss_error, gauss_legendre
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.check.along import SHORT, Rules
from camsim.rendering.check.listener import Listener
from camsim.rendering.check.meeting import MOST_PLACES, heard_until, meeting_places
from camsim.rendering.check.parts import parts_seen
from camsim.rendering.check.pattern import WINDOW, Table, loudness, muffled, table_of, table_seconds
from camsim.rendering.check.points import Asked, Tables, light_at_points, rules_of
from camsim.rendering.check.records import Parts
from camsim.rendering.check.scenery import Pieces
from camsim.rendering.check.wavelengths import condensed, condensed_to
from camsim.rendering.check.whereabouts import Whereabouts
from camsim.rendering.check.zones import FAR_PART, Rule, Zones, zones_of

NEAREST = 12.0  # blurs: where the search for silence begins
ALONG_PART = 0.1  # of what the check may be wrong by: along outlines rules leave no more of a wave
FEW = 4.0  # ends that some photosite hears from just outside, wherever it lies
FARTHER = 1.4  # times, at each step of it
GRATINGS = 128  # frequencies that pass, of which the rule over a photosite follows the worst
NOTHING = 1e-300  # that passes
LOUD_FALLS = 2.0  # the power of the distance that rings of ends fall with: where to look for silence first
NODE_SECONDS, PIECE_SECONDS, POINT_SECONDS = 4e-9, 5e-8, 1e-4  # of one core, measured
PASSED_SECONDS = 3e-9  # of a piece that lies in another zone
BLOCK_SECONDS = 1e-3  # of a block of nodes: to hand one on takes a tenth of it
ROUND = 2.7  # times as long for a node on a round piece: where it lies


@dataclass(frozen=True, kw_only=True, eq=False)
class Integrals:
    """The check's settings for a round lens; lengths in pitches.

    listener : photosite and OLPF
    pieces, pair, times : of the scene, what lies beside each, and by how much more or less of it
    wavelength_nm, weights : (n,) and (pairs, channels, n) left minus right, of full scale
    budget       : of what the check may be wrong by
    corners      : (4,) low x, low y, high x, high y of the outermost photosites
    """

    lens: RoundLens
    listener: Listener
    pitch_um: float
    pieces: Pieces
    pair: I64
    times: F64
    wavelength_nm: F64
    weights: F64
    budget: ErrorBudget
    corners: F64

    @cached_property
    def rule(self) -> Rule:
        """Nodes (m, 2) and weights (m,) over photosite and spots, that follow the shortest wave."""
        return self._rule(max(self._orders))

    @cached_property
    def zones(self) -> Zones:
        """This rule for what is near, and others of fewer nodes."""
        contrast = np.abs(self.weights).sum(axis=2).max(axis=1)[self.pair] * np.abs(self.times)
        strength, light = contrast * self.where.length, 0.0
        for _, gaps in self._gaps():
            # What is near a listener is far from others: nowhere is it louder there than at the radius.
            light = max(light, float((strength / np.maximum(gaps, self.radius)).sum(axis=1).max()))
        return zones_of(
            self._rule,
            order=max(self._orders),
            half=0.5 * max(self.listener.sides),
            light=light / math.tau,
            allowed=FAR_PART * self.budget.allowed("footprint rule"),
        )

    @cached_property
    def _orders(self) -> list[int]:
        """How many nodes along either side follow a grating of whatever frequency, as much as the lens leaves of it."""
        sharpest = int(self._blur.argmin())
        freq = np.linspace(0.0, 1.0 / self._blur[sharpest], GRATINGS + 1)[1:]
        passed = np.abs(self.lens.otf(freq / self.pitch_um, np.zeros(GRATINGS), float(self.wavelength_nm[sharpest])))
        logs, phase = np.log(np.maximum(passed, NOTHING)), np.log(math.pi * freq)
        orders, allowed = {0.0: 1}, math.log((1.0 - FAR_PART) * self.budget.allowed("footprint rule"))
        for side in set(self.listener.sides) - {0.0}:
            order, phases = 3, phase + math.log(side)
            while (logs + 2 * order * phases).max() + gauss_error(order, 1.0) > allowed:
                order += 1
            orders[side] = order
        return [orders[side] for side in self.listener.sides]

    def _rule(self, most: int) -> Rule:
        """Return nodes (m, 2) and weights (m,) over photosite and spots, at most so many along a side."""
        across, down = (min(order, most) for order in self._orders)
        square, weights = _on_square(across, down)
        nodes = (self.listener.spots[:, None] + 0.5 * np.array(self.listener.sides) * square).reshape(-1, 2)
        return nodes, np.concatenate([weights / len(self.listener.spots)] * len(self.listener.spots))

    @cached_property
    def radius(self) -> float:
        """Distance from which on no end, no corner and no line is heard: E is taken from its table as far as that."""
        blur, everything = float(self._blur.max()), self.where.farthest
        radius = max(NEAREST * blur, 2.0 * self._extent)
        steps = math.ceil(math.log(everything / radius, FARTHER)) if everything > radius else 0
        radii: F64 = radius * FARTHER ** np.arange(steps, dtype=float)
        beyond, allowed = np.maximum(FEW, self.where.heard_beyond(radii)), math.tau * self.budget.allowed("beyond")

        @functools.cache
        def loud(k: int) -> float:
            return self._swing_at(float(radii[k])) * math.sqrt(blur / float(radii[k]) * float(beyond[k])) / allowed

        k = steps
        if steps:
            # Where ends' rings are silent that are as loud at the first; from there to where it really is so.
            k = min(max(0, math.ceil(math.log(max(loud(0), 1.0), FARTHER**LOUD_FALLS))), steps - 1)
            while k > 0 and loud(k - 1) <= 1.0:
                k -= 1
            while k < steps and loud(k) > 1.0:
                k += 1
        radius = float(radii[k]) if k < steps else max(radius, everything)
        return min(radius, max(everything, NEAREST * blur)) + self._extent

    @cached_property
    def farthest(self) -> float:
        """The farthest that E is taken from its table, wherever a photosite lies."""
        x0, y0, x1, y1 = self.corners
        ends = [[x0, y0], [x0, y1], [x1, y0], [x1, y1]]
        meeting = meeting_places(self.pieces.outlines, self.corners, beyond=self.radius)[:MOST_PLACES]
        return float(self._radii(np.concatenate([self.where.listeners, ends, meeting])).max())

    def meets_until(self, allowed: float) -> float:
        """Return how far rings are heard that meet in step somewhere; 0: nowhere louder than allowed."""
        base = NEAREST * float(self._blur.max())
        places = meeting_places(self.pieces.outlines, self.corners, beyond=base)[:MOST_PLACES]
        if not len(places):
            return 0.0
        swing = self._swing_at(base)
        until = heard_until(places, self.where, base=base, swing=swing, blur=self._blur, allowed=allowed)
        return float(until.max()) if until.max() > base else 0.0

    @cached_property
    def table_seconds(self) -> float:
        """What the table is expected to take, however many photosites there are."""
        blurs, (pairs, channels, count) = self.radius / float(self._blur.min()), self.weights.shape
        allowed = self.budget.allowed("own wavelengths")
        count = condensed_to(count, phase=self._phase(self.radius), allowed=allowed)
        return table_seconds(self.lens, blurs, self.budget.tolerance, count, pairs * channels)

    @cached_property
    def seconds_each(self) -> float:
        """What one photosite is expected to take."""
        begin = self.zones.ends(np.array([self.radius]))[1:-1, 0]
        points = np.array([len(nodes) for nodes, _ in self.zones.rules])
        passed = len(self.pieces.outlines.x) * PASSED_SECONDS
        seconds = POINT_SECONDS + passed * int(points.sum())
        for listeners, gaps in self._gaps():
            nodes = self._nodes_on(listeners, gaps) * NODE_SECONDS + PIECE_SECONDS
            seconds += float(np.sum(points[np.searchsorted(begin, gaps, "right")] * nodes)) / len(self.where.listeners)
        return seconds

    def _nodes_on(self, listeners: F64, gaps: F64) -> F64:
        """Return how many nodes (listeners, pieces) take; those on round pieces as many times as long."""
        o, curves = self.pieces.outlines, self._parts.bent
        length, bent = self.where.length, o.turn_rad != 0.0
        near = self.where.within(listeners, self.radius)
        near[:, bent] = np.where(gaps < self.radius, np.minimum(length, 2.0 * self.radius), 0.0)[:, bent]
        rules = self._rules
        panel_nodes, panels = rules.panel.shape[1], np.ceil(near / rules.longest)
        within = np.where(near < rules.tiny, rules.few.shape[1], panel_nodes) * panels * np.where(bent, ROUND, 1.0)
        # Beyond the table a round piece takes panels that double in length on either side, a short one but a few nodes.
        beyond = panel_nodes * (2.0 + 2.0 * np.log2(1.0 + length / self.radius))
        for count, short in SHORT:
            beyond = np.where((gaps > self.radius) & (0.5 * length < short * (gaps + 0.5 * length)), count, beyond)
        out_there = bent & (gaps + length > self.radius)
        nodes: F64 = within + ROUND * beyond * out_there
        which = np.flatnonzero(curves.of >= 0)
        nodes[:, which] = np.where(gaps[:, which] < self.radius, curves.order[curves.of[which]], SHORT[0][0])
        return nodes

    def _gaps(self) -> Iterator[tuple[F64, F64]]:
        """Yield some listeners, and how far (listeners, pieces) all of each piece lies at least from them."""
        for listeners in self.where.some_of(self.where.listeners):
            yield listeners, self._parts.gaps(listeners)

    def values(self, points: F64, sets: I64) -> F64:
        """Return the light at points (m, 2) besides the background's, each in channels (k, m) of its own: (k, m)."""
        radius = self._radii(points)
        table = self._table(float(radius.max()) + self._parts.longest_curve)
        of_pairs = self.weights.shape[:2]
        cells, far = (own.reshape(*of_pairs, *own.shape[1:]) for own in (table.cells, table.far))
        tables = Tables(cells, table.step, far)
        # All of what is farther is seen by its smooth powers, wherever on the photosite.
        ends = self.zones.ends(radius + self._extent)
        some = np.flatnonzero((ends[:-1] < ends[1:]).any(axis=1))
        rules = [self.zones.rules[zone] for zone in some]
        nodes, counts = np.concatenate([nodes for nodes, _ in rules]), [len(nodes) for nodes, _ in rules]
        channels, zone = np.ascontiguousarray(sets.T), np.repeat(np.arange(some.size), counts)
        asked = Asked(points, channels, radius, nodes, zone, ends[some], ends[some + 1])
        worth = math.ceil(BLOCK_SECONDS * len(nodes) / self.seconds_each)
        light = light_at_points(asked, self.pieces.outlines, self._parts, tables, self._rules, worth)
        weights = np.concatenate([weights for _, weights in rules])
        # Each channel by itself: to the last bit the same, whichever others are asked for.
        return np.stack([np.einsum("mn,n->m", own.copy(), weights) for own in np.moveaxis(light, 2, 0)])

    @cached_property
    def _rules(self) -> Rules:
        return rules_of(*self._shortest)

    @cached_property
    def _shortest(self) -> tuple[float, float]:
        """The shortest wave, and what of it is left along outlines."""
        return float(self._blur.min()), ALONG_PART * self.budget.tolerance

    @cached_property
    def where(self) -> Whereabouts:
        """Where the pieces lie."""
        return Whereabouts(pieces=self.pieces, corners=self.corners)

    @cached_property
    def _parts(self) -> Parts:
        return parts_seen(self.pieces, self.pair, self.times, *self._shortest)

    @cached_property
    def _extent(self) -> float:
        """How far the rule reaches from a photosite's middle."""
        return float(np.hypot(*self.rule[0].T).max())

    @cached_property
    def _blur(self) -> F64:
        return self._blur_at(self.wavelength_nm)

    def _blur_at(self, wavelength_nm: F64) -> F64:
        return np.array([self.lens.blur_um(float(w)) for w in wavelength_nm]) / self.pitch_um

    def _table(self, radius: float) -> Table:
        """Return the lens tabulated out to a distance or farther: one that is there, or a new one."""
        if not self._tables or self._tables[-1][0] < radius:
            blur, weights = self._condensed(radius)
            self._tables.append((radius, table_of(self.lens, blur, weights, radius, self.budget.tolerance)))
        return self._tables[-1][1]

    @cached_property
    def _tables(self) -> list[tuple[float, Table]]:
        return []

    def _condensed(self, radius: float) -> tuple[F64, F64]:
        """Return blurs (n,) and weights (k, n) of as many wavelengths as it takes out to a distance."""
        allowed = self.budget.allowed("own wavelengths")
        nm, weights = condensed(self.wavelength_nm, self.weights, phase=self._phase(radius), allowed=allowed)
        return self._blur_at(nm), weights.reshape(-1, nm.size)

    def _phase(self, radius: float) -> float:
        """What a wave turns by over the spectrum at a distance, radians."""
        return math.tau * radius * float(1.0 / self._blur.min() - 1.0 / self._blur.max())

    def _radii(self, points: F64) -> F64:
        """Return how far E is taken from its table for points (n, 2): farther where rings meet in one."""
        allowed = self.budget.allowed("meeting")
        return heard_until(points, self.where, base=self.radius, swing=self._swing, blur=self._blur, allowed=allowed)

    @cached_property
    def _swing(self) -> float:
        return self._swing_at(self.radius)

    def _swing_at(self, radius: float) -> float:
        """Return how far E swings about its smooth powers near a distance."""
        longest, envelope, allowed = float(self._blur.max()), self.listener.envelope, self.budget.tolerance
        farther = self._extent + (6.0 if envelope is None else WINDOW) * longest
        blur, weights = self._condensed(radius + farther)
        if envelope is not None:
            return muffled(self.lens, blur, weights, radius, longest=longest, envelope=envelope, allowed=allowed)
        return loudness(self.lens, blur, weights, radius, longest=longest, rule=self.rule, allowed=allowed)


@functools.cache
def _on_square(across: int, down: int) -> Rule:
    """Return nodes (m, 2) and weights (m,), of 1 in all, over −1 … 1 both ways."""
    (x, wx), (y, wy) = gauss_legendre(across), gauss_legendre(down)
    nodes = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return nodes, 0.25 * np.outer(wx, wy).ravel()
