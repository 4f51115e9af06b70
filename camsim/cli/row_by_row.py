"""Files written while the capture is computed, without holding it in memory."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from camsim.cli.outputs import Output

if TYPE_CHECKING:
    from camsim.camera.body import Body
    from camsim.camera.frame import Frame
    from camsim.camera.window import Region
    from camsim.core.arrays import U16


def come_row_by_row(outputs: Iterable[Output]) -> bool:
    """Whether all files can be written row by row; a spectral cube also can, as it does not use the photosites."""
    from camsim.files import comes_row_by_row

    return all(output.product == "spectral" or comes_row_by_row(output.path, output.product) for output in outputs)


def write_mosaics(
    outputs: Sequence[Output],
    expose: Callable[[Callable[[U16], None]], Frame],
    *,
    camera: Body,
    region: Region | None,
    **how: bool,
) -> Frame:
    """Write the mosaics among ``outputs``; ``expose`` is called with the function that takes their rows.

    how : ``allow_odd_cfa`` and ``compress``, as of ``camsim.files.save``
    """
    from camsim.files import writing_rows

    with contextlib.ExitStack() as stack:
        writers = [
            stack.enter_context(writing_rows(output.path, camera=camera, region=region, force=True, **how))
            for output in outputs
            if output.product == "mosaic"
        ]

        def take(codes: U16) -> None:
            for writer in writers:
                writer.take(codes)

        frame = expose(take)
        for writer in writers:
            writer.finish(frame)
    return frame
