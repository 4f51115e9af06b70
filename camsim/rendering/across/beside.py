"""What a band shows beside lines that bend a little: a look-up for every photosite, and no transform.

At distance d from a straight edge of direction φ a photosite sees ∫ M(f·n)/(2πif)·exp(2πifd) df, n across the edge, M
the transfer of its own place with all that goes with it. An edge that is curved by κ has moved by κt²/2 a way t along
it: that shows κ/2 of the pattern's second moment along it, κ/8π² of ∂²M/∂k² across n. Both are made at a few places
along a piece, and of each at a few across; what lies between is interpolated.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64, U8
from camsim.kept import cached_property
from camsim.kernels import ahead, shared
from camsim.optics import OpticalSystem
from camsim.quadrature import chebyshev, interpolation
from camsim.rendering.across.bands import Band
from camsim.rendering.across.kernels import AFTER, BEFORE
from camsim.rendering.across.line_kernels import Pieces, Responses, add_pieces, look_up
from camsim.rendering.across.transfers import Transfers
from camsim.rendering.fast_length import fast_length

ANGLE = 0.02  # radians, over which a transfer's second difference is taken
TOGETHER, AHEAD = 64, 4  # pieces, and so many times as many that are made beside one another
SPARE = 4  # steps of a table on either side


def repeats(band: Band, step: float) -> bool:
    """Whether responses from frequencies so far apart repeat within a band's reach."""
    return 2.0 * step * (band.reach + SPARE) > 1.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Beside:
    """Responses of one band.

    angles  : points of half a circle from which transfers are looked up
    counts  : places along a piece, and across it
    shares  : (spectra, sets) of each transfer there is on a side;  channel: (sets,) of each transfer
    """

    system: OpticalSystem
    transfers: Transfers
    angles: int
    band: Band
    pitch_um: float
    counts: tuple[int, int]
    shares: F64
    channel: I64

    @cached_property
    def _rows(self) -> int:
        """Frequencies of the transfers up to the band's end."""
        return min(int(self.transfers.harmonics.shape[2]), math.ceil(self.band.cut / self.transfers.step) + 1)

    @cached_property
    def _stride(self) -> int:
        """From one frequency to the next that responses are made of: within their reach they do not repeat."""
        return math.floor(1.0 / (self.transfers.step * (2.0 * self.band.reach + 2.0 * SPARE)))

    @cached_property
    def _some(self) -> I64:
        """These frequencies' numbers, after the two next to 0, which tell what there is at 0."""
        return np.concatenate([np.minimum([1, 2], self._rows - 1), np.arange(0, self._rows, self._stride)])

    @cached_property
    def _tables(self) -> tuple[F64, F64]:
        """The transfers (radii, angles, sets · |f|, 2) on half a circle, some more on either side; at some |f| only."""
        transfers = self.transfers
        most, own = transfers.most, transfers.harmonics[:, :, : self._rows]
        spectrum = np.zeros((*own.shape[:3], 2 * self.angles), complex)
        spectrum[..., : most + 1], spectrum[..., -most:] = own[..., most:], own[..., :most]
        around = scipy.fft.ifft(spectrum, axis=-1, norm="forward")
        half = np.concatenate([around[..., -BEFORE:], around[..., : self.angles + AFTER]], axis=-1)
        table = np.moveaxis(half, 3, 1)

        def of(part: C128) -> F64:
            return np.ascontiguousarray(part).view(np.float64).reshape(*part.shape[:2], -1, 2)

        return of(table), of(table[..., self._some])

    def _transfers(self, table: F64, places_um: F64, across_rad: F64) -> C128:
        """Return transfers (places, sets, |f|) of a table at places (n, 2), in directions of the frame."""
        radial = self.transfers.radii.weights(np.hypot(places_um[:, 0], places_um[:, 1]))
        psi = across_rad - np.arctan2(places_um[:, 1], places_um[:, 0])
        out = np.zeros((len(psi), *table.shape[2:]))
        shared(len(psi), functools.partial(look_up, table, radial, psi, out))
        found: C128 = out.view(complex).reshape(len(psi), len(self.channel), -1)
        return found

    def responses(self, pieces: Pieces) -> Responses:
        """Return the responses of some pieces."""
        (along, across), band, rows = self.counts, self.band, self._rows
        nodes, apart, reach = chebyshev(along), chebyshev(across), band.reach
        x, y, tx, ty, length = (part[:, None] for part in pieces.frame.T)
        powers = [np.polynomial.polynomial.polyder(pieces.shape.T, order) for order in range(3)]
        height, slope, bend = (
            np.polynomial.polynomial.polyval(nodes, own) * (2.0 / length) ** order for order, own in enumerate(powers)
        )
        way = 0.5 * length * (1.0 + nodes)
        at = np.stack([x + way * tx - height * ty, y + way * ty + height * tx], axis=-1)
        normal = np.arctan2(ty, tx) + np.arctan(slope) + 0.5 * math.pi  # to the left
        curved = bend / (1.0 + slope**2) ** 1.5
        off = reach * apart[:, None] * np.stack([np.cos(normal), np.sin(normal)], axis=-1)[:, :, None]
        places_um = ((at[:, :, None] + off) * self.pitch_um).reshape(-1, 2)

        frequency: F64 = self.transfers.step * np.arange(float(rows))
        own = frequency[self._some]
        period = 1.0 / (self._stride * self.transfers.step)
        straight = self._transfers(self._tables[1], places_um, np.repeat(normal.ravel(), across))
        straight = straight.reshape(-1, across, *straight.shape[1:])
        straight *= self._passes(own, normal.ravel())[:, None, None]
        spectrum = straight / (2j * math.pi * np.where(own > 0.0, own, 1.0))
        spectrum += self._curved(at.reshape(-1, 2), normal.ravel(), curved.ravel(), frequency)[:, None]
        # At 0 all that a line shows in all: how far the pattern's middle is moved. Its real part is even there.
        first, second, spectrum = spectrum[..., 0], spectrum[..., 1], spectrum[..., 2:]
        spectrum[..., 0] = (4.0 * first - second).real / 3.0
        count = fast_length(math.ceil(band.finer * band.cut * period), real=True)
        lines = scipy.fft.irfft(spectrum / period, n=count, axis=-1, norm="forward")

        step = period / count
        farthest = math.ceil(reach / step) + SPARE
        index = np.arange(-farthest, farthest + 1)
        between = interpolation(apart, np.multiply(index, step / reach, dtype=np.float64))
        lines = np.einsum("pisd,di->psd", lines[..., index % count], between)
        lines = lines.reshape(len(length), along, *lines.shape[1:])
        jump = self.shares[pieces.spectra[:, 0]] - self.shares[pieces.spectra[:, 1]]
        values = np.zeros((len(length), along, int(self.channel.max()) + 1, index.size))
        for k, channel in enumerate(self.channel):
            values[:, :, channel] += jump[:, k, None, None] * lines[:, :, k]
        number = np.arange(along)
        weights = np.asarray((-1.0) ** number * np.sin(np.pi * (number + 0.5) / along), np.float64)
        return Responses(values, nodes, weights, reach, farthest * step, step)

    def _passes(self, frequency: F64, direction_rad: F64) -> C128:
        """Return the band's window, OLPF and photosite (directions, |f|)."""
        x, y = np.cos(direction_rad)[:, None], np.sin(direction_rad)[:, None]
        per_um = frequency / self.pitch_um
        foot: C128 = np.asarray(self.system.footprint_otf(per_um * x, per_um * y), complex)
        passes: C128 = foot * self.band.window(frequency)
        return passes

    def _curved(self, at: F64, normal: F64, curved: F64, frequency: F64) -> C128:
        """Return what being curved adds to spectra (places, sets, some |f|)."""
        some, at_um = self._some, at * self.pitch_um
        own = frequency[some]
        aside = sum(
            self._transfers(self._tables[1], at_um, normal + turn) * self._passes(own, normal + turn)[:, None]
            for turn in (-ANGLE, ANGLE)
        )
        # Slopes over |f| are of neighbours: all there are, and two more beyond 0.
        line = self._transfers(self._tables[0], at_um, normal) * self._passes(frequency, normal)[:, None]
        here = np.pad(line, ((0, 0), (0, 0), (2, 2)))
        for k in range(1, min(3, frequency.size)):
            here[..., 2 - k] = line[..., k].conj()
        rising = 8.0 * (here[..., some + 3] - here[..., some + 1]) - here[..., some + 4] + here[..., some]
        f = np.where(own > 0.0, own, np.inf)
        found: C128 = rising / (12.0 * frequency[1]) / f + (aside - 2.0 * line[..., some]) / (ANGLE * f) ** 2
        found *= (curved / (8.0 * math.pi**2))[:, None, None]
        return found

    def add(self, pieces: Pieces, origin: tuple[float, float], channel: U8, marked: U8, image: F64) -> None:
        """Add what pieces show to photosites that are not marked."""
        parts = [slice(first, first + TOGETHER) for first in range(0, len(pieces.frame), TOGETHER)]
        groups = [
            Pieces(pieces.frame[part], pieces.shape[part], pieces.ends[part], pieces.spectra[part]) for part in parts
        ]
        for some, responses in zip(groups, ahead(self.responses, groups, AHEAD), strict=True):
            shared(len(image), functools.partial(add_pieces, origin, some, responses, channel, marked, image))
