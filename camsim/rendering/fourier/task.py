"""What the Fourier engine is to do: the scene's size, its edges, and numbers of spectra, channels and wavelengths."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.quadrature import gauss_pieces
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.edges import Edges
from camsim.rendering.fourier.density import Density
from camsim.rendering.fourier.joint import NODES_IN_CYCLE
from camsim.rendering.fourier.patterns import samples_of
from camsim.rendering.fourier.prices import PER_JOINT_NODE, PER_JOINT_POINT
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.tile import Tile

PART_OF_MEMORY = 0.3  # that strips may take, and the transfers of a lens at several wavelengths behind pictures
# That those of a wavefront may, beside the photosites' grid or without one: the scene is transformed again for as many
# as do not fit.
OF_TRANSFERS, SINGLY = 0.5, 0.65
TRANSFER_BYTES = 8.7  # of a transfer, for each sample of its pattern
# An image of 1000 outlines was off by half of what the transform was asked for, growing with the root of their number.
OF_A_CROWD = 0.14
SAMPLES_OF_POINT = 8.0 / math.pi  # a pattern's, of its period, for every frequency of half the band (``Tile.points``)
MOST_NODES, OF_NODES = 200, 0.5  # of one Gauss rule on an edge, a longer one is cut; its error, of the transform's
ASKED = 1000  # edges that are asked how many spectra they have to do with
FINEST, COARSEST = 1e-11, 1e-2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Task:
    """What there is to do; lengths in pitches.

    shape     : rows and columns of photosites
    low, high : (2,) corners of the scene's edges, from the first photosite
    footprint : (2,) how far the footprint reaches along x and y;  joint: its transfer is no product of one along each
    edges, density : how many, and where they are;  origin: the first photosite there
    spectra, channels, wavelengths : numbers of them;  spectra_of_edge: that an edge has to do with, on average
    memory_limit_bytes : what the sizes keep below if they can
    """

    kernel: Kernel
    shape: tuple[int, int]
    low: F64
    high: F64
    footprint: F64
    joint: bool
    edges: int
    density: Density
    origin: F64
    spectra: int
    spectra_of_edge: float
    channels: int
    wavelengths: int
    tolerance: float
    memory_limit_bytes: float

    @property
    def weights(self) -> int:
        """Numbers that every frequency is multiplied by."""
        return self.spectra * self.channels * (1 if self.kernel.round else self.wavelengths)

    def of_footprint(self, tile: Tile) -> float:
        """Return seconds that the transfer of OLPF and photosite takes for each frequency."""
        if not self.joint:
            return 0.0
        a, b = float(self.footprint[0]) / tile.periods[0], float(self.footprint[1]) / tile.periods[1]
        across, down = min(1.0, NODES_IN_CYCLE * a), min(1.0, NODES_IN_CYCLE * b)
        return PER_JOINT_POINT + PER_JOINT_NODE * across * down

    def nodes(self, tile: Tile, first: F64) -> tuple[F64, F64]:
        """Return how many edges there are in boxes of tiles like this one at ``first`` (n, 2), and nodes on them."""
        low, high = self.origin + first + tile.low, self.origin + first + tile.high
        count, length = self.density.within(low, high)
        sides = 2.0 * float(np.sum(np.subtract(tile.high, tile.low)))  # what is beyond the box is taken to its sides
        allowed = OF_NODES * spreading_precision(self.tolerance / self.kernel.carries)
        pieces, orders = gauss_pieces(math.pi * tile.cut * length / np.maximum(count, 1.0), allowed, MOST_NODES)
        of_sides, order = gauss_pieces(np.array(math.pi * tile.cut * sides), allowed, MOST_NODES)
        return count, np.asarray(np.maximum(count, 1.0) * pieces * orders + float(of_sides * order), float)

    def fields(self, tile: Tile) -> int:
        """Transfers that are held for a block at a time."""
        if self.kernel.round or not self.kernel.tapered:
            return 0 if self.kernel.round else self.wavelengths
        part = SINGLY if tile.singly else OF_TRANSFERS
        fitting = part * self.memory_limit_bytes / (TRANSFER_BYTES * samples_of(self.kernel, tile))
        return max(1, min(self.wavelengths, int(fitting)))


def spectra_of_edge(edges: Edges, shares: F64) -> float:
    """Return how many spectra an edge has to do with, on average; shares: (sides, spectra) of what lies on a side."""
    some = slice(None, None, 1 + len(edges) // ASKED)
    jumps = shares[edges.left[some]] - shares[edges.right[some]]
    return float(np.count_nonzero(jumps)) / len(jumps)


def spreading_precision(tolerance: float) -> float:
    """Return what a non-uniform transform of edges is asked for, relative."""
    return max(1e-13, OF_A_CROWD * ErrorBudget(tolerance).allowed("spreading"))


def check_tolerance(tolerance: float) -> None:
    """Refuse what the engine cannot promise."""
    if not FINEST <= tolerance <= COARSEST:
        raise InvalidValueError(
            f"{tolerance:g} is outside {FINEST:g} … {COARSEST:g}, what the Fourier engine renders to", key="tolerance"
        )
