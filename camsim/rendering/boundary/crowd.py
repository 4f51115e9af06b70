"""Many short edges: cells with a few equivalent sources, so that far tiles need not sum over every edge.

The field of a dipole (dipole.py) is smooth over a cell that is far enough away, so each piece of an edge can be spread
over the cell's q × q Chebyshev nodes y_m with the weights of interpolation: node m has strength Σ_edges ∫ ℓ_m(z) dz.
The strengths of larger cells follow from the nodes of smaller ones.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, I64
from camsim.core.kernels import kernel
from camsim.numerics.quadrature import chebyshev, gauss_legendre
from camsim.rendering.boundary.dipole import dipole_at_points
from camsim.rendering.boundary.far import Moments
from camsim.rendering.edges import Edges

FEWEST = 32  # edges of a cell: fewer are faster one by one than by its nodes
FITS = 0.25  # an edge longer than this part of a cell belongs to the next larger cell, so that it protrudes little


class Cells(NamedTuple):
    """Cells of edges, of which the first contains all; none for few edges. Lengths in pitches."""

    x: F64  # centre and half-widths of the bounding box of a cell's edges
    y: F64
    half_x: F64
    half_y: F64
    first_edge: I64  # (cells + 1,) edges that belong to no child
    first_child: I64  # (cells + 1,)
    nodes: F64  # (q,) Chebyshev nodes on −1 … 1
    strength: F64  # (cells, channels, 4, 2, q, q): by moment of the far form, real and imaginary part; [y, x]


def gather(edges: Edges, pair: I64, far: F64, nodes: int) -> tuple[I64, Cells]:
    """Sort edges into cells and compute the cells' strengths.

    pair    : (n,) index into far (pairs, channels, 4), the moments of the far form
    nodes   : along a cell's side
    returns : an order (n,) in which the edges of each cell are contiguous, and the cells in that order
    """
    start, end, count = edges.start, edges.end, len(edges)
    middle, length = 0.5 * (start + end), edges.length
    low, high = np.minimum(start, end), np.maximum(start, end)
    centre = 0.5 * (middle.min(axis=0) + middle.max(axis=0))
    queue = [(np.arange(count), centre, float(np.ptp(middle, axis=0).max()))] if count >= FEWEST else []
    order, boxes, first_edge, first_child = [np.arange(0 if queue else count)], [], [0], [1]
    for members, centre, size in queue:
        one = np.ones(members.size, bool)
        quarter = (middle[members] >= centre) @ np.array([1, 2])
        quarter[length[members] > 0.5 * FITS * size] = -1
        for k in range(4):
            inside = quarter == k
            if members.size > 2 * FEWEST and np.count_nonzero(inside) >= FEWEST:
                one &= ~inside
                shift = 0.25 * size * np.array([2 * (k & 1) - 1, (k & 2) - 1])
                queue.append((members[inside], centre + shift, 0.5 * size))
        order.append(members[one])
        boxes.append(np.concatenate([low[members].min(axis=0), high[members].max(axis=0)]))
        first_edge.append(first_edge[-1] + order[-1].size)
        first_child.append(len(queue))
    sorted_edges = np.concatenate(order)
    x0, y0, x1, y1 = np.array(boxes).reshape(-1, 4).T
    cells = Cells(
        x=0.5 * (x0 + x1),
        y=0.5 * (y0 + y1),
        half_x=0.5 * (x1 - x0),
        half_y=0.5 * (y1 - y0),
        first_edge=np.array(first_edge),
        first_child=np.array(first_child),
        nodes=chebyshev(nodes),
        strength=np.zeros((len(boxes), far.shape[1], 4, 2, nodes, nodes)),
    )
    if boxes:
        # ℓ·ℓ has degree 2(q − 1) along an edge, but the field that it interpolates needs only q over a whole cell.
        rule = gauss_legendre(nodes // 2 + 1)
        _spread(start[sorted_edges], end[sorted_edges], pair[sorted_edges], far, cells, *rule)
    return sorted_edges, cells


@kernel()
def _basis(nodes: F64, u: float, out: F64) -> None:
    """Write the Lagrange polynomials of Chebyshev nodes of the first kind at u (barycentric formula)."""
    total = 0.0
    for k in range(nodes.size):
        gap = u - nodes[k]
        if abs(gap) < 1e-14:
            out[:] = 0.0
            out[k] = 1.0
            return
        out[k] = (1.0 - 2.0 * (k % 2)) * np.sqrt(1.0 - nodes[k] * nodes[k]) / gap
        total += out[k]
    out /= total


@kernel(allocates=True)
def _spread(start: F64, end: F64, pair: I64, far: F64, cells: Cells, gauss_x: F64, gauss_w: F64) -> None:
    """Compute the cells' strengths, the smallest cells first."""
    nodes, strength = cells.nodes, cells.strength
    q = nodes.size
    along_x, along_y = np.empty((q, q)), np.empty((q, q))
    part, half_way = np.empty((q, q)), np.empty((q, q))
    for c in range(cells.x.size - 1, -1, -1):
        # In a box of zero width all nodes coincide.
        to_x = 1.0 / cells.half_x[c] if cells.half_x[c] > 0.0 else 0.0
        to_y = 1.0 / cells.half_y[c] if cells.half_y[c] > 0.0 else 0.0
        for e in range(cells.first_edge[c], cells.first_edge[c + 1]):
            dx, dy = end[e, 0] - start[e, 0], end[e, 1] - start[e, 1]
            part[:] = 0.0
            for g in range(gauss_x.size):
                t = 0.5 * (1.0 + gauss_x[g])
                _basis(nodes, (start[e, 0] + t * dx - cells.x[c]) * to_x, along_x[0])
                _basis(nodes, (start[e, 1] + t * dy - cells.y[c]) * to_y, along_y[0])
                for i in range(q):
                    for j in range(q):
                        part[i, j] += 0.5 * gauss_w[g] * along_y[0, i] * along_x[0, j]
            for k in range(far.shape[1]):
                for m in range(4):
                    wx, wy = far[pair[e], k, m] * dx, far[pair[e], k, m] * dy
                    for i in range(q):
                        for j in range(q):
                            strength[c, k, m, 0, i, j] += wx * part[i, j]
                            strength[c, k, m, 1, i, j] += wy * part[i, j]
        for child in range(cells.first_child[c], cells.first_child[c + 1]):
            for a in range(q):
                _basis(nodes, (cells.x[child] + cells.half_x[child] * nodes[a] - cells.x[c]) * to_x, along_x[a])
                _basis(nodes, (cells.y[child] + cells.half_y[child] * nodes[a] - cells.y[c]) * to_y, along_y[a])
            for k in range(far.shape[1]):
                for m in range(4):
                    for axis in range(2):
                        half_way[:] = 0.0
                        for a in range(q):
                            for b in range(q):
                                for j in range(q):
                                    half_way[a, j] += strength[child, k, m, axis, a, b] * along_x[b, j]
                        for a in range(q):
                            for i in range(q):
                                for j in range(q):
                                    strength[c, k, m, axis, i, j] += along_y[a, i] * half_way[a, j]


@kernel(error_model="numpy", fastmath={"contract"})
def cell_at_points(
    c: int, x0: float, y0: float, x: F64, y: F64, m: Moments, cells: Cells, sends: F64, sums: F64
) -> None:
    """Add cell ``c`` to ``sums`` (channels, points) at points (x0 + x, y0 + y), all of them far away.

    m : the footprint's moments in the photosite's frame;  sends: (8, points) memory
    """
    q = cells.nodes.size
    for i in range(q):
        dy = cells.y[c] + cells.half_y[c] * cells.nodes[i] - y0
        for j in range(q):
            dipole_at_points(cells.x[c] + cells.half_x[c] * cells.nodes[j] - x0, dy, x, y, m, sends)
            for k in range(sums.shape[0]):
                s0x, s0y = cells.strength[c, k, 0, 0, i, j], cells.strength[c, k, 0, 1, i, j]
                s1x, s1y = cells.strength[c, k, 1, 0, i, j], cells.strength[c, k, 1, 1, i, j]
                s3x, s3y = cells.strength[c, k, 2, 0, i, j], cells.strength[c, k, 2, 1, i, j]
                s5x, s5y = cells.strength[c, k, 3, 0, i, j], cells.strength[c, k, 3, 1, i, j]
                for p in range(x.size):
                    sums[k, p] += (
                        (s0x * sends[0, p] + s0y * sends[1, p] + s1x * sends[2, p] + s1y * sends[3, p])
                        + (s3x * sends[4, p] + s3y * sends[5, p] + s5x * sends[6, p] + s5y * sends[7, p])
                    )  # fmt: skip
