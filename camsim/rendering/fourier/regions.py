"""The regions of a scene, ready to be transformed block by block: edge by edge, or from nodes along the edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import ONE_AT_A_TIME
from camsim.quadrature import gauss_legendre
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.edges import Edges
from camsim.rendering.fourier.blocks import Block, Tile
from camsim.rendering.fourier.kernels import Corners, edge_transforms
from camsim.rendering.fourier.plan import FEWEST_ON_EDGE, NODES_PER_RADIAN, Sizes

# An image of 1000 outlines was off by half of what the transform was asked for, growing with the root of their number.
OF_A_CROWD = 0.2
MOST_NODES = 200  # of one Gauss rule; a longer edge is cut


def clamped(edges: Edges, low: tuple[float, float], high: tuple[float, float]) -> Edges:
    """Move every point into a box, edges cut where they cross its sides.

    A closed outline clamped axis by axis is the outline of what lies in the box: pieces along its sides cancel or
    close it.

    >>> a = np.array([[-1.0, 0.0], [3.0, 0.0], [0.0, 2.0]])  # a triangle that sticks out to the right and the left
    >>> b = np.roll(a, -1, axis=0)
    >>> inside = clamped(Edges(start=a, end=b, left=np.array([1, 2, 3]), right=np.zeros(3, int)), (0, 0), (1, 2))
    >>> (x0, y0), (x1, y1) = inside.start.T, inside.end.T
    >>> float(0.5 * np.sum(x0 * y1 - x1 * y0))  # the trapezium within
    1.6666666666666665
    >>> sorted(inside.left.tolist())  # the second runs down to the right side and along it
    [1, 2, 2, 3]
    """
    start, end, kept = edges.start, edges.end, np.arange(len(edges))
    for axis in (0, 1):
        for bound, sign in ((low[axis], -1.0), (high[axis], 1.0)):
            a, b = sign * (start[:, axis] - bound), sign * (end[:, axis] - bound)
            crosses = (a > 0.0) != (b > 0.0)
            if crosses.any():
                t = (a / np.where(crosses, a - b, 1.0))[crosses, None]
                middle = start[crosses] + t * (end[crosses] - start[crosses])
                middle[:, axis] = bound
                tail = end[crosses]
                end = end.copy()
                end[crosses] = middle
                start, end = np.concatenate([start, middle]), np.concatenate([end, tail])
                kept = np.concatenate([kept, kept[crosses]])
        start, end = start.copy(), end.copy()
        start[:, axis] = np.clip(start[:, axis], low[axis], high[axis])
        end[:, axis] = np.clip(end[:, axis], low[axis], high[axis])
    whole = (start != end).any(axis=1)
    of = kept[whole]
    return Edges(start=start[whole], end=end[whole], left=edges.left[of], right=edges.right[of])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Regions:
    """The regions of every spectrum on one tile.

    areas       : (spectra,) square pitches
    tile        : whose frequencies they are transformed at
    corners     : edges by the corners that they share
    along       : for each spectrum nodes (m, 2) on its edges and strengths (2, m); None: edge by edge
    precision   : of the non-uniform transform, relative
    """

    areas: F64
    tile: Tile
    corners: Corners
    along: tuple[tuple[F64, F64], ...] | None
    precision: float

    @classmethod
    def of(cls, edges: Edges, tile: Tile, plan: Sizes, spectra: int, tolerance: float) -> Regions:
        """Prepare the edges (pitches from the tile's first photosite) as the plan has it; the background is none."""
        start, end, left, right = edges.start, edges.end, edges.left - 1, edges.right - 1
        twice = start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1]
        points, index = np.unique(edges.points, axis=0, return_inverse=True)
        index = index.ravel()
        return cls(
            areas=np.array([0.5 * (twice[left == s].sum() - twice[right == s].sum()) for s in range(spectra)]),
            tile=tile,
            corners=Corners(np.ascontiguousarray(points), index[: len(edges)], index[len(edges) :], left, right),
            along=_strengths(start, end, left, right, spectra, tile.cut) if plan.spread else None,
            precision=max(1e-13, OF_A_CROWD * ErrorBudget(tolerance).allowed("spreading")),
        )

    def transforms(self, block: Block) -> F64:
        """Return 4π²|k|² times the transform of each spectrum's regions: (spectra, count_j, 2, count_i)."""
        tile = self.tile
        if self.along is None:
            with ONE_AT_A_TIME:
                transforms: F64 = edge_transforms(block.place(tile), self.corners, self.areas.size)
            return transforms
        out = np.zeros((self.areas.size, block.count_j, 2, block.count_i))
        for s, (nodes, strengths) in enumerate(self.along):
            if len(nodes):
                out[s] = _spread(block, tile.periods, nodes, strengths, self.precision)
        return out


def _strengths(start: F64, end: F64, left: I64, right: I64, spectra: int, cut: float) -> tuple[tuple[F64, F64], ...]:
    nodes, weights, edge = gauss_nodes(start, end, cut)
    strengths = weights * (end - start)[edge].T
    regions = []
    for s in range(spectra):
        sign = np.where(left[edge] == s, 1.0, 0.0) - np.where(right[edge] == s, 1.0, 0.0)
        mine = sign != 0.0
        regions.append((nodes[mine], strengths[:, mine] * sign[mine]))
    return tuple(regions)


def gauss_nodes(start: F64, end: F64, cut: float) -> tuple[F64, F64, I64]:
    """Return nodes (m, 2) on edges, their weights (m,) as shares of the edge, and the edge (m,) of each.

    As many as the phase along the edge asks for at the highest frequency; long edges are cut into pieces first.
    """
    length = np.hypot(*(end - start).T)
    per_length = NODES_PER_RADIAN * 2.0 * np.pi * cut
    pieces = np.maximum(np.ceil(length * per_length / (MOST_NODES - FEWEST_ON_EDGE)).astype(np.int64), 1)
    edge = np.repeat(np.arange(len(start)), pieces)
    place = np.arange(edge.size) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    orders = np.ceil(per_length * length / pieces).astype(np.int64) + FEWEST_ON_EDGE
    nodes, weights, owners = [], [], []
    for order in np.unique(orders[edge]):
        x, w = gauss_legendre(int(order))
        which = np.flatnonzero(orders[edge] == order)
        owner = edge[which]
        t = (place[which, None] + 0.5 * (1.0 + x)) / pieces[owner, None]
        nodes.append((start[owner, None] + t[..., None] * (end - start)[owner, None]).reshape(-1, 2))
        weights.append((0.5 * w / pieces[owner, None]).ravel())
        owners.append(np.repeat(owner, order))
    return np.concatenate(nodes), np.concatenate(weights), np.concatenate(owners)


def _spread(block: Block, periods: tuple[int, int], nodes: F64, strengths: F64, precision: float) -> F64:
    """Return 4π²|k|²·F = 2πi Σ (kx·ey − ky·ex)·exp(−2πi k·y) over the nodes: (count_j, 2, count_i).

    strengths : (2, m) weight times the edge's x and y part, times −1 where the region lies to the right
    """
    import finufft

    # finufft's frequencies run about 0: the block's middle is moved there.
    middle_i, middle_j = block.first_i + block.count_i // 2, block.first_j + block.count_j // 2
    turn = nodes[:, 0] * middle_i / periods[0] + nodes[:, 1] * middle_j / periods[1]
    x, y = (2.0 * np.pi * ((nodes[:, axis] / periods[axis] + 0.5) % 1.0 - 0.5) for axis in (0, 1))
    shifted = np.ascontiguousarray(strengths * np.exp(-2j * np.pi * (turn % 1.0)))
    parts = finufft.nufft2d1(y, x, shifted, n_modes=(block.count_j, block.count_i), eps=precision, isign=-1)
    kx = (block.first_i + np.arange(block.count_i)) / periods[0]
    ky = (block.first_j + np.arange(block.count_j))[:, None] / periods[1]
    whole = 2j * np.pi * (kx * parts[1] - ky * parts[0])
    return np.stack([whole.real, whole.imag], axis=1)
