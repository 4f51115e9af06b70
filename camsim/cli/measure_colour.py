"""``camsim measure colour``: the patches that a file's scene shows, beside what the eye would see of them."""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import TYPE_CHECKING

from camsim.cli.measured import Outputs, picture_and_capture
from camsim.cli.tables import check_text_file, print_table
from camsim.errors import OutputError
from camsim.files.atomic import together, write_whole

if TYPE_CHECKING:
    from camsim.measure.colour import ColourReport, PatchColour

_HEADS = (
    "patch", "row,col,rows,cols", "L*", "a*", "b*", "reference L*", "a*", "b*", "ΔE2000", "noise L*", "a*", "b*",
    "SNR dB",
)  # fmt: skip
_COLUMNS = (
    "patch", "row", "col", "rows", "cols", "photosites", "lightness", "a", "b", "reference_lightness", "reference_a",
    "reference_b", "delta_e_2000", "delta_e_error", "noise_lightness", "noise_a", "noise_b", "snr_db",
)  # fmt: skip


def measure(file: str, picture_file: str | None, outputs: Outputs) -> None:
    """Measure, print and write; raises CamsimError with one sentence.

    picture_file : where a picture of the chart with reference halves goes
    """
    from camsim.measure.colour import measure_colour

    _check(picture_file, outputs)
    picture, capture = picture_and_capture(file)
    report = measure_colour(picture, capture)
    with together():
        outputs.write(_COLUMNS, map(_values, report.patches), functools.partial(_draw, report))
        if picture_file is not None:
            from camsim.files.png import plain
            from camsim.measure.colour.picture import halves

            write_whole(picture_file, plain(halves(picture, capture, report)))
    outputs.tell(report, _print)


def _draw(report: ColourReport, file: str) -> bytes:
    from camsim.cli.plot_colour import draw

    return draw(report, file)


def _check(picture_file: str | None, outputs: Outputs) -> None:
    """Refuse what cannot be written, before any work."""
    outputs.check({"--picture": picture_file})
    if picture_file is not None:
        if Path(picture_file).suffix.lower() != ".png":
            raise OutputError(f"cannot write {picture_file!r}: the picture is a .png")
        check_text_file(picture_file, force=outputs.force)


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
