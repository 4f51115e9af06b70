"""The MTF report of a picture, on edges in given regions or on detected edges."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import TypeAlias

from camsim.core.typed import check
from camsim.errors import UnsupportedError
from camsim.measure.find import find_edges
from camsim.measure.geometry import Roi
from camsim.measure.given import check_given
from camsim.measure.mtf import TheoreticalOtf, measure_edge
from camsim.measure.picture import Channel, Picture
from camsim.measure.result import EdgeMtf, MtfReport
from camsim.rendering.running import to_nobody

_Tried: TypeAlias = tuple[list[EdgeMtf], list[str]]
"""Measured edges, and reasons for those not measurable."""


def measure_mtf(
    picture: Picture,
    *,
    rois: Sequence[Roi] = (),
    channel: str = "all",
    tail: bool = True,
    theory: TheoreticalOtf | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> MtfReport:
    """Measure the edges of a picture, in one channel or in all.

    rois   : regions with one edge each; without any, edges are detected
    tail   : add the line spread beyond the region (False: the plain ISO 12233 figure)
    theory : a transfer function to compare with every edge
    progress : called with (stage, fraction done)

    A given region that cannot be measured raises UnsupportedError; detected edges that cannot be measured are listed in
    ``refused``.

    >>> import camsim
    >>> frame = camsim.capture(
    ...     "slanted-edge", overrides=["region={rows: 96, cols: 96, origin: [950, 1330]}", "render.tolerance=1e-3"]
    ... )
    >>> report = measure_mtf(camsim.measure.picture_of_frame(frame), channel="G1")
    >>> [round(edge.figures.mtf50_cycles_per_pixel, 1) for edge in report.edges]
    [0.3]
    """
    check_given(picture=picture)
    check(rois, tuple[Roi, ...], "rois")
    check(tail, bool, "tail")
    channels = picture.select(channel)
    for roi in rois:
        roi.check_inside(picture.shape)
    measure = functools.partial(_each, channels, tail=tail, theory=theory, what=f"{picture.name}: ")
    edges: list[EdgeMtf] = []
    refused: list[str] = []
    for roi in rois:
        edges += measure(roi, given=True)[0]
    if not rois:
        edges, refused = _measured(picture, measure, progress or to_nobody)
    return MtfReport(
        file=picture.name,
        pitch_um=picture.pitch_um,
        edges=tuple(edges),
        full_frame=picture.full_frame,
        refused=tuple(refused),
        description=picture.description,
    )


def _measured(picture: Picture, measure: Callable[[Roi], _Tried], progress: Callable[[str, float], None]) -> _Tried:
    """Return the edges that were found and measured, and of all others the reasons; raises where there are none."""
    found = find_edges(picture)
    edges: list[EdgeMtf] = []
    refused: list[str] = []
    for number, rois in enumerate(found.edges):
        progress("measuring edges", number / len(found.edges))
        attempts = []
        for roi in rois:
            attempts.append(measure(roi))
            if not attempts[-1][1]:
                break
        measured, reasons = max(attempts, key=lambda each: len(each[0]))  # the first of equal ones
        edges += measured
        refused += reasons
    refused += [f"{picture.name}: {sentence}" for sentence in found.without]
    if not edges:
        tried = f" (tried: {refused[0].removeprefix(f'{picture.name}: ')})" if refused else ""
        several = f"; nor can {len(refused) - 1} more be measured" if len(refused) > 1 else ""
        raise UnsupportedError(
            f"no measurable slanted edge found{tried}{several}; a straight dark-to-bright edge of 25 px or more, "
            "turned by 2° to 43° and with 8 px free on either side, is needed, or point at one with a roi",
            stage=picture.name,
        )
    return edges, refused


def _each(
    channels: Sequence[Channel], roi: Roi, *, tail: bool, theory: TheoreticalOtf | None, what: str, given: bool = False
) -> _Tried:
    """Return a region's edge in every channel, and why it could not be measured in others; raises of a given one."""
    edges: list[EdgeMtf] = []
    refused: list[str] = []
    for channel in channels:
        try:
            edges.append(measure_edge(channel, roi, tail=tail, theory=theory, what=what))
        except UnsupportedError as error:
            if given:
                raise
            refused.append(str(error))
    return edges, refused
