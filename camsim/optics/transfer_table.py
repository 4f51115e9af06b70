"""Tables of a pupil's OTF over radius and direction, at several wavelengths, for interpolation.

In polar coordinates the transfer of a pupil is smooth: the cone at zero frequency is a straight line along each
direction, and near the cut-off, where it falls as (1 − ρ)^{3/2}, nodes lie like 1 − t². So few nodes suffice; their
number is found by comparison with directly computed values between them.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from camsim.core.arrays import C128, F64, I64
from camsim.core.cached import cached_property
from camsim.errors import UnsupportedError
from camsim.numerics.matrix_products import product, real_product
from camsim.numerics.quadrature import chebyshev, interpolation
from camsim.optics.of_pupil import OfPupil
from camsim.optics.overlaps import Overlaps

AT_ONCE = 1 << 18  # weights of interpolation, of all wavelengths that are computed together
MOST_WORK = 5e9  # nodes of all of a table in one strip of an overlap: a minute
RADII = 10, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512
DIRECTIONS = 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256
IN_PANEL = 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192
PANEL_TRIED = 0.023, 0.19, 0.46, 0.71, 0.94  # of a panel
ANGLES_TRIED = tuple((0.02 + np.pi * np.arange(12) / 12).tolist())
RADII_TRIED, DIRECTIONS_TRIED = (
    (0.15, 0.45, 0.8, 0.97),  # near the cut-off only opposite rims overlap, whose phase changes fastest with direction
    (0.031, 0.173, 0.342, 0.561, 0.777, 0.913),
)  # of the largest; of half a turn


NO_BORDER: F64 = np.empty((0, 2))


@dataclass(frozen=True, eq=False)
class TransferTable:
    """Transfers at ρ = |f|·λN, 0 … 1 times ``outer``, and directions 0 … π.

    breaks  : ρ between which the transfer is smooth, from 0 to 1; it has a power 3/2 at each
    values  : (j, radii, directions) at Chebyshev nodes of each piece; directions evenly from 0 to below π, or at
              Chebyshev nodes of each panel
    panels  : number of equal panels in half a turn from ``first_rad`` on, for a pupil with straight sides, else 0. In
              the direction of a side the transfer has a kink, which makes the PSF's spikes
    border  : (panels, 2) vectors whose product with f·λN is 1 at the cut-off; ρ is that product then
    blur_um : (j,) λN
    """

    wavelength_nm: F64
    blur_um: F64
    outer: float
    breaks: tuple[float, ...]
    values: C128
    panels: int
    first_rad: float
    border: F64

    @property
    def nearest(self) -> float:
        """Smallest ρ of a vector f·λN of length 1, in the direction of the border's corners."""
        if not self.panels:
            return 1.0
        ends = self.first_rad + (np.pi / self.panels) * (np.arange(self.panels) + np.array([[0.0], [1.0]]))
        return float((self.border[:, 0] * np.cos(ends) + self.border[:, 1] * np.sin(ends)).min())

    def at(self, frequency_per_um: F64) -> F64 | C128:
        """Return transfers (j, n, directions) in the table's own directions, at (n,) values of ρ/λN."""
        known = self._plain
        kind = complex if np.iscomplexobj(known) else float
        out = np.zeros((len(known), frequency_per_um.size, known.shape[2]), kind)
        rho = np.multiply.outer(self.blur_um / self.outer, frequency_per_um)
        within, step = rho < 1.0, max(1, AT_ONCE // max(known.shape[1] * frequency_per_um.size, 1))
        for first in range(0, len(known), step):
            some = slice(first, first + step)
            matrix = radial_matrix(known.shape[1], rho[some][within[some]], self.breaks)
            matrices = np.split(matrix, np.cumsum(within[some].sum(axis=1))[:-1])
            for one, values, here, each in zip(out[some], known[some], within[some], matrices, strict=True):
                one[here] = real_product(each, values)
        return out

    @cached_property
    def _plain(self) -> F64 | C128:
        """The values, without imaginary parts if they are all 0."""
        return self.values if self.values.imag.any() else np.ascontiguousarray(self.values.real)

    def in_panels(self, values: F64 | C128, each: int) -> F64 | C128:
        """Return transfers (…, panels, each + 3) in evenly spaced directions from a step before each panel.

        values : (…, directions) as of ``at``, or sums of them
        """
        count = values.shape[-1] // self.panels
        across = np.ascontiguousarray(interpolation(chebyshev(count), 2.0 * np.arange(-1.0, each + 2.0) / each - 1.0).T)
        flat = values.reshape(-1, count)
        spread: F64 | C128 = product(np.ascontiguousarray(flat.real), across)
        if np.iscomplexobj(flat):
            spread = spread + 1j * product(np.ascontiguousarray(flat.imag), across)
        return spread.reshape(*values.shape[:-1], self.panels, each + 3)


def in_directions(transfers: F64 | C128, directions: int, angle_rad: float) -> F64 | C128:
    """Return transfers (…, directions) in evenly spaced directions over half a turn from an angle on.

    transfers : (…, n) in n evenly spaced directions from 0 on, or sums of them; n ≤ ``directions``
    """
    finer = _finer(transfers, directions, angle_rad)
    return finer if np.iscomplexobj(transfers) else finer.real


def radial_places(count: int, breaks: tuple[float, ...] = (0.0, 1.0)) -> F64:
    """Return ρ at ``count`` nodes of each piece: a + (b − a)·sin²(πt/2), t Chebyshev nodes on 0 … 1."""
    t = 0.5 * (1.0 + chebyshev(count))
    return np.concatenate([a + (b - a) * np.sin(0.5 * np.pi * t) ** 2 for a, b in pairwise(breaks)])


def radial_matrix(total: int, rho: F64, breaks: tuple[float, ...] = (0.0, 1.0)) -> F64:
    """Return the interpolation matrix (n, total) from the nodes of all pieces to ρ (n,)."""
    count = total // (len(breaks) - 1)
    out = np.zeros((rho.size, total))
    piece = np.clip(np.searchsorted(breaks, rho, side="right") - 1, 0, len(breaks) - 2)
    for k, (a, b) in enumerate(pairwise(breaks)):
        mine = piece == k
        t = (2.0 / np.pi) * np.arcsin(np.sqrt((rho[mine] - a) / (b - a)))
        out[mine, k * count : (k + 1) * count] = interpolation(chebyshev(count), 2.0 * t - 1.0)
    return out


def _finer(values: F64 | C128, directions: int, angle_rad: float) -> C128:
    """Return the table in other evenly spaced directions over half a turn: T(ρ, θ + π) is the conjugate."""
    whole = np.concatenate([values, values.conj()], axis=-1)
    count = whole.shape[-1]
    waves = np.fft.fft(whole, axis=-1) / count
    order = np.fft.fftfreq(count, 1.0 / count)
    waves = waves * np.exp(1j * order * angle_rad)
    wide = np.zeros((*values.shape[:-1], 2 * directions), complex)
    half = min(count, 2 * directions) // 2
    wide[..., :half] = waves[..., :half]
    wide[..., -half:] = waves[..., -half:]
    if half == count // 2 and 2 * directions > count:  # split the Nyquist term between both signs
        wide[..., half] = 0.5 * waves[..., half]
        wide[..., -half] *= 0.5
    turned: C128 = np.fft.ifft(wide, axis=-1)[..., :directions] * (2 * directions)
    return turned


@functools.lru_cache(maxsize=512)
def transfer_table(lens: OfPupil, wavelength_nm: tuple[float, ...], allowed: float) -> TransferTable:
    """Return a lens's table with an error of at most ``allowed``.

    The numbers of nodes along each axis, and of the integrals, are found by tests along a few lines.
    """
    at, outer = Overlaps.of(lens, np.array(wavelength_nm)), lens.pupil.outer_radius
    nodes = at.nodes_for(0.2 * allowed)
    if at.revolves:
        angle = np.zeros(1)
    elif at.panels:
        count = _fewest(IN_PANEL, lambda n: _panel_off(at, n, nodes), allowed)
        angle = at.first_rad + (np.pi / at.panels) * np.add.outer(np.arange(at.panels), _cell(count)).ravel()
    else:
        count = _fewest(DIRECTIONS, lambda n: _directions_off(at, outer, n, nodes), allowed)
        angle = np.pi * np.arange(count) / count
    radii = _fewest(RADII, lambda n: _radii_off(at, n, nodes), allowed)
    rho = radial_places(radii, at.breaks)
    asked = np.outer(rho, at.border_at(angle)).ravel(), np.tile(angle, rho.size)
    if float(np.sum(np.square(at.counts(*asked, nodes), dtype=float))) > MOST_WORK:
        raise _too_often()
    values = at(*asked, nodes)
    blur_um = np.array([lens.blur_um(nm) for nm in wavelength_nm])
    table = np.ascontiguousarray(values.reshape(len(blur_um), rho.size, angle.size))
    if not at.panels:
        return TransferTable(at.wavelength_nm, blur_um, outer, at.breaks, table, 0, 0.0, NO_BORDER)
    return TransferTable(at.wavelength_nm, blur_um, 1.0, at.breaks, table, at.panels, at.first_rad, at.border)


def _fewest(counts: tuple[int, ...], off: Callable[[int], float], allowed: float) -> int:
    """Return the smallest count with an error of at most ``allowed``."""
    for count in counts:
        if off(count) <= allowed:
            return count
    raise _too_often()


def _too_often() -> UnsupportedError:
    return UnsupportedError(
        "its wavefront turns too often over the pupil; give fewer waves of aberration, or a larger tolerance",
        key="lens",
    )


def _cell(count: int) -> F64:
    """Return Chebyshev nodes on 0 … 1."""
    return 0.5 * (1.0 + chebyshev(count))


def _panel_off(at: Overlaps, count: int, nodes: I64) -> float:
    """Return the error of interpolation between a panel's nodes, over all panels, at a few radii."""
    rho, width = np.array(RADII_TRIED), np.pi / at.panels
    tried = np.array(PANEL_TRIED)
    off = 0.0
    for panel in range(at.panels if at.symmetry_rad == math.pi else 1):
        first = at.first_rad + panel * width
        known, right = (
            at(np.outer(rho, at.border_at(angle)).ravel(), np.tile(angle, rho.size), nodes).reshape(-1, angle.size)
            for angle in (first + width * _cell(count), first + width * tried)
        )
        found = real_product(interpolation(chebyshev(count), 2.0 * tried - 1.0), known.T).T
        off = max(off, float(np.abs(found - right).max()))
    return off


def _directions_off(at: Overlaps, outer: float, count: int, nodes: I64) -> float:
    """Return the error of interpolation between directions, at a few radii."""
    rho = outer * np.array(RADII_TRIED)
    angle = np.pi * np.arange(count) / count
    values = at(np.repeat(rho, count), np.tile(angle, rho.size), nodes).reshape(-1, rho.size, count)
    between = math.pi * np.array(DIRECTIONS_TRIED)
    right = at(np.repeat(rho, between.size), np.tile(between, rho.size), nodes).reshape(-1, rho.size, between.size)
    found = np.concatenate([_finer(values, count, angle)[..., :1] for angle in between.tolist()], axis=2)
    return float(np.abs(found - right).max())


def _radii_off(at: Overlaps, count: int, nodes: I64) -> float:
    """Return √2 times the rms error of interpolation between radii, in the worst of the directions tried.

    Of an error that oscillates evenly it is the maximum; a kink where the obstruction meets a blade, at another radius
    in each direction, counts by its width. No azimuthal order up to 8 vanishes in all directions tried.
    """
    places = radial_places(count, at.breaks)
    between = 0.5 * (places[1:] + places[:-1])
    angles = ANGLES_TRIED[:1] if at.revolves else ANGLES_TRIED
    every, off = min(4, len(angles), max(1, between.size // 12)), 0.0
    for first, angle in enumerate(angles):
        tried = between[first % every :: every]  # together the directions try every place
        end = float(at.border_at(np.array([angle]))[0])
        known = at(end * places, np.full(places.size, angle), nodes)
        right = at(end * tried, np.full(tried.size, angle), nodes)
        error = real_product(radial_matrix(places.size, tried, at.breaks), known.T).T - right
        off = max(off, math.sqrt(2.0 * float(np.mean(np.abs(error) ** 2, axis=1).max())))
    return off
