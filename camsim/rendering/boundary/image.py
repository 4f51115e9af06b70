"""The boundary engine's set-up: tables, edges and settings for its kernels, and the loop over bands."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator

import numpy as np

from camsim.core.arrays import F64, I64, kinds_of
from camsim.core.tiled import Channels
from camsim.numerics.quadrature import chebyshev, gauss_rules, interpolation
from camsim.optics.pattern import Pattern
from camsim.rendering.boundary.far import far_moments
from camsim.rendering.boundary.records import Numbers, TabledEdges, Tables
from camsim.rendering.boundary.settings import LONGEST_PIECE, PANEL_BLURS, Settings
from camsim.rendering.boundary.tables import edge_responses, field_tables
from camsim.rendering.boundary.tiles import render_edges
from camsim.rendering.edges import Edges, shares_within
from camsim.rendering.footprint import Footprint
from camsim.rendering.grid import Grid
from camsim.rendering.job import Job, Nodes
from camsim.rendering.spectral import multiples

BAND_PHOTOSITES = 2_000_000  # 16 MB: progress is told after each
MOST_IN_BAND = 1 << 22  # photosites: 34 MB
MOST_TILES = 100  # of the largest size: enough for all threads, few enough to share far edges among many photosites


def largest_tile(settings: Settings, shape: tuple[int, int]) -> int:
    """Return the side of the largest tiles of a grid of ``shape``, photosites.

    A band is a row of tiles; the limit on its size bounds the memory of a large frame.
    """
    root = settings.leaf
    while -(-shape[0] // root) * -(-shape[1] // root) > MOST_TILES and 2 * root * shape[1] <= MOST_IN_BAND:
        root *= 2
    return root


def numbers(settings: Settings, footprint: Footprint, shape: tuple[int, int]) -> Numbers:
    """Return the settings in the form that the kernels use, for a grid of ``shape``."""
    root = largest_tile(settings, shape)
    nodes, to_children, to_photosites = _interpolated(settings.tile_nodes, root, settings.leaf)
    gauss_x, gauss_w, gauss_count = gauss_rules(settings.piece_nodes)
    return Numbers(
        near=settings.near,
        reach=settings.reach,
        field_step=settings.field_step,
        response_step=settings.response_step,
        piece=LONGEST_PIECE / PANEL_BLURS * settings.panel,
        gauss_x=gauss_x,
        gauss_w=gauss_w,
        gauss_count=gauss_count,
        sigma2=footprint.sigma2,
        m22=footprint.m22,
        apart=footprint.grid[2],
        separation=settings.separation,
        nodes=nodes,
        to_children=to_children,
        to_photosites=to_photosites,
        root=root,
        leaf=settings.leaf,
    )


@functools.lru_cache(maxsize=16)
def _interpolated(count: int, root: int, leaf: int) -> tuple[F64, F64, F64]:
    """Return a tile's nodes, and the interpolation matrices to the nodes of its quarters and to photosites; read-only.

    If tiles are never quartered and have no more photosites than nodes, the photosites are the nodes.
    """
    if root == leaf <= count:
        nodes = (2.0 * np.arange(leaf) + 1.0) / leaf - 1.0
        to_children, to_photosites = np.empty((2, leaf, leaf)), np.eye(leaf)[None]
    else:
        nodes = chebyshev(count)
        to_children = np.stack([interpolation(nodes, 0.5 * nodes - 0.5), interpolation(nodes, 0.5 * nodes + 0.5)])
        to_photosites = np.zeros((int(math.log2(root // leaf)) + 1, count, root))
        for level, one in enumerate(to_photosites):
            size = root >> level
            one[:, :size] = interpolation(nodes, (2.0 * np.arange(size) + 1.0) / size - 1.0).T
    for array in (nodes, to_children, to_photosites):
        array.flags.writeable = False
    return nodes, to_children, to_photosites


def boundary_bands(
    job: Job,
    *,
    pattern: Pattern,
    footprint: Footprint,
    nodes: Nodes,
    settings: Settings,
    lines: tuple[I64, F64],
    channel: Channels,
) -> Iterator[F64]:
    """Render a job with a supported lens and footprint; yield the image band by band, from the top.

    lines     : index of each edge's response, and the responses' normals (``directions``)
    channel   : (rows, cols) channel of each photosite
    """
    weights = nodes.weights
    x, y = job.grid.first_centre
    blur = job.blur_at(nodes.wavelength_nm)
    pairs, channels, count = weights.shape
    flat = weights.reshape(-1, count)
    far = far_moments(pattern, blur, flat).reshape(pairs, channels, 4)
    which, times = multiples(weights.reshape(pairs, -1))
    tabled, alike = kinds_of(which)
    different = weights[tabled].reshape(-1, count)
    response, normals = lines
    edges = _tabled(job.edges, job.pair, (alike, times), response, footprint, settings.brief)
    field = field_tables(
        pattern,
        blur,
        different,
        footprint,
        radius=settings.near,
        step=settings.field_step,
    )
    if len(normals):
        responses = edge_responses(
            pattern,
            blur,
            different,
            normals,
            footprint,
            distance=settings.reach,
            step=settings.response_step,
        )
    else:
        responses = np.empty((0, len(different), 1, 6))
    tables = Tables(
        far=far,
        field=field.reshape(len(tabled), channels, *field.shape[1:]),
        response=responses.reshape(len(normals), len(tabled), channels, *responses.shape[2:]),
        base=job.base,
    )
    rows, cols = channel.shape
    n = numbers(settings, footprint, (rows, cols))
    # Bands of whole tiles: progress can be reported, and the result depends to the last bit on the plan alone.
    band = n.root * max(1, BAND_PHOTOSITES // (n.root * cols))
    for row in range(0, rows, band):
        here = np.ascontiguousarray(channel[row : row + band])
        yield render_edges(x, y + row, here, edges, tables, n)


def inside_length(edges: Edges, grid: Grid, margin: float) -> F64:
    """Return the length of each edge within the grid, widened by ``margin``, pitches."""
    low = np.array(grid.first_centre) - margin
    high = low + np.array([grid.cols - 1 + 2 * margin, grid.rows - 1 + 2 * margin])
    enters, leaves = shares_within(edges.start, edges.end, low, high)
    length: F64 = np.maximum(leaves - enters, 0.0) * edges.length
    return length


def _tabled(
    edges: Edges,
    pair: I64,
    multiple: tuple[I64, F64],
    response: I64,
    footprint: Footprint,
    brief: float,
) -> TabledEdges:
    """Return edges in the form that the kernels use.

    multiple : (pairs,) the tabulated pair to which each is proportional, and the factor
    response : (n,) index of each edge's response
    brief    : distance from which an edge is short, over its length
    """
    tx, ty = np.ascontiguousarray(edges.along.T)
    turn = tx + 1j * ty
    return TabledEdges(
        x=np.ascontiguousarray(edges.start[:, 0]),
        y=np.ascontiguousarray(edges.start[:, 1]),
        tx=tx,
        ty=ty,
        length=edges.length,
        brief=edges.length * (brief if footprint.plain else math.inf),
        # In a frame whose second axis is −n (far.py: z = s + ih), ζ becomes conj(ζ)·e^{iφ}.
        m2=np.conj(footprint.m2) * turn**2,
        m31=np.conj(footprint.m31) * turn**2,
        m4=np.conj(footprint.m4) * turn**4,
        m6=np.conj(footprint.m6) * turn**6,
        pair=pair,
        alike=multiple[0][pair],
        times=multiple[1][pair],
        response=response,
    )


def directions(edges: Edges, grid: Grid, near: float, reach: float, footprint: Footprint) -> tuple[I64, F64]:
    """Return each edge's response (−1: none) and the distinct normals (n, 2), up to the footprint's symmetries.

    An edge no shorter than ``near`` has a response. If no photosite comes within ``reach`` of it, the response is
    never looked up, and its index is arbitrary.

    A response is even in the normal; a mirrored footprint has the same one for the mirrored normal, a square one also
    with x and y exchanged.
    """
    long = edges.length >= near
    looked_up = long & (inside_length(edges, grid, reach) > 0.0)
    tx, ty = edges.along[looked_up].T
    one = np.round(footprint.folded(np.array([-ty, tx]).T), 13)
    found, index = kinds_of(one[:, 0] + 1j * one[:, 1])
    distinct = found.view(np.float64).reshape(-1, 2)
    response = np.where(long, 0, -1)
    response[looked_up] = index
    return response, distinct / np.hypot(distinct[:, :1], distinct[:, 1:])
