"""``camsim measure colour``: the patches that a file's scene shows, beside what the eye would see of them."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from camsim.cli.tables import check_text_file, csv_text, print_table
from camsim.errors import InvalidValueError, OutputError, UnsupportedError
from camsim.files.atomic import write_whole

if TYPE_CHECKING:
    from camsim.exposing import Capture
    from camsim.measure import Picture
    from camsim.measure.colour import ColourReport, PatchColour

_HEADS = (
    "patch", "row,col,rows,cols", "L*", "a*", "b*", "reference L*", "a*", "b*", "ΔE2000", "noise L*", "a*", "b*",
    "SNR dB",
)  # fmt: skip
_COLUMNS = (
    "patch", "row", "col", "rows", "cols", "photosites", "lightness", "a", "b", "reference_lightness", "reference_a",
    "reference_b", "delta_e_2000", "delta_e_error", "noise_lightness", "noise_a", "noise_b", "snr_db",
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class ColourRequest:
    """What the user asked for."""

    file: str
    as_json: bool
    csv: str | None
    plot: str | None
    picture: str | None
    force: bool


def measure(request: ColourRequest) -> None:
    """Measure, print and write; raises CamsimError with one sentence."""
    from camsim.measure.colour import measure_colour

    _check(request)
    picture, capture = picture_and_capture(request.file)
    report = measure_colour(picture, capture)
    if request.csv is not None:
        write_whole(request.csv, csv_text(_COLUMNS, map(_values, report.patches)).encode("utf-8"))
    if request.plot is not None:
        from camsim.cli.plot_colour import draw

        write_whole(request.plot, draw(report, request.plot))
    if request.picture is not None:
        from camsim.files.png import plain
        from camsim.measure.colour.picture import halves

        write_whole(request.picture, plain(halves(picture, capture, report)))
    if request.as_json:
        print(json.dumps(report.as_dict(), indent=2, ensure_ascii=False))
        return
    _print(report)


def picture_and_capture(file: str) -> tuple[Picture, Capture]:
    """Return a file's picture and what it says it was taken of; raises UnsupportedError where it says nothing."""
    from camsim.measure import read_picture
    from camsim.revive import revive_capture

    picture = read_picture(file)
    if picture.description is None:
        raise UnsupportedError(
            "does not say what it was taken of; camsim's own files do (.dng, .tiff, .exr, .png:mosaic)", stage=file
        )
    return picture, replace(revive_capture(picture.description), scene_name=file)


def _check(request: ColourRequest) -> None:
    """Refuse what cannot be written, before any work."""
    if request.csv is not None:
        check_text_file(request.csv, force=request.force)
    if request.plot is not None:
        from camsim.cli.plot import check_drawing

        check_drawing(request.plot, force=request.force)
    if request.picture is not None:
        if Path(request.picture).suffix.lower() != ".png":
            raise OutputError(f"cannot write {request.picture!r}: the picture is a .png")
        check_text_file(request.picture, force=request.force)
    named = [Path(file).resolve() for file in (request.csv, request.plot, request.picture) if file is not None]
    if len(set(named)) < len(named):
        raise InvalidValueError("two of --csv, --plot and --picture name one file", key="--picture")


def _values(patch: PatchColour) -> tuple[object, ...]:
    roi = patch.roi
    where = patch.name, roi.row, roi.col, roi.rows, roi.cols, patch.photosites
    figures = *patch.lab, *patch.reference_lab, patch.delta_e_2000, patch.delta_e_error, *patch.noise_lab, patch.snr_db
    return *where, *(f"{value:.6g}" if math.isfinite(value) else "" for value in figures)


def _print(report: ColourReport) -> None:
    rows = []
    for patch in report.patches:
        error = f"{patch.delta_e_2000:.2f} ± {patch.delta_e_error:.2f}"
        snr = f"{patch.snr_db:.1f}" if math.isfinite(patch.snr_db) else "∞"
        lab = (f"{value:.2f}" for value in (*patch.lab, *patch.reference_lab))
        rows.append((patch.name, str(patch.roi), *lab, error, *(f"{v:.2f}" for v in patch.noise_lab), snr))
    title = f"{report.file}: {len(report.patches)} patches, CIE Lab under D50"
    print_table(title, _HEADS, rows)
    print(f"ΔE2000: mean {report.delta_e_mean:.2f}, largest {report.delta_e_largest:.2f}")
    white = report.white_balance
    if white is None:
        print("white balance: no grey patch tells it")
    else:
        off = f"R/G {white.r_over_g:.4f}, B/G {white.b_over_g:.4f} of what the spectra give"
        print(f"white balance on {len(white.patches)} greys: {off}, ΔC*ab {white.chroma:.2f}")
    for sentence in report.left_out:
        print(f"left out: {sentence}")
