"""Tables of a lens's transfer, weighted for each channel, that the sums over frequencies interpolate.

A table covers the frequencies of one level. A rotationally symmetric lens has curves over radial frequency, a pupil has
tables over radius and direction, and a lens known only by its ``otf`` is evaluated row by row.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import C128, F64, I64
from camsim.core.cached import cached_property
from camsim.numerics.matrix_products import real_product
from camsim.optics import OpticalSystem
from camsim.optics.annular import AnnularAiry
from camsim.optics.of_pupil import OfPupil
from camsim.optics.protocols import Round, Separable
from camsim.optics.transfer_table import NO_BORDER, TransferTable, in_directions, transfer_table
from camsim.rendering.modes import spanning
from camsim.rendering.waves.levels import Lattice, Level

FEWEST_POINTS, MOST_POINTS = 2048, 1 << 20
POLAR_POINTS = 32  # smallest number along the radius
MOST_POLAR, MOST_STEPS, FEW_RADII = 2048, 1000, 24  # largest radial points and directions of a table; radii for tests
OF_RADII = 6.0  # points per radius of the transfer table, for cubic interpolation at 1e-5
ASKED = 180  # directions in which a lens without a table is sampled; one degree resolves an aspect ratio of 16
FEW_KINDS, FREQUENCIES = 3, 48  # kinds up to which no reduction is tried; radial frequencies for it


@dataclass(frozen=True, kw_only=True, eq=False)
class Lens:
    """The transfer of a lens, in the form that the frequency sums need.

    system        : the lens and the custom stages behind it; frequencies of its transfers are in cycles/pitch here
    wavelength_nm : (j,) nodes
    allowed       : largest error of a transfer
    """

    system: OpticalSystem
    wavelength_nm: F64
    pitch_um: float
    allowed: float

    @property
    def is_round(self) -> bool:
        """Whether the transfer depends on the radial frequency alone."""
        return isinstance(self.system.lens, Round) and not self.system.more

    @property
    def is_pupil(self) -> bool:
        """Whether the transfer is tabulated over radius and direction."""
        return isinstance(self.system.lens, OfPupil) and not self.system.more

    @cached_property
    def _table(self) -> TransferTable:
        lens = self.system.lens
        assert isinstance(lens, OfPupil)
        return transfer_table(lens, tuple(self.wavelength_nm.tolist()), self.allowed)

    def curves(self, level: Level, weights: F64) -> tuple[F64, float]:
        """Return (points, kinds, channels) at even radial frequencies, and points per cycle/pitch.

        weights : (kinds, channels, j)
        """
        lens = self.system.lens
        bends = 2.0 / (1.0 - lens.obstruction) if isinstance(lens, AnnularAiry) else 1.0  # finer for a narrow annulus
        points = int(min(MOST_POINTS, bends * max(FEWEST_POINTS, math.sqrt(1.0 / self.allowed)))) + 1
        frequency = np.linspace(0.0, level.cut, points)
        fx, zero = frequency / self.pitch_um, np.zeros_like(frequency)
        otf = np.stack([np.real(self.system.point_otf(fx, zero, nm)) for nm in self.wavelength_nm.tolist()])
        curves = np.einsum("kcj,jn->nkc", weights, otf)
        return np.ascontiguousarray(curves), (points - 1) / level.cut

    def polar(self, level: Level, weights: F64) -> tuple[tuple[F64 | C128, I64], float, tuple[float, float, int, F64]]:
        """Return the transfer (points, directions, kinds, channels), its scale and its panels of directions.

        The table comes with the number of channels at each point; the scale is in points per cycle/pitch. See
        ``kernels.add_polar`` for the panels: cubic interpolation needs one more direction on each side.
        """
        table = self._table
        radii, directions = table.values.shape[1:]
        each = min(max(OF_RADII * (1e-5 / self.allowed) ** 0.25, 3.0), 24.0)
        share = level.cut / self.pitch_um * float(table.blur_um.min()) / table.outer
        points = max(POLAR_POINTS, min(math.ceil(each * radii * share), MOST_POLAR))
        there, panels = np.full(points + 1, weights.shape[1]), (0.0, 0.0, 1, NO_BORDER)
        stretched, turn, steps = level.cut, -0.5 * math.pi, _steps(table, self.allowed)
        if table.panels:
            border = np.concatenate([table.border, -table.border[:1]])
            stretched *= float(np.hypot(*table.border.T).max())
            panels = table.first_rad, table.panels / math.pi, steps, border
        found = table.at(np.linspace(0.0, stretched / self.pitch_um, points + 1))
        mixed: F64 | C128 = real_product(weights.reshape(-1, len(found)), found.reshape(len(found), -1))
        mixed = mixed.reshape(*weights.shape[:2], *found.shape[1:])
        if table.panels:
            mixed = table.in_panels(mixed, steps)
            mixed = np.concatenate([mixed, mixed[..., :1, :].conj()], axis=-2)  # half a turn on it is the conjugate
            mixed = mixed.reshape(*mixed.shape[:3], -1)
        elif directions > 1:
            panels = turn, 1.0 / math.pi, steps, NO_BORDER
            mixed = in_directions(mixed, steps, turn)
            mixed = np.concatenate([mixed[..., -1:].conj(), mixed, mixed[..., :2].conj()], axis=-1)
        return (_plain(np.moveaxis(mixed, (0, 1), (2, 3))), there), points / stretched, panels

    def size(self, frequency: F64, light: F64) -> F64:
        """Return the largest transfer over all directions at frequencies (n,), cycles/pitch; light: (j,) weights."""
        size: F64 = np.einsum("j,jn->n", light, np.abs(self._around(frequency)).max(axis=2))
        return size

    def _around(self, frequency: F64) -> F64 | C128:
        """Return transfers (j, n, directions) at radial frequencies (n,), cycles/pitch."""
        per_um = frequency / self.pitch_um
        if self.is_pupil:
            return self._table.at(per_um * self._table.nearest)
        angle = np.pi * np.arange(1 if self.is_round else ASKED) / ASKED
        fx, fy = np.outer(per_um, np.cos(angle)), np.outer(per_um, np.sin(angle))
        return np.stack([np.asarray(self.system.point_otf(fx, fy, nm), complex) for nm in self.wavelength_nm.tolist()])

    def mixed(self, weights: F64, allowed: float) -> F64:
        """Return the mixtures (k, kinds) of ``spanning`` for the transfers of all kinds.

        weights : (kinds, channels, j);  allowed: error that an edge of a kind may have, ∫ |transfer|/πf df at most
        """
        kinds = len(weights)
        if kinds <= FEW_KINDS:
            return np.eye(kinds)
        step: float = self.system.highest_per_um(self.wavelength_nm) / FREQUENCIES
        number = np.arange(FREQUENCIES, dtype=np.float64) + 0.5
        angle = np.pi * np.arange(ASKED) / ASKED
        passes = self.system.footprint_otf(*(step * np.outer(way, number) for way in (np.cos(angle), np.sin(angle))))
        otf = self._around(step * self.pitch_um * number)
        otf = np.concatenate([otf.real, otf.imag], axis=2) * (np.abs(passes).max(axis=0) / (np.pi * number))[:, None]
        return spanning(np.einsum("kcj,jna->kcan", weights, otf).reshape(kinds, -1, FREQUENCIES), allowed)

    def plane(self, weights: F64, fx: F64, fy: F64) -> C128:
        """Return the transfer (kinds, channels, …) at frequencies in cycles/pitch."""
        out = np.zeros((*weights.shape[:2], *np.broadcast_shapes(fx.shape, fy.shape)), complex)
        for k, nm in enumerate(self.wavelength_nm.tolist()):
            otf = self.system.point_otf(fx / self.pitch_um, fy / self.pitch_um, nm)
            out += weights[:, :, k, None, None] * otf
        return out


def _plain(polar: F64 | C128) -> F64 | C128:
    """Return a contiguous table, without imaginary parts if they are all 0."""
    real: F64 = polar.real
    return np.array(polar, complex, order="C") if polar.imag.any() else np.ascontiguousarray(real)


@functools.lru_cache(maxsize=64)
def _steps(table: TransferTable, allowed: float) -> int:
    """Return the steps of direction, in half a turn or in a panel, that cubic interpolation needs at any radius."""
    directions = table.values.shape[2]
    few = table.at(np.linspace(0.0, table.outer / float(table.blur_um.min()), FEW_RADII + 1))
    if table.panels:
        # A step beyond a panel must lie close to its Chebyshev nodes: polynomials grow fast outside of them.
        close = min(max(12, (directions // table.panels // 6) ** 2), MOST_STEPS)
        return _followed(lambda count: table.in_panels(few, count), close, allowed)
    if directions == 1:
        return 1
    return _followed(lambda count: in_directions(few, count, -0.5 * math.pi), max(32, directions), allowed)


def _followed(asked: Callable[[int], F64 | C128], fewest: int, allowed: float) -> int:
    """Return how many steps suffice for cubic interpolation, tested at the midpoints of a table twice as fine."""
    steps = fewest
    while steps < MOST_STEPS:
        known = asked(2 * steps)
        nodes, right = known[..., ::2], known[..., 3:-3:2]
        found = (9.0 * (nodes[..., 1:-2] + nodes[..., 2:-1]) - nodes[..., :-3] - nodes[..., 3:]) / 16.0
        count = min(found.shape[-1], right.shape[-1])
        if np.abs(found[..., :count] - right[..., :count]).max() <= allowed:
            break
        steps *= 2
    return steps


@dataclass(frozen=True, kw_only=True, eq=False)
class Footprint:
    """The transfer of OLPF and photosite, which no wavelength changes."""

    system: OpticalSystem
    pitch_um: float

    def on(self, lattice: Lattice) -> tuple[C128, C128, C128]:
        """Return the footprint's transfer along x (m,) and along y (2n − 1,), and its inseparable factor, or (0, 0)."""
        columns = lattice.counts[0]
        fx = np.arange(columns) / (lattice.periods[0] * self.pitch_um)
        fy = np.array(lattice.rows) / (lattice.periods[1] * self.pitch_um)
        across, down, both = np.ones(columns, complex), np.ones(fy.size, complex), np.empty((0, 0), complex)
        for stage in (self.system.olpf, self.system.photosite):
            if stage is None:
                continue
            if isinstance(stage, Separable) and stage.separable:
                across = across * stage.otf(fx, np.zeros_like(fx), 0.0)
                down = down * stage.otf(np.zeros_like(fy), fy, 0.0)
            else:
                one = np.asarray(stage.otf(fx[None, :], fy[:, None], 0.0), complex)
                both = one if not both.size else both * one
        return across, down, both
