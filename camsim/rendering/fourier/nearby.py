"""A scene's edges about one window after the other, clamped to a box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64
from camsim.kept import cached_property
from camsim.rendering.edges import Edges
from camsim.rendering.fourier.clamped import clamped
from camsim.rendering.fourier.plan import BLOCK_POINTS, STRIP_POINTS, Sizes
from camsim.rendering.fourier.regions import Regions
from camsim.rendering.fourier.tile import Tile
from camsim.rendering.prune import outline_boxes

MANY = 120  # edges in a window: from here on non-uniform transforms of them cost less


@dataclass(frozen=True, kw_only=True, eq=False)
class Nearby:
    """Edges, pitches."""

    edges: Edges

    @cached_property
    def outlines(self) -> tuple[I64, F64, F64]:
        """The outline that each edge belongs to, and their lowest and highest x and y (n, 2)."""
        return outline_boxes(self.edges)

    def seen(self, tile: Tile, first: tuple[float, float]) -> Edges:
        """Return the edges about a window whose first photosite is at ``first``, clamped.

        An outline beyond one side of its box would be flat: nothing.
        """
        outline, low, high = self.outlines
        inside = (low <= np.add(tile.high, first)) & (high >= np.add(tile.low, first))
        meets = inside[:, 0] & inside[:, 1]
        return clamped(self.edges.some(meets[outline]).seen_from(first), tile.low, tile.high)


def regions_of(seen: Edges, tile: Tile, tolerance: float) -> tuple[I64, Regions]:
    """Return the spectra (n,) of regions in a window besides the background's, and those regions to be transformed."""
    spectra = np.setdiff1d(np.concatenate([seen.left, seen.right]), [0])
    shares = np.zeros((1 + int(spectra.max(initial=0)), spectra.size))
    shares[spectra, np.arange(spectra.size)] = 1.0
    sizes = Sizes(
        tiles=(tile,),
        spread=len(seen) > MANY,
        channels=1,
        fields=0,
        block_points=BLOCK_POINTS,
        strip_points=STRIP_POINTS,
        pattern_rows=1,
        seconds=0.0,
        memory_bytes=0.0,
    )
    return spectra, Regions.of(seen, tile, sizes, shares, tolerance)
