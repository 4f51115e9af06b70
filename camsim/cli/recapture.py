"""``camsim recapture``: the same picture again, from the file alone."""

from __future__ import annotations

import contextlib
import filecmp
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from camsim.cli import outputs as outputs_of
from camsim.cli.outputs import Output
from camsim.cli.progress import Bar
from camsim.cli.row_by_row import come_row_by_row, write_mosaics
from camsim.core.garbage import look_in_new
from camsim.errors import CamsimError, InputError, OutputError
from camsim.files.atomic import together
from camsim.files.reading import Held, is_altered, read_arrays, read_file

if TYPE_CHECKING:
    from camsim.camera.capture import Capture
    from camsim.camera.frame import Frame, Product, Products
    from camsim.camera.shot import Shot


def recapture(file: str, texts: Sequence[str], *, force: bool, quiet: bool) -> None:
    """Compute again what ``file`` describes and write it; by default the same product next to it.

    texts : FILE[:PRODUCT] to write, any product, independent of that in the file
    """
    held = read_file(file)
    again = f"{Path(file).stem}-again{Path(file).suffix}:{held.product}"
    outputs, errors = outputs_of.check(texts or (again,), force=force)
    if errors:
        raise CamsimError("\n".join(str(error) for error in errors))
    from camsim.files import save

    look_in_new()
    with Bar(displayed=not quiet) as bar, together():
        how = {"allow_odd_cfa": True, "compress": held.compressed}
        row_by_row = come_row_by_row(outputs) and not held.has_truth
        frame = _written_row_by_row(held, outputs, bar, **how) if row_by_row else _frame_of(held, outputs, bar)
        for output in outputs:
            if not row_by_row or output.product == "spectral":
                save(frame, output.path, product=output.product, force=True, **how)
    if not quiet:
        for output in outputs:
            print(f"{output.path}: {_compared(held, output)}", file=sys.stderr)


def _frame_of(held: Held, outputs: Sequence[Output], bar: Bar) -> Frame:
    """Repeat the capture described by a file; raises InputError if it describes none."""
    products: set[Product] = {output.product for output in outputs}
    if held.has_truth:
        products.add("truth")
    with _named(held):
        capture = _capture_of(held)
        _refuse_what_does_not_fit(capture, products, held=True)
        return capture.frame(products=products, progress=bar.update)


def _written_row_by_row(held: Held, outputs: Sequence[Output], bar: Bar, **how: bool) -> Frame:
    """Repeat the capture and write its mosaics while it is computed."""
    products = {output.product for output in outputs}
    with _named(held):
        capture = _capture_of(held)
        _refuse_what_does_not_fit(capture, products, held=capture.camera.needs_whole_window)
        return write_mosaics(
            outputs,
            lambda take: capture.rows(take, products=products, progress=bar.update),
            camera=capture.camera,
            region=capture.region,
            **how,
        )


def _capture_of(held: Held) -> Capture | Shot:
    """Return the capture described by a file; it must give an image of the file's size."""
    from camsim.config.from_record import shot_from_record

    held.record.check_size(held.rows, held.cols)
    return shot_from_record(held.description, held.path.parent)


def _refuse_what_does_not_fit(capture: Capture | Shot, products: Products, *, held: bool) -> None:
    from camsim.core import memory

    grid = capture.grid
    needed = memory.needed_bytes(grid.rows, grid.cols, len(capture.camera.cfa.channels), products, held=held)
    if message := memory.too_large(grid.rows, grid.cols, needed):
        raise InputError(message)


@contextlib.contextmanager
def _named(held: Held) -> Iterator[None]:
    """Name the file in errors."""
    name = repr(str(held.path))
    try:
        yield
    except OutputError:
        raise
    except CamsimError as error:
        raise InputError(f"cannot capture {name} again: {error}") from None


def _compared(held: Held, output: Output) -> str:
    if output.product != held.product or Path(output.path).suffix.lower() != held.path.suffix.lower():
        return output.product
    if filecmp.cmp(held.path, output.path, shallow=False):
        return f"the same bytes as {held.path}"
    try:
        parts = ", ".join(_parts(held, read_file(output.path)))
        return f"differs from {held.path} in {parts} ({_why(held)})"
    except InputError as error:
        return f"differs from {held.path} ({error})"


def _parts(held: Held, again: Held) -> Iterator[str]:
    """Yield the differences of two files of one kind, with their size."""
    one, two = (_fields(each.record.as_dict()) for each in (held, again))
    if fields := sorted(name for name in one.keys() | two.keys() if one.get(name) != two.get(name)):
        yield f"its record ({', '.join(fields)})"
    arrays, others = read_arrays(held), read_arrays(again)
    differs = bool(fields)
    for name in sorted(arrays.keys() | others.keys()):
        mine, other = arrays.get(name), others.get(name)
        if mine is None or other is None or mine.shape != other.shape:
            differs = True
            yield f"{name}, which only one of them has in this shape"
            continue
        with np.errstate(invalid="ignore"):  # damaged files may contain NaN
            off = np.abs(mine.astype(np.float64) - other)
        if count := np.count_nonzero(off):
            differs = True
            yield f"{count} of {off.size} numbers of {name}, by up to {off.max():.3g} of {np.abs(other).max():.6g}"
    if not differs:
        yield "what goes with the same numbers and record: tags, or how they are packed"


def _fields(tree: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parts of a record by name, with the description split into its parts."""
    parts = {name: part for name, part in tree.items() if name not in ("description", "description_sha256")}
    return parts | {f"description.{name}": part for name, part in tree["description"].items()}


def _why(held: Held) -> str:
    from camsim.files.describe import software

    if is_altered(held):
        return "an altered file: its codes do not fit its own identifier"
    if (said := held.record.software) != software():
        return f"written by {said}, and this is {software()}"
    return (
        "another processor, or another version of a library such as NumPy, may end on other last bits; more than last "
        "bits is a change made since"
    )
