"""The boundary engine's set-up: tables, edges and settings for its kernels, and the loop over bands."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator

import numpy as np

from camsim.core.arrays import C128, F64, I64, kinds_of
from camsim.core.tiled import Channels
from camsim.numerics.quadrature import chebyshev, gauss_order, gauss_rules, interpolation
from camsim.optics.pattern import Pattern
from camsim.rendering.boundary.crowd import gather
from camsim.rendering.boundary.far import far_moments
from camsim.rendering.boundary.records import Numbers, TabledEdges, Tables
from camsim.rendering.boundary.ring_table import ring_table
from camsim.rendering.boundary.rings import oscillation_lengths, piece_phases, ring_amplitudes
from camsim.rendering.boundary.settings import LONGEST_PIECE, PANEL_BLURS, Settings
from camsim.rendering.boundary.tables import edge_responses, field_tables
from camsim.rendering.boundary.tiles import render_edges
from camsim.rendering.boundary.zones import Zones, add_rings_in_zones
from camsim.rendering.edges import Edges, shares_within
from camsim.rendering.focus import ZONE
from camsim.rendering.footprint import Footprint, footprint_rule
from camsim.rendering.grid import Grid
from camsim.rendering.job import Job, Nodes
from camsim.rendering.spectral import multiples

NO_RINGS = np.empty((0, 2, 1, 1), np.complex128)
BAND_PHOTOSITES = 2_000_000
MOST_IN_BAND = 1 << 22  # photosites: 34 MB
MOST_TILES = 100  # of the largest size: enough for all threads, few enough to share far edges among many photosites
RINGS_TO = 1e-8  # error of the quadrature over the footprint for ringing, relative to a point
CELL_NODES = 1  # additional nodes along a cell, since all of it contributes; few photosites lie at a tile's rim


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
        dipoles=settings.dipoles,
        near=settings.near,
        negligible_end=settings.negligible_end,
        reach=settings.reach,
        negligible_line=settings.negligible_line,
        field_step=settings.field_step,
        response_step=settings.response_step,
        piece=LONGEST_PIECE / PANEL_BLURS * settings.panel,
        gauss_x=gauss_x,
        gauss_w=gauss_w,
        gauss_count=gauss_count,
        ring_phases=piece_phases(settings.tolerance),
        sigma2=footprint.sigma2,
        m22=footprint.m22,
        harmonic=np.array([footprint.m2, footprint.m31, footprint.m4, footprint.m6]),
        turns=turns(footprint),
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
    places: F64,
    nodes: Nodes,
    settings: Settings,
    in_foci: tuple[I64, I64],
    lines: tuple[I64, F64],
    ring_rows: int,
    channel: Channels,
) -> Iterator[F64]:
    """Render a job with a supported lens and footprint; yield the image band by band, from the top.

    footprint : the footprint, or a part of which copies at ``places`` (n, 2) from a photosite's centre make it up
    in_foci   : the edges of each of the settings' foci (``focus.touching``)
    lines     : index of each edge's response, and the responses' normals (``directions``)
    ring_rows : rows of the table of ringing along short edges, 0 for none
    channel   : (rows, cols) channel of each photosite
    """
    weights = nodes.weights
    origin = job.grid.first_centre
    blur = job.blur_at(nodes.wavelength_nm)
    pairs, channels, count = weights.shape
    flat = weights.reshape(-1, count)
    far = far_moments(pattern, blur, flat).reshape(pairs, channels, 4)
    order, cells = gather(job.edges, job.pair, far, settings.tile_nodes + CELL_NODES)
    some = job.edges.some(order)
    which, times = multiples(weights.reshape(pairs, -1))
    tabled, alike = kinds_of(which)
    different = weights[tabled].reshape(-1, count)
    response, normals = lines
    edges = _tabled(some, job.pair[order], (alike, times), response[order], footprint)
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
    zones = _zones(settings, in_foci, order)
    ringed = settings.negligible_end > settings.near
    rings = _rings(pattern, blur, footprint, settings.near) if ringed or len(zones.circle) else NO_RINGS
    oscillations = oscillation_lengths(pattern.oscillations, blur)
    tables = Tables(
        far=far,
        field=field.reshape(len(tabled), channels, *field.shape[1:]),
        response=responses.reshape(len(normals), len(tabled), channels, *responses.shape[2:]),
        base=job.base,
        rings=rings,
        ring_weights=np.ascontiguousarray(weights),  # so that kernels are compiled for one layout
        oscillations=oscillations,
        short_rings=ring_table(
            rings, oscillations, weights[tabled], nearest=settings.near, rows=ring_rows, tolerance=settings.tolerance
        ),
    )
    rows, cols = channel.shape
    n = numbers(settings, footprint, (rows, cols))
    if len(zones.circle):
        long, short = _farther(n, settings)
        far_rings = tables._replace(
            rings=_rings(pattern, blur, footprint, settings.negligible_end) if ringed else rings
        )
    # Bands of whole tiles: progress can be reported, and the result depends to the last bit on the plan alone.
    band = n.root * max(1, BAND_PHOTOSITES // (n.root * cols))
    for row in range(0, rows, band):
        here = np.ascontiguousarray(channel[row : row + band])
        whole: F64 | None = None
        for x, y in (origin + places).tolist():
            part = render_edges(x, y + row, here, edges, cells, tables, n)
            if len(zones.circle):
                add_rings_in_zones(x, y + row, zones, here, part, edges, far_rings, long, short)
            if len(places) > 1:
                part /= len(places)
            whole = part if whole is None else whole + part
        assert whole is not None
        yield whole
        del part, whole  # frees it before the next band is computed


def _rings(pattern: Pattern, blur: F64, footprint: Footprint, nearest: float) -> C128:
    """Return the amplitudes of ringing, valid from ``nearest`` on."""
    order = rings_order(footprint, float(blur.min()))
    nodes, weights = footprint_rule(footprint.width, footprint.height, footprint.spots, order)
    return ring_amplitudes(pattern.oscillations, blur, nodes, weights, turns=turns(footprint), nearest=nearest)


def rings_order(footprint: Footprint, shortest: float) -> int:
    """Return the order of the quadrature over the footprint for amplitudes; shortest: the shortest λN, pitches."""
    return gauss_order(math.pi * footprint.side / shortest, RINGS_TO)


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
) -> TabledEdges:
    """Return edges in the form that the kernels use.

    multiple : (pairs,) the tabulated pair to which each is proportional, and the factor
    response : (n,) index of each edge's response
    """
    tx, ty = np.ascontiguousarray(edges.along.T)
    turn = tx + 1j * ty
    return TabledEdges(
        x=np.ascontiguousarray(edges.start[:, 0]),
        y=np.ascontiguousarray(edges.start[:, 1]),
        tx=tx,
        ty=ty,
        length=edges.length,
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


def _zones(settings: Settings, in_foci: tuple[I64, I64], order: I64) -> Zones:
    """Return the zones about foci in which ringing is added; ``order``: the order in which edges are rendered."""
    found, (first, picked) = settings.foci, in_foci
    place = np.empty(order.size, np.int64)
    place[order] = np.arange(order.size)
    return Zones(np.concatenate([found.centre, ZONE * found.radius[:, None]], axis=1), first, place[picked])


def _farther(n: Numbers, settings: Settings) -> tuple[Numbers, Numbers]:
    """Return the settings for ringing in zones, for edges with a response and for those without."""
    until = (1.0 + 2.0 * ZONE) * float(settings.foci.radius.max(initial=0.0))  # from the rim to the circle's far side
    short = n._replace(
        near=settings.negligible_end,
        negligible_end=until,
        reach=settings.negligible_end,
        negligible_line=max(until, settings.negligible_line),
    )
    return short._replace(reach=settings.negligible_line), short


def turns(footprint: Footprint) -> int:
    """Return the order of a footprint's rotational symmetry: 2 (half a turn) or 4 (a quarter turn)."""
    return 4 if footprint.square else 2


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
