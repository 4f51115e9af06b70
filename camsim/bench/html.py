"""Pages of tables and figures: one HTML file each, without a network."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from types import MappingProxyType
from typing import Any


def document(title: str, parts: Sequence[str], marks: Mapping[str, str], *, heading: str | None = None) -> str:
    """Return a page: ``parts`` below the heading, in order; ``marks`` is the text of each marker of its figures."""
    css, script = (files("camsim.bench.page").joinpath(f"report.{suffix}").read_text("utf-8") for suffix in _SUFFIXES)
    stated = json.dumps(dict(marks), ensure_ascii=False).replace("<", "\\u003c")
    whole = [
        "<!doctype html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        "<link rel='icon' href='data:,'>",
        f"<title>{escape(title)}</title>\n<style>\n{css}</style>\n</head>\n<body>\n<h1>{escape(heading or title)}</h1>",
        *parts,
        "<p id='hover' role='status' hidden></p>",
        f"<script type='application/json' id='words'>{stated}</script>",
        f"<script>\n{script}</script>\n</body>\n</html>\n",
    ]
    return "\n".join(part for part in whole if part)


_SUFFIXES = ("css", "js")


def section(title: str, body: str) -> str:
    """Return a section; empty without content."""
    return f"<section><h2>{escape(title)}</h2>\n{body}</section>" if body else ""


def paragraph(text: str, mark: str = "") -> str:
    """Return a paragraph of the class ``mark``."""
    return f"<p class='{mark}'>{escape(text)}</p>\n" if mark else f"<p>{escape(text)}</p>\n"


def bullets(sentences: Sequence[str]) -> str:
    """Return a bullet list; empty without items."""
    items = "".join(f"<li>{escape(sentence)}</li>\n" for sentence in sentences)
    return f"<ul>\n{items}</ul>\n" if items else ""


def two_widths(wide: str, narrow: str, caption: str) -> str:
    """Return a figure in two widths, of which the page displays the fitting one."""
    return (
        f"<figure><div class='wide'>{wide}</div><div class='narrow'>{narrow}</div>"
        f"<figcaption>{escape(caption)}</figcaption></figure>\n"
    )


def displayed(value: float) -> str:
    """Return a number for display: three digits, with powers of ten for very small or large ones.

    >>> displayed(0.01234), displayed(1.235e-07), displayed(446), displayed(0.0), displayed(2.0)
    ('0.0123', '1.23e-7', '446', '0', '2')
    """
    if value == 0.0:
        return "0"
    if 1e-3 <= abs(value) < 1e5:
        return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"
    mantissa, _, power = f"{value:.2e}".partition("e")
    return f"{mantissa}e{int(power)}"


def cell(value: Any, *, mark: str = "", decimals: int | None = None) -> str:
    """Return one cell: numbers carry their exact value for sorting, texts are plain, None is empty.

    decimals : digits after the point, with infinity displayed; None: as ``displayed``

    >>> cell(-0.001, decimals=2), cell(math.inf, decimals=2), cell(math.inf)
    ('<td data-v="-0.001">0.00</td>', '<td data-v="Infinity">∞</td>', '<td></td>')
    """
    if decimals is not None and value == math.inf:
        return '<td data-v="Infinity">∞</td>'
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return f'<td class="{mark}"></td>' if mark else "<td></td>"
    if isinstance(value, int | float) and not isinstance(value, bool):
        # Rounded first, to avoid −0.00.
        stated = displayed(float(value)) if decimals is None else f"{round(value, decimals) + 0.0:.{decimals}f}"
        return f'<td data-v="{value!r}">{stated}</td>'
    return f'<td class="{mark or "words"}">{escape(str(value))}</td>'


def table(
    caption: str,
    heads: Sequence[str],
    rows: Sequence[Sequence[Any]],
    *,
    tall: bool = False,
    wide: Sequence[int] = (),
    decimals: Mapping[int, int] = MappingProxyType({}),
) -> str:
    """Return a sortable table in a scrollable box; ``decimals``: by column."""
    head = "".join(f'<th scope="col"><button type="button">{escape(h)}</button></th>' for h in heads)
    cells = (
        [cell(v, mark="wide" if k in wide else "", decimals=decimals.get(k)) for k, v in enumerate(row)] for row in rows
    )
    body = "".join(f"<tr>{''.join(row)}</tr>\n" for row in cells)
    box = "table tall" if tall else "table"
    return (
        f'<div class="{box}" tabindex="0"><table class="sortable"><caption>{escape(caption)}</caption>'
        f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>\n"
    )
