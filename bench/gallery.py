"""Every shipped scene as a picture, with its file and its twin in Python: ``make gallery``."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import camsim
from camsim.api import load
from camsim.config import library

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "gallery"
PAGE = ROOT / "docs" / "gallery.md"
ROWS, COLS = 320, 480  # of a picture, at most: the middle of larger scenes


def sentence_of(text: str) -> str:
    """The comment that a scene begins with."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.removeprefix("#").strip())
    return " ".join(lines)


def window_of(name: str) -> list[str]:
    """What takes no more than the middle of a large scene."""
    region = load(name).region
    camera = load(name).camera
    rows, cols = (region.rows, region.cols) if region else (camera.rows, camera.cols)
    if rows <= ROWS and cols <= COLS:
        return []
    return [f"region={{rows: {min(rows, ROWS)}, cols: {min(cols, COLS)}}}"]


def take(name: str) -> float:
    """Write the picture of a scene; return how long it took."""
    began = time.perf_counter()
    frame = camsim.capture(name, overrides=window_of(name), products=("mosaic", "preview"))
    camsim.save(frame, PICTURES / f"{name}.png", force=True)
    return time.perf_counter() - began


def section(name: str) -> list[str]:
    """A scene's part of the page."""
    scene = library.shipped("scene")[name]
    text = scene.read_text(encoding="utf-8")
    cut = " The picture shows its middle." if window_of(name) else ""
    body = "\n".join(line for line in text.splitlines() if not line.startswith("#"))
    return [
        *(f"## {name}", "", sentence_of(text) + cut, ""),
        *(f"![{name}](gallery/{name}.png)", ""),
        *("```yaml", body.strip(), "```", ""),
        *(f"```{{literalinclude}} ../scenes/{name}.py", ":language: python", ":lines: 3-", "```", ""),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="only these; all when left out")
    parser.add_argument("--page", action="store_true", help="write the page only")
    chosen = parser.parse_args()
    PICTURES.mkdir(exist_ok=True)
    names = list(library.shipped("scene"))
    for name in [] if chosen.page else chosen.names or names:
        print(f"{name:20} {take(name):6.1f} s", flush=True)
    lines = [
        "# Gallery",
        "",
        "Every scene that camsim ships, as `camsim capture NAME -o NAME.png` develops it, with its file and its twin",
        "in Python: `scenes/NAME.yaml` and `scenes/NAME.py` give the same bytes. Written by `make gallery`.",
        "",
        *(f'<a href="#{name}"><img src="gallery/{name}.png" alt="{name}" width="110"></a>' for name in names),
        "",
    ]
    for name in names:
        lines += section(name)
    PAGE.write_text("\n".join(lines).rstrip("\n") + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
