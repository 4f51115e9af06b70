"""An aberrated lens's difference as the check knows it: its transfer, by overlaps of the pupil with itself.

T(f) = ∫ exp(2πi·(W(x − fλN) − W(x + fλN))) over what two pupils have in common, W about the move, less what a plane
wavefront leaves: a function of |f|·λN, the angle and the wavelength that is smooth in all three. It is followed on
nodes, and added up over wavelengths. The engines make their patterns from the pupil's amplitude; no pattern is made
here, none is tapered, and what was followed is held against overlaps elsewhere before it is used.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.optics.airy import NM_PER_UM, airy_otf
from camsim.optics.difference import Difference
from camsim.quadrature import barycentric, chebyshev
from camsim.rendering.angular import Transfer
from camsim.rendering.check.overlap_kernels import fuse, overlap_nodes
from camsim.rendering.check.overlap_sizes import PLACES, Sizes, sizes_of
from camsim.rendering.check.overlap_sums import add_to, direct
from camsim.rendering.job import Job

MOST_WAVES = 3.0  # over the pupil: more take longer than patterns do
SAME_PATH = 1e-12  # waves: a path difference that is this nearly one length at all wavelengths is
UNTAPERED = 2.0  # times what may lie beyond the reach: nothing is spent on a taper
MOST_NODES, OF_A_COLOUR = 7e5, 2e4  # of all overlaps, and more for each wavelength that would take a pattern
CHECKED = 0.15  # of a tolerance: what the transfers may be wrong by (a quarter of a taper's share, where none is)
ROUNDS = 4
NOTHING = 1e-13  # of a harmonic
KEPT_BYTES = 1 << 23  # of transfers on a window's frequencies


@dataclass(frozen=True, kw_only=True)
class Overlapping:
    """A difference whose transfer is known from overlaps: a lens that transforms take as it is, without a taper.

    sizes : where a search for nodes begins
    """

    place: ClassVar[str] = "lens"
    fades: ClassVar[bool] = True

    rest: Difference
    sizes: Sizes

    def blur_um(self, wavelength_nm: float) -> float:
        """As the difference's."""
        return self.rest.blur_um(wavelength_nm)

    def cutoff_per_um(self, wavelength_nm: float) -> float:
        """As the difference's."""
        return self.rest.cutoff_per_um(wavelength_nm)

    def otf(self, fx_per_um: F64, fy_per_um: F64, wavelength_nm: float) -> F64:
        """As the difference's."""
        return self.rest.otf(fx_per_um, fy_per_um, wavelength_nm)

    def waves_turned(self, low_nm: float, high_nm: float) -> float:
        """As the difference's."""
        return self.rest.waves_turned(low_nm, high_nm)

    def light_beyond(self, distance_um: F64, wavelength_nm: float, rings: float = 1.0) -> F64:
        """As the difference's."""
        return self.rest.light_beyond(distance_um, wavelength_nm, rings)

    def reach_um(self, lost_fraction: float, wavelength_nm: float, rings: float = 1.0) -> float:
        """As the difference's for ``UNTAPERED`` times as much."""
        return self.rest.reach_um(UNTAPERED * lost_fraction, wavelength_nm, rings)

    def fused(self, wavelength_nm: F64, weights: F64, allowed: float) -> Fused:
        """Return transfers of sets of weights (sets, wavelengths), as far as they may be wrong.

        Where ``ROUNDS`` of more and more nodes do not follow them the last are taken: what they are wrong by the check
        takes for the image's error, and tells.
        """
        return _fused(self.rest, self.sizes, tuple(wavelength_nm.tolist()), weights.tobytes(), len(weights), allowed)


def followed(job: Job, wavelength_nm: F64) -> Job:
    """Return a difference's job behind what follows its transfer.

    Or as it is, where overlaps would take longer than patterns: obstructions, many waves, paths of no one length.
    """
    rest = job.system.lens
    assert isinstance(rest, Difference)
    low, high = float(wavelength_nm.min()), float(wavelength_nm.max())
    if rest.obstruction or rest.lens.waves_across(low) > MOST_WAVES:
        return job
    x, y, _ = overlap_nodes(4, np.array([0.3]))
    paths = [rest.lens.waves(x, y, nm) * nm / low for nm in np.linspace(low, high, 5).tolist()]
    most = MOST_NODES + OF_A_COLOUR * wavelength_nm.size
    sizes = sizes_of(rest, low, high, CHECKED * job.tolerance, most)
    if sizes is None or any(np.abs(own - paths[0]).max() > SAME_PATH for own in paths):
        return job
    return job.behind(Overlapping(rest=rest, sizes=sizes))


@dataclass(frozen=True, eq=False)
class Fused:
    """Transfers about the move: ``transfer`` by cycles/µm."""

    transfer: Transfer
    moved_um: tuple[float, float]

    def on_half_plane(self, steps_per_um: tuple[float, float], counts: tuple[int, int]) -> C128:
        """Return the transfers (sets, j, i) at (i, j)·steps, i from 0 on, j of either sign; counts: of 0 and above."""
        key = steps_per_um, counts
        if key not in self._kept:
            self._kept.clear()
            found = self._on_half_plane(*key)
            if found.nbytes > KEPT_BYTES:
                return found
            found.flags.writeable = False
            self._kept[key] = found
        return self._kept[key]

    @cached_property
    def _kept(self) -> dict[tuple[tuple[float, float], tuple[int, int]], C128]:
        """What the last window took, for the next rendering's."""
        return {}

    def _on_half_plane(self, steps_per_um: tuple[float, float], counts: tuple[int, int]) -> C128:
        quarters = self.transfer.on_quarters(steps_per_um, counts)
        found = np.empty((len(quarters), 2 * counts[1] - 1, counts[0]), complex)
        for part, values in ((found.real, quarters[:, :, :, 0]), (found.imag, quarters[:, :, :, 1])):
            part[:, counts[1] - 1 :], part[:, : counts[1] - 1] = values[:, 0], values[:, 1, :0:-1]
        frequency = steps_per_um[0] * np.arange(counts[0]), steps_per_um[1] * np.arange(1 - counts[1], counts[1])
        across, down = (np.exp(-2j * np.pi * f * c) for f, c in zip(frequency, self.moved_um, strict=True))
        found *= across
        found *= down[:, None]
        return found

    def at(self, fx_per_um: F64, fy_per_um: F64) -> C128:
        """Return the transfers (sets, n) at frequencies (n,)."""
        turn = np.exp(-2j * np.pi * (fx_per_um * self.moved_um[0] + fy_per_um * self.moved_um[1]))
        found: C128 = self.transfer.at(fx_per_um, fy_per_um) * turn
        return found


@functools.lru_cache(maxsize=4)
def _fused(
    rest: Difference, sizes: Sizes, wavelength_nm: tuple[float, ...], packed: bytes, sets: int, allowed: float
) -> Fused:
    nm, weights = np.array(wavelength_nm), np.frombuffer(packed).reshape(sets, -1)
    rng, rounds = np.random.default_rng(len(wavelength_nm)), ROUNDS
    # Within all wavelengths' cut-offs: what a look-up errs by at one of them is as narrow as a row.
    place = np.stack([rng.uniform(0.05, 0.95, PLACES) / rest.blur_um(nm.max()), rng.uniform(0.0, np.pi, PLACES)])
    fx, fy = place[0] * np.cos(place[1]), place[0] * np.sin(place[1])
    while True:
        right = direct(rest, nm, weights, place, sizes.finer_rule)
        transfer = _followed(rest, nm, weights, sizes)
        rounds -= 1
        if not rounds or np.abs(transfer.at(fx, fy) - right).max() <= allowed:
            return Fused(transfer, rest.moved_um)
        sizes = sizes.larger()


def _followed(rest: Difference, nm: F64, weights: F64, sizes: Sizes) -> Transfer:
    """Return fused transfers by cycles/µm."""
    first, last = float(1.0 / nm.max()), float(1.0 / nm.min())
    shift = 1.0 - (0.5 * (1.0 + chebyshev(sizes.shifts))) ** 2
    angle = np.pi * np.arange(sizes.angles) / sizes.angles
    # Evenly over 1/λ, so that each phase follows from the one before.
    waves = np.linspace(1.0, last / first, sizes.colours)
    samples = np.zeros((sizes.shifts, sizes.angles, sizes.colours, 2))
    add_to(rest, 1.0 / first, sizes.rule, shift, angle, waves, samples)
    values = np.moveaxis(samples, 2, 0)
    transfers: C128 = values[..., 0] + 1j * values[..., 1]
    transfers -= airy_otf(shift, f_number=1.0, wavelength_nm=NM_PER_UM)[:, None]
    columns, order, sine = _harmonics(transfers)
    blur = np.array([rest.blur_um(w) for w in nm.tolist()])
    cut = 1.0 / float(blur.min())
    frequency = cut / sizes.rows * np.arange(-2.0, sizes.rows + 4.0)
    binomial = np.array([(-1.0) ** k * math.comb(sizes.colours - 1, k) for k in range(sizes.colours)])
    own = barycentric(waves, binomial, 1.0 / (first * nm), same=1e-13)
    table = np.zeros((frequency.size, len(weights), columns.shape[2]))
    fused = functools.partial(fuse, frequency, blur, weights, own, columns.reshape(-1, columns.shape[2]), table)
    shared(frequency.size, fused)
    return Transfer.of(np.moveaxis(table, 1, 2), sizes.rows / cut, order, sine, cut)


def _harmonics(values: C128) -> tuple[F64, I64, I64]:
    """Return columns (colours, shifts, columns) of transfers (…, half a circle of angles), their orders and sines.

    Half a turn on a transfer is its conjugate: real parts have even harmonics, imaginary ones odd.
    """
    count = values.shape[-1]
    turn = np.exp(-1j * np.pi * np.arange(count) / count)
    even = scipy.fft.fft(values.real, axis=-1, norm="forward")[..., : (count + 1) // 2]
    odd = scipy.fft.fft(values.imag * turn, axis=-1, norm="forward")[..., : (count + 1) // 2]
    order = np.concatenate([2 * np.arange(even.shape[-1]), 2 * np.arange(odd.shape[-1]) + 1])
    both = np.concatenate([even, odd], axis=-1) * np.where(order == 0, 1.0, 2.0)
    columns = np.concatenate([both.real, -both.imag], axis=-1)
    sine = np.repeat([0, 1], order.size)
    kept = np.flatnonzero(np.abs(columns).max(axis=(0, 1)) > NOTHING)
    return np.ascontiguousarray(columns[..., kept]), np.tile(order, 2)[kept], sine[kept]
