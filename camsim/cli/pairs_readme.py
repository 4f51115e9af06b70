"""The README of a folder of pairs: its files and their units."""

from __future__ import annotations

from collections.abc import Iterable

from camsim.camera.capture import Capture
from camsim.files.describe import software

_COLUMNS = {
    "noisy": ("file", "the mosaic as the camera records it, in data numbers (DN)"),
    "clean": ("file", "the same without noise: mean electrons through the converter, in DN"),
    "truth": ("file", "mean electrons of every channel at every photosite, before noise and converter, in e⁻, 32-bit"),
    "cfa": ("letters", "colour filters from the top left photosite on, rows parted by /"),
    "origin_row": ("photosites", "row of the sensor's frame in which the window begins"),
    "origin_col": ("photosites", "column of the sensor's frame in which the window begins"),
    "rows": ("photosites", "from top to bottom"),
    "cols": ("photosites", "from left to right"),
    "level": ("–", "light relative to the scene's own exposure"),
    "time_s": ("s", "exposure time"),
    "iso": ("–", "ISO setting"),
    "seed": ("–", "of the noise"),
    "black_level_dn": ("DN", "code of no light"),
    "black_offsets_dn": ("DN", "added to it: rows of a rectangle that repeats from the top left photosite on"),
    "white_level_dn": (
        "DN",
        "code at which a photosite is full; black_offsets_dn are added to it, as far as there are codes",
    ),
    "electrons_per_dn": ("e⁻/DN", "electrons = (code − black_level_dn − black_offsets_dn) · electrons_per_dn"),
    "clips_at_e": ("e⁻", "mean electrons at which a photosite is full"),
    "description_sha256": ("–", "of all stages and parameters, as the files carry them"),
}

_NOTES = """\
* PHASE is the colour filters of photosites (0,0) (0,1) (1,0) (1,1), such as GRBG. With `from-row1`, `from-col1` or both
  the window begins one row or column later in the frame: the scene lies one photosite further up or left, and the
  sensor's own array has that phase there. Without, the array itself is exchanged and the scene lies still.
* LEVEL is the light relative to the scene's exposure: x0.25 is two stops less.
* All three are on one grid: photosite (row, col) of the mosaic is pixel (row, col) of the truth.
* Where the truth's own channel is above clips_at_e the mosaic is clipped."""
_COMPANDED = """\
* Codes are companded. All levels, and the formula for electrons, are of data numbers, which DNGs have in their
  LinearizationTable: raw programs, and camsim, read those."""
_BENT = "; as read: the read-out is not linear, and the light's are others"


def readme(capture: Capture, columns: Iterable[str]) -> str:
    """Return the page; ``columns``: of the index."""
    camera = capture.camera
    lines = [
        f"# Pairs of {capture.scene_name}, taken with {camera.name}",
        "",
        f"Written by {software()}. Each row of `index.csv` (`index.json` holds the same) is one picture in 3 files:",
        "",
        "    NUMBER-PHASE-xLEVEL-noisy.dng    codes with noise, DN",
        "    NUMBER-PHASE-xLEVEL-clean.dng    codes without noise, DN",
        f"    NUMBER-PHASE-xLEVEL-truth.exr    electrons of {', '.join(camera.cfa.channels)} at every photosite, e⁻",
        "",
        "(`.tiff` in place of `.dng` where raw developers would misread the filter array.)",
        "",
        *_NOTES.splitlines(),
        *(_COMPANDED.splitlines() if camera.converter.companding else ()),
        "",
        "| column | unit | meaning |",
        "|---|---|---|",
    ]
    for name in columns:
        channel = name.removeprefix("neutral_")
        unit, meaning = _COLUMNS.get(
            name, ("–", f"white balance: what a perfect diffuser gives {channel}, the largest 1")
        )
        bent = _BENT if name == "electrons_per_dn" and camera.nonlinearity is not None else ""
        lines.append(f"| `{name}` | {unit} | {meaning}{bent} |")
    return "\n".join(lines) + "\n"
