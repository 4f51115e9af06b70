"""``camsim measure colour``: measured patches of a file, and their reference colours."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camsim.cli.measured import Outputs, picture_and_capture
from camsim.cli.tables import check_text_file, print_table
from camsim.errors import InvalidValueError, OutputError
from camsim.files.atomic import together, write_whole

if TYPE_CHECKING:
    from camsim.core.arrays import U8
    from camsim.measure import Picture
    from camsim.measure.colour import ColourReport, PatchColour
    from camsim.spectra.light import Light

_HEADS = (
    "patch", "row,col,rows,cols", "L*", "a*", "b*", "reference L*", "a*", "b*", "ΔE2000", "noise L*", "a*", "b*",
    "SNR dB",
)  # fmt: skip
_COLUMNS = (
    "patch", "row", "col", "rows", "cols", "photosites", "lightness", "a", "b", "reference_lightness", "reference_a",
    "reference_b", "delta_e_2000", "delta_e_error", "noise_lightness", "noise_a", "noise_b", "snr_db",
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class ChartRequest:
    """A ColorChecker in any file; the fields have the meaning of the options of the same names."""

    light: str | None
    corners: str | None
    reflectances: str
    cfa: str | None


def measure(file: str, picture_file: str | None, request: ChartRequest, outputs: Outputs) -> None:
    """Measure, print and write; raises CamsimError with one sentence.

    picture_file : file for a picture of the chart with reference halves
    """
    from camsim.measure import read_picture

    _check(picture_file, outputs)
    picture = read_picture(file, cfa=request.cfa)
    if picture.description is None or request.light is not None or request.corners is not None:
        report, draw_halves = _of_chart(picture, request)
    else:
        report, draw_halves = _of_scene(file)
    with together():
        outputs.write(_COLUMNS, map(_values, report.patches), functools.partial(_draw, report))
        if picture_file is not None:
            from camsim.files.png import plain

            write_whole(picture_file, plain(draw_halves()))
    outputs.tell(report, _print)


def _of_scene(file: str) -> tuple[ColourReport, Callable[[], U8]]:
    from camsim.measure.colour import measure_colour
    from camsim.measure.colour.picture import halves

    picture, capture = picture_and_capture(file)
    report = measure_colour(picture, capture)
    return report, lambda: halves(picture, capture, report)


def _of_chart(picture: Picture, request: ChartRequest) -> tuple[ColourReport, Callable[[], U8]]:
    from camsim.measure.colour import measure_chart
    from camsim.measure.colour.picture import halves_of_chart

    how: dict[str, Any] = {"corners": corners_of(request.corners), "chart": request.reflectances}
    light = light_of("D50" if request.light is None else request.light)
    return measure_chart(picture, light, **how), lambda: halves_of_chart(picture, light, **how)


def light_of(text: str) -> Light:
    """Return an illuminant by its name, or the light whose relative power a CSV file holds."""
    from camsim.spectra.curve import Curve
    from camsim.spectra.light import Light

    if Path(text).suffix.lower() in (".csv", ".txt", ".tsv"):
        return Light(Curve.from_csv(text, name=Path(text).stem, outside="zero"), irradiance_w_per_m2=1.0)
    return Light(text, irradiance_w_per_m2=1.0)


def corners_of(text: str | None) -> list[tuple[float, float]] | None:
    """Return the places (row, col) of ``R,C,R,C,R,C,R,C``."""
    if text is None:
        return None
    try:
        numbers = [float(word) for word in text.replace(";", ",").split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 8:
        message = (
            f"{text!r}; give row,col of the middles of four patches, dark skin, bluish green, black and white: "
            "120,200,130,900,620,890,610,210"
        )
        raise InvalidValueError(message, key="--corners")
    return list(itertools.pairwise(numbers))[::2]


def _draw(report: ColourReport, file: str) -> bytes:
    from camsim.cli.plot_colour import draw

    return draw(report, file)


def _check(picture_file: str | None, outputs: Outputs) -> None:
    """Raise early for outputs that cannot be written."""
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
    if white is None and "the file" not in report.development:
        print("white balance: the file notes none; taken from the chart's greys")
    elif white is None:
        print("white balance: no grey patch tells it")
    else:
        off = f"R/G {white.r_over_g:.4f}, B/G {white.b_over_g:.4f} of what the spectra give"
        print(f"white balance on {len(white.patches)} greys: {off}, ΔC*ab {white.chroma:.2f}")
    for sentence in report.left_out:
        print(f"left out: {sentence}")
