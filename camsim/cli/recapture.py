"""``camsim recapture``: the same picture again, from the file alone."""

from __future__ import annotations

import filecmp
import gc
import sys
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from camsim.cli import outputs as outputs_of
from camsim.cli.outputs import Output
from camsim.cli.progress import Bar
from camsim.errors import CamsimError, InputError
from camsim.files.reading import Held, read_file

if TYPE_CHECKING:
    from camsim.frame import Frame


def recapture(file: str, texts: Sequence[str], *, force: bool, quiet: bool) -> None:
    """Compute again what ``file`` describes and write it; by default its own product beside its name.

    texts : FILE[:PRODUCT] to write, any product, whatever the file itself holds
    """
    held = read_file(file)
    again = f"{Path(file).stem}-again{Path(file).suffix}:{held.product}"
    outputs, errors = outputs_of.check(texts or (again,), force=force)
    if errors:
        raise CamsimError("\n".join(str(error) for error in errors))
    from camsim.files import save

    gc.enable()
    with Bar(shown=not quiet) as bar:
        products = {output.product for output in outputs} | ({"truth"} if held.has_truth else set())
        frame = frame_of(held, products, bar)
        for output in outputs:
            save(frame, output.path, product=output.product, allow_odd_cfa=True, compress=held.compressed)
    if not quiet:
        for output in outputs:
            print(f"{output.path}: {_compared(held, output)}", file=sys.stderr)


def frame_of(held: Held, products: Collection[str], bar: Bar | None = None) -> Frame:
    """Take the picture that a file describes once more; raises InputError when it describes none."""
    from camsim.camera import Camera
    from camsim.config import memory
    from camsim.revive import revive
    from camsim.scene import Scene

    name = repr(str(held.path))
    try:
        parts = revive(held.description)
        camera, scene = parts.pop("camera", None), parts.pop("scene", None)
        if not isinstance(camera, Camera) or not isinstance(scene, Scene):
            raise InputError("it describes no camera and scene")
        region = parts.get("region")
        rows, cols = (region.rows, region.cols) if region else (camera.rows, camera.cols)
        needed = memory.needed_bytes(rows, cols, len(camera.cfa.channels), products)
        if needed > memory.available_bytes():
            raise InputError(f"{rows} × {cols} photosites need about {memory.readable(needed)} of memory")
        return camera.expose(scene, products=products, progress=bar.update if bar else None, **parts)
    except CamsimError as error:
        raise InputError(f"cannot capture {name} again: {error}") from None
    except (TypeError, AttributeError) as error:
        raise InputError(
            f"cannot capture {name} again: this version of camsim takes other parts ({error}); "
            f"use the version that wrote it ({held.record.get('software', 'unknown')})"
        ) from None


def _compared(held: Held, output: Output) -> str:
    if output.product != held.product or Path(output.path).suffix.lower() != held.path.suffix.lower():
        return output.product
    if filecmp.cmp(held.path, output.path, shallow=False):
        return f"the same bytes as {held.path}"
    from camsim.files.describe import software

    said = held.record.get("software", "unknown")
    why = "an altered file" if said == software() else f"written by {said}, and this is {software()}"
    return f"differs from {held.path} ({why})"
