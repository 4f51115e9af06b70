"""The page of results: rankings, linked crops at 1:1 to 8:1 and error maps, in one file without a network."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camsim.bench.html import bullets, document, paragraph, section, table
from camsim.core.arrays import F32, U8
from camsim.files.png import plain
from camsim.measure.demosaic.artefacts import delta_e_map
from camsim.measure.demosaic.develop import developed
from camsim.measure.demosaic.subject import CHANNELS, Subject
from camsim.measure.demosaic.verdict import Verdict

if TYPE_CHECKING:
    from camsim.measure.demosaic import Ranking

LARGEST = 512
"""Largest side of displayed pictures, pixels; larger ones are cropped to the centre."""

WORST_DELTA_E = 20.0

_TEMPLATES = Path(__file__).parent / "templates"

_HEADS = (
    "method", "CPSNR dB", *(f"{name} dB" for name in CHANNELS), "developed dB", "SSIM", "MS-SSIM", "ΔE2000",
    "ΔE2000 95\N{NO-BREAK SPACE}%", "zipper", "false colour ΔC", "shift x px", "shift y px", "faults",
)  # fmt: skip

_DECIMALS = dict(enumerate((2, 2, 2, 2, 2, 4, 4, 2, 2, 4, 2, 2, 2), start=1))


@dataclass(frozen=True, slots=True)
class _Displayed:
    name: str
    picture: bytes
    error: bytes | None


@dataclass(slots=True)
class _Gallery:
    subject: Subject
    window: tuple[slice, slice]
    displayed: list[_Displayed]


@dataclass(slots=True)
class Page:
    """The page while it is being made: it stores, of every picture evaluated, only the parts that it displays."""

    galleries: list[_Gallery] = field(default_factory=list)

    def begin(self, subject: Subject) -> None:
        """Begin a subject with its truth."""
        rows, cols = (slice(max(0, (n - LARGEST) // 2), (n - min(n, LARGEST)) // 2 + LARGEST) for n in subject.shape)
        truth = plain(_bytes(developed(subject.truth[rows, cols], subject.to_xyz)))
        self.galleries.append(_Gallery(subject, (rows, cols), [_Displayed("truth", truth, None)]))

    def keep(self, verdict: Verdict, image: F32) -> None:
        """Store a result's picture and error map."""
        here = self.galleries[-1]
        subject, window = here.subject, here.window
        picture = plain(_bytes(developed(np.ascontiguousarray(image[window]), subject.to_xyz)))
        heat = np.clip(delta_e_map(image, subject)[window] / WORST_DELTA_E, 0.0, 1.0)
        here.displayed.append(_Displayed(verdict.method, picture, plain(_heat(heat))))

    def html(self, rankings: Sequence[Ranking]) -> str:
        """Return the page."""
        css, script = (_TEMPLATES.joinpath(f"judge.{end}").read_text("utf-8") for end in ("css", "js"))
        parts = [f"<style>\n{css}</style>", paragraph(_ABOUT, "run")]
        for number, (ranking, gallery) in enumerate(zip(rankings, self.galleries, strict=True)):
            parts.append(
                section(_title(ranking), _table(ranking) + _faults(ranking) + _viewer(number, ranking, gallery))
            )
        parts.append(f"<script>\n{script}</script>")
        return document("camsim measure demosaic", parts, {}, heading="Demosaicing, compared with the truth")


_ABOUT = (
    "Higher is better in dB and SSIM, lower in ΔE, zipper and false colour. Ranked by CPSNR in linear light, whose "
    "peak is a perfect diffuser. Pictures are developed by the camera's matrix and the sRGB curve; error maps show "
    f"CIEDE2000 from black (0) over red and yellow to white ({WORST_DELTA_E:g} and more)."
)


def _title(ranking: Ranking) -> str:
    cfa = f", {ranking.cfa}" if ranking.cfa else ""
    return f"{ranking.subject}: {ranking.rows} × {ranking.cols}{cfa}"


def _table(ranking: Ranking) -> str:
    rows = [
        [
            v.method,
            v.cpsnr_db,
            *v.psnr_db,
            v.cpsnr_developed_db,
            v.ssim,
            v.ms_ssim,
            v.delta_e_mean,
            v.delta_e_95,
            v.zipper,
            v.false_colour,
            v.shift_x_px,
            v.shift_y_px,
            "identical" if v.identical else ", ".join(fault.name for fault in v.faults) or "none",
        ]
        for v in ranking.verdicts
    ]
    left = f", {ranking.clipped} clipped" if ranking.clipped else ""
    return table(
        f"{ranking.photosites} photosites compared{left}; press a head to sort", _HEADS, rows, decimals=_DECIMALS
    )


def _faults(ranking: Ranking) -> str:
    stated = [f"{v.method}: {fault.name}: {fault.sentence}" for v in ranking.verdicts for fault in v.faults]
    return bullets([*stated, *(f"left out: {sentence}" for sentence in ranking.left_out)])


def _viewer(number: int, ranking: Ranking, gallery: _Gallery) -> str:
    order = {verdict.method: rank for rank, verdict in enumerate(ranking.verdicts, start=1)}
    displayed = sorted(gallery.displayed, key=lambda each: order.get(each.name, 0))
    best = {verdict.method: verdict for verdict in ranking.verdicts}
    panels = [
        {
            "name": each.name,
            "told": f"{order[each.name]}. {each.name}" if each.name in order else each.name,
            "cpsnr": _stated(best[each.name]) if each.name in best else "",
            "picture": _url(each.picture),
            "error": _url(each.error) if each.error is not None else None,
        }
        for each in displayed
    ]
    rows, cols = gallery.window
    data = {"row": rows.start, "col": cols.start, "panels": panels}
    text = json.dumps(data, ensure_ascii=False).replace("<", "\\u003c")
    zooms = "".join(
        f'<button type="button" data-zoom="{zoom}" aria-pressed="{"true" if zoom == 4 else "false"}">{zoom}:1</button>'
        for zoom in (1, 2, 4, 8)
    )
    return (
        f'<div class="judge" data-judge="{number}"><div class="bar" role="group" aria-label="Size">{zooms}'
        '<label><input type="checkbox" class="errors"> error maps</label>'
        '<span class="where" role="status"></span></div>'
        '<p class="run">Drag a picture, or use the arrow keys on it: all move together. Turn the wheel, or press a '
        'size, to enlarge.</p><div class="panels"></div>'
        f'<script type="application/json">{text}</script></div>\n'
    )


def _stated(verdict: Verdict) -> str:
    return "identical" if verdict.identical else f"{verdict.cpsnr_db:.2f} dB, ΔE2000 {verdict.delta_e_mean:.2f}"


def _url(picture: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(picture).decode("ascii")


def _bytes(image: F32) -> U8:
    codes: U8 = np.rint(255.0 * image).astype(np.uint8)
    return codes


def _heat(share: F32) -> U8:
    """Return black, red, yellow, white as 0 goes to 1."""
    ramp = np.clip(3.0 * share[..., None] - np.array([0.0, 1.0, 2.0]), 0.0, 1.0)
    return _bytes(ramp.astype(np.float32))
