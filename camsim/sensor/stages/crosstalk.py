"""Crosstalk between neighbouring photosites."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
import numpy.typing as npt

from camsim.core.annotations import Called
from camsim.core.arrays import F32, F64
from camsim.core.typed import Fraction, Number, Several, refusal, validate
from camsim.sensor.cfa import Cfa
from camsim.sensor.stage import Context, ElectronicStage, Phase


@dataclass(frozen=True, slots=True)
class Crosstalk(ElectronicStage):
    """Mean light and charge that end in a neighbouring photosite.

    kernel : 3 × 3 fractions; kernel[1 + i][1 + j] of a photosite's charge ends in the photosite i rows below and
             j columns to the right of it. They sum to at most 1 (the remainder is lost).

    >>> one = np.zeros((5, 5))
    >>> one[2, 2] = 100.0
    >>> Crosstalk(((0, 0, 0), (0, 0.9, 0.1), (0, 0, 0))).spread(one)[1]
    array([ 0., 90., 10.])
    """

    name: ClassVar = "crosstalk"
    phases: ClassVar = (Phase.NEIGHBOURS,)
    without_noise: ClassVar = True
    margin: ClassVar = 1

    kernel: Annotated[Several[Several[Fraction]], Called("3 rows of 3 fractions")]

    if TYPE_CHECKING:

        def __init__(self, kernel: Several[Several[Number]]) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        if len(self.kernel) != 3 or any(len(row) != 3 for row in self.kernel):
            raise refusal(self, "kernel", "must be 3 rows of 3 fractions")
        total = math.fsum(f for row in self.kernel for f in row)
        if total == 0.0:
            raise refusal(self, "kernel", "adds up to 0; nothing would be seen")
        if total > 1.0 + 1e-9:
            message = f"adds up to {total:.6g}; a photosite cannot give away more than it gets, at most 1"
            raise refusal(self, "kernel", message)

    def apply(self, electrons: F64, context: Context) -> F64:
        """Convolve the charge with the kernel."""
        return self.spread(electrons)

    def spread(self, electrons: F64) -> F64:
        """Return mean charge (rows, cols) after crosstalk, from the window padded by one photosite on every side."""
        rows, cols = electrons.shape[0] - 2, electrons.shape[1] - 2
        mixed = np.zeros((rows, cols))
        for i, row in enumerate(self.kernel):
            for j, fraction in enumerate(row):
                if fraction:
                    # Charge from above left was sent to below right.
                    mixed += fraction * electrons[2 - i : 2 - i + rows, 2 - j : 2 - j + cols]
        return mixed

    def mixing(self, cfa: Cfa) -> F64:
        """Return (channels, channels): share that a photosite of a channel receives from every channel, in flat light.

        Averaged over all photosites of the channel: an asymmetric kernel differs between greens of two rows.

        >>> Crosstalk(((0, 0.01, 0), (0.01, 0.96, 0.01), (0, 0.01, 0))).mixing(Cfa.bayer("RGGB")).round(2).tolist()
        [[0.96, 0.04, 0.0], [0.02, 0.96, 0.02], [0.0, 0.04, 0.96]]
        """
        mixing: F64 = np.einsum("ij,kijc->kc", np.array(self.kernel), _of_channels(cfa))
        return mixing

    def left_of_pattern(self, cfa: Cfa, each_e: F64) -> F64:
        """Return (channels,) the factor by which crosstalk reduces the spread of gains (PRNU) in flat light.

        A photosite holds parts of nine: their means add, and so do their variances. Relative to the mean.

        each_e : (channels,) mean charge of each channel before crosstalk, in any unit

        >>> Crosstalk(((0, 0, 0), (0, 0.8, 0.2), (0, 0, 0))).left_of_pattern(Cfa.named("mono"), np.ones(1)).round(4)
        array([0.8246])
        """
        squares = np.einsum("ij,kijc,c->k", np.array(self.kernel) ** 2, _of_channels(cfa), each_e**2)
        left: F64 = np.sqrt(squares) / (self.mixing(cfa) @ each_e)
        return left

    def seen_by(self, channel: int, planes: F64 | F32, cfa: Cfa) -> F64:
        """Return (rows, cols) mean charge that a photosite of ``channel`` would collect at every position.

        Its neighbours are those of such a photosite in the array, averaged over its positions in a period.

        planes : (channels, rows + 2, cols + 2) mean charge that each channel's filter lets through
        """
        rows, cols = planes.shape[1] - 2, planes.shape[2] - 2
        seen = np.zeros((rows, cols))
        for (i, j, sender), share in np.ndenumerate(senders(cfa, cfa.channel_index(*cfa.period) == channel)):
            if share * self.kernel[i][j]:
                seen += share * self.kernel[i][j] * planes[sender, 2 - i : 2 - i + rows, 2 - j : 2 - j + cols]
        return seen


def senders(cfa: Cfa, one: npt.NDArray[np.bool_]) -> F64:
    """Return (3, 3, channels): the share of each channel among the photosites that send to some through kernel[i][j].

    one : (rows, cols) mask of these photosites in a period
    """
    index, count = cfa.channel_index(*cfa.period), len(cfa.channels)
    shares = np.empty((3, 3, count))
    for i, j in np.ndindex(3, 3):
        sent = np.roll(index, (i - 1, j - 1), axis=(0, 1))[one]
        shares[i, j] = np.bincount(sent, minlength=count) / sent.size
    return shares


def _of_channels(cfa: Cfa) -> F64:
    """Return (channels, 3, 3, channels): ``senders`` for the photosites of each channel."""
    index = cfa.channel_index(*cfa.period)
    return np.stack([senders(cfa, index == channel) for channel in range(len(cfa.channels))])
