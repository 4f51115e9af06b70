"""Writing Frames to files: the suffix chooses the format, the product the content."""

from __future__ import annotations

import contextlib
import functools
import os
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from camsim.camera.body import Body
from camsim.camera.frame import PRODUCTS, Frame, Product
from camsim.camera.window import Region
from camsim.core.calls import in_words
from camsim.core.typed import FilePath, check, check_truths
from camsim.errors import OutputError, did_you_mean
from camsim.files import dng, exr, npy, npz, png, tiff
from camsim.files.atomic import reason, replacing


@dataclass(frozen=True, slots=True)
class Format:
    """The format of a suffix: a writer for each product; the first one is the default."""

    title: str
    writers: Mapping[Product, Callable[[Frame, Path], None]]

    @property
    def default(self) -> Product:
        """The product that is written when none is named."""
        return next(iter(self.writers))


_TIFF = Format("TIFF", {"mosaic": tiff.write_mosaic, "truth": tiff.write_truth})

SUFFIXES: Mapping[str, Format] = {
    ".dng": Format("DNG", {"mosaic": dng.write_dng, "truth": dng.write_truth}),
    ".exr": Format(
        "OpenEXR", {"truth": exr.write_truth, "electrons": exr.write_electrons, "spectral": exr.write_spectral}
    ),
    ".tiff": _TIFF,
    ".tif": _TIFF,
    ".png": Format("PNG", {"preview": png.write_preview, "mosaic": png.write_mosaic}),
    ".npy": Format("NPY", {"mosaic": npy.write_mosaic, "electrons": npy.write_electrons, "truth": npy.write_truth}),
    ".npz": Format("NPZ", {"frame": npz.write_frame}),
}


@in_words
def save(
    frame: Frame,
    path: str | os.PathLike[str],
    *,
    product: Product | None = None,
    force: bool = False,
    allow_odd_cfa: bool = False,
    compress: bool = False,
) -> None:
    """Write one product of the frame; the suffix of ``path`` chooses the format.

    product       : None: the mosaic in .dng .tiff .npy, the truth in .exr, the preview in .png, the frame in .npz
    force         : overwrite an existing file
    allow_odd_cfa : write a DNG even of a colour filter array that raw developers misread (`odd_cfa` names them)
    compress      : write a DNG as lossless JPEG; needs the package imagecodecs

    The file is written next to its destination and moved there when complete: on any error, an older file
    of that name is unchanged. Equal frames give equal bytes. Raises OutputError in one sentence.

    >>> import tempfile
    >>> from pathlib import Path
    >>> import camsim
    >>> frame = camsim.capture("flat-field", overrides=["region={rows: 2, cols: 2}", "render.tolerance=1e-2"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     camsim.save(frame, Path(folder) / "flat.tiff")
    ...     [path.name for path in Path(folder).iterdir()]
    ['flat.tiff']
    """
    check(frame, Frame, "frame")
    path = check(path, FilePath, "path")
    check(product, str | None, "product")
    check_truths(force=force, allow_odd_cfa=allow_odd_cfa, compress=compress)
    chosen = check_output(path, product)
    _refuse_what_exists(path, force=force)
    if (chosen == "truth" and frame.truth is None) or (chosen == "spectral" and frame.spectral is None):
        held = "; it holds electrons, product='electrons'" if product is None and not frame.passed_rows else ""
        message = f"the capture holds no {chosen}; ask for products=({chosen!r},){held}"
        raise OutputError(f"cannot write {str(path)!r}: {message}")
    target = Path(path)
    writer = SUFFIXES[target.suffix.lower()].writers[chosen]
    if writer is dng.write_dng:
        writer = functools.partial(dng.write_dng, allow_odd_cfa=allow_odd_cfa, compress=compress)
    elif writer is dng.write_truth:
        writer = functools.partial(dng.write_truth, compress=compress)
    with replacing(target) as temporary:
        writer(frame, temporary)


def comes_row_by_row(path: str, product: Product) -> bool:
    """Whether ``writing_rows`` can write this."""
    return SUFFIXES[Path(path).suffix.lower()].writers[product] is dng.write_dng


@contextlib.contextmanager
def writing_rows(
    path: str | os.PathLike[str],
    *,
    camera: Body,
    region: Region | None = None,
    force: bool = False,
    allow_odd_cfa: bool = False,
    compress: bool = False,
) -> Iterator[dng.MosaicWriter]:
    """Write a DNG while its mosaic is computed: the same bytes as ``save``, and no memory for the mosaic.

    camera, region : those of the capture: ``frame = capture.rows(writer.take)``; give the frame to ``writer.finish``
    force, allow_odd_cfa, compress : see ``save``

    The file is moved to its destination when the block succeeds; otherwise none is left.
    """
    check_truths(force=force, allow_odd_cfa=allow_odd_cfa, compress=compress)
    check_output(path, "mosaic")
    _refuse_what_exists(path, force=force)
    cols, mono = camera.grid(region).cols, len(camera.cfa.channels) == 1
    with replacing(Path(path)) as temporary, temporary.open("wb") as file:
        yield dng.MosaicWriter(file, cols=cols, mono=mono, allow_odd_cfa=allow_odd_cfa, compress=compress)


def _refuse_what_exists(path: str | os.PathLike[str], *, force: bool) -> None:
    if Path(path).exists() and not force:
        raise OutputError(f"cannot write {str(path)!r}: it exists; overwrite it with force=True")


def check_output(path: str | os.PathLike[str], product: str | None = None) -> Product:
    """Return the product that ``path`` is to hold, or raise OutputError if it could not be written.

    To be called before the work begins: checks the suffix, the product and the folder.
    """
    displayed, target = repr(str(path)), Path(path)
    chosen = _product(displayed, target.suffix, product)
    try:
        if target.is_dir():
            raise OutputError(f"cannot write {displayed}: it is a folder")
        if target.exists() and not target.is_file():
            raise OutputError(f"cannot write {displayed}: it is a device and not a file")
        # The file is written to the target of a link.
        folder = Path(os.path.realpath(target)).parent
        if not folder.exists():
            raise OutputError(f"cannot write {displayed}: the folder {str(folder)!r} does not exist; make it first")
        if not folder.is_dir():
            raise OutputError(f"cannot write {displayed}: {str(folder)!r} is a file and not a folder")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise OutputError(f"cannot write {displayed}: the folder {str(folder)!r} does not allow writing")
    except OSError as error:
        raise OutputError(f"cannot write {displayed}: {reason(error)}") from error
    except ValueError as error:
        raise OutputError(f"cannot write {displayed}: {error}") from error
    return chosen


def _product(displayed: str, suffix: str, product: str | None) -> Product:
    form = SUFFIXES.get(suffix.lower())
    if form is None:
        what = f"unknown suffix {suffix!r}" if suffix else "the name has no suffix to choose the format by"
        raise OutputError(f"cannot write {displayed}: {what}{did_you_mean(suffix, SUFFIXES)}")
    if product is None:
        return form.default
    if product not in PRODUCTS:
        raise OutputError(f"cannot write {displayed}: unknown product {product!r}{did_you_mean(product, PRODUCTS)}")
    known: dict[str, Product] = {name: name for name in PRODUCTS}
    if known[product] not in form.writers:
        able = [name for name, other in SUFFIXES.items() if product in other.writers]
        raise OutputError(
            f"cannot write {displayed}: {form.title} holds {_either(form.writers)} and not {product}; "
            f"{product} goes into {_either(able)}"
        )
    return known[product]


def _either(names: Collection[str]) -> str:
    *rest, last = names
    return f"{', '.join(rest)} or {last}" if rest else last
