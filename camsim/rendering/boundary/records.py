"""Inputs of the kernels: edges, tables and settings as records of arrays. Lengths are in pitches."""

from __future__ import annotations

from typing import NamedTuple

from camsim.core.arrays import C128, F64, I64
from camsim.core.kernels import kernel
from camsim.rendering.boundary.far import Moments


class TabledEdges(NamedTuple):
    """Edges in pitches, with the indices of each into the tables."""

    x: F64  # start
    y: F64
    tx: F64  # unit direction
    ty: F64
    length: F64
    brief: F64  # distance from which the edge is short
    m2: C128  # the footprint's moments in the edge's frame, see far.Moments
    m31: C128
    m4: C128
    m6: C128
    pair: I64  # pair of spectra
    alike: I64  # tabulated pair to which its pair is proportional
    times: F64  # the factor
    response: I64  # edge response, −1 for none


class Tables(NamedTuple):
    """All tables, by pair of spectra and channel; ``field`` and ``response`` by pairs that are not proportional."""

    far: F64  # (pairs, channels, 4)
    field: F64  # (pairs, channels, 2, n, n)
    response: F64  # (directions, pairs, channels, cells, 6)
    base: F64  # (channels,) the background


class Numbers(NamedTuple):
    """The plan's settings, for the kernels; lengths in pitches."""

    near: float  # an end within this distance is integrated; beyond, its ringing is neglected
    reach: float  # an edge response is looked up to this distance; beyond, a line's ringing is neglected
    field_step: float
    response_step: float
    piece: float  # longest piece that one rule integrates
    gauss_x: F64  # (lengths, most): rules for pieces of 1/lengths, 2/lengths … of it
    gauss_w: F64
    gauss_count: I64  # (lengths,) nodes of each
    sigma2: float  # footprint: ½⟨|ζ|²⟩, ⟨|ζ|⁴⟩
    m22: float
    apart: F64  # (c, 2): the field is the mean of its table at these offsets
    separation: float  # half-widths of a tile from which a source is smooth over it
    nodes: F64  # (n,) Chebyshev nodes on −1 … 1
    to_children: F64  # (2, n, n)
    to_photosites: F64  # (levels, n, root), level 0 the root
    root: int  # photosites along the largest tile
    leaf: int  # photosites along the smallest tile


@kernel(forceinline=True)
def moments_of(e: int, edges: TabledEdges, n: Numbers) -> Moments:
    """Return the footprint's moments in the frame of edge ``e``."""
    return Moments(n.sigma2, n.m22, edges.m2[e], edges.m31[e], edges.m4[e], edges.m6[e])
