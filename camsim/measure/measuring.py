"""A picture in, a report out: the regions given, or the edges found."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from camsim.errors import UnsupportedError
from camsim.measure.find import find_edges
from camsim.measure.geometry import Roi
from camsim.measure.given import check_given
from camsim.measure.mtf import TheoreticalOtf, measure_edge
from camsim.measure.picture import Picture
from camsim.measure.result import EdgeMtf, MtfReport
from camsim.typed import check


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

    rois   : regions with one edge each; without any the edges are looked for
    tail   : add the line spread beyond the region (False: the plain ISO 12233 figure)
    theory : a transfer function to put beside every edge
    progress : called with what is at work and which fraction of it is done

    A region that was given and cannot be measured raises UnsupportedError; of the edges found, those that cannot are
    listed in ``refused``.

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
    given = bool(rois)
    for roi in rois:
        roi.check_inside(picture.shape)
    edges: list[EdgeMtf] = []
    refused: list[str] = []
    looked_at = rois or find_edges(picture)
    for number, roi in enumerate(looked_at):
        for each in channels:
            if progress is not None:
                progress("measuring edges", number / len(looked_at))
            try:
                edges.append(measure_edge(each, roi, tail=tail, theory=theory, what=f"{picture.name}: "))
            except UnsupportedError as error:
                if given:
                    raise
                refused.append(str(error))
    if not edges:
        reason = f" (tried: {refused[0]})" if refused else ""
        raise UnsupportedError(
            f"no measurable slanted edge found{reason}; a straight dark-to-bright edge of 40 px or "
            "more, turned by 2° to 43° and with 20 px free on either side, is needed, or point at one with a roi",
            stage=picture.name,
        )
    return MtfReport(
        file=picture.name,
        pitch_um=picture.pitch_um,
        edges=tuple(edges),
        full_frame=picture.full_frame,
        refused=tuple(refused),
        description=picture.description,
    )
