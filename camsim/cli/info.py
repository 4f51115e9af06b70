"""``camsim info``: the metadata of camsim files and of cameras' raw files."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from camsim.camera.description import CUSTOM_STAGES
from camsim.config.yaml_text import yaml_text
from camsim.core.arrays import I64
from camsim.core.memory import readable
from camsim.files.reading import Held, opened, read_file, read_record
from camsim.sensor.companding import stated_points

_MOST_DISPLAYED = 100
"""Most items of a list in text output; --json prints all."""
_SHORT_LIST, _MOST_STAGES, _LONGEST_SENTENCE = 4, 12, 400


def text_of_file(path: str, *, full: bool = False) -> str:
    """Return the figures of a file and, if ``full``, the description of all stages as YAML; long lists truncated."""
    if _is_cameras(path):
        tree = _tree_of_camera(path)
        width = max(map(len, tree))
        return "\n".join(f"{label:<{width}}  {_stated(value)}" for label, value in tree.items())
    held = read_file(path)
    rows = [*_figures(held), *(() if full else _summary(held.description))]
    width = max(len(label) for label, _ in rows)
    lines = [f"{label:<{width}}  {value}" for label, value in rows]
    if not full:
        return "\n".join(
            [*lines, "", "every stage and parameter: --full, for programs --json; the same picture: camsim recapture"]
        )
    return "\n".join(lines) + f"\n\ncomputed:\n{_indented(yaml_text(_flat(held.description)))}"


def json_of_file(path: str) -> str:
    """Return the same as JSON, complete."""
    if _is_cameras(path):
        return json.dumps(_tree_of_camera(path), indent=2, ensure_ascii=False)
    held = read_file(path)
    tree = {
        "file": str(held.path),
        "format": held.form,
        "rows": held.rows,
        "cols": held.cols,
        "bytes": held.size_bytes,
        "fits_record": held.fits,
        **held.record.as_dict(),
    }
    return json.dumps(tree, indent=2, ensure_ascii=False)


def _is_cameras(path: str) -> bool:
    """Whether a file is a camera's raw file, not of camsim."""
    from camsim.measure.libraw import SUFFIXES

    suffix = Path(path).suffix.lower()
    if suffix != ".dng":
        return suffix in SUFFIXES
    with opened(path) as (file, size):
        return read_record(file, size) is None


def _tree_of_camera(path: str) -> dict[str, Any]:
    """Return content and metadata of a camera's raw file; absent values are omitted."""
    from camsim.measure.libraw import CHANGED, read_noted
    from camsim.measure.reading import read_picture

    picture = read_picture(path)
    noted = picture.noted or read_noted(Path(path))
    said, table = dataclasses.asdict(noted), noted.linear_dn
    del said["linear_dn"]
    levels = {plane.name: plane for plane in picture.planes}
    step = picture.planes[0].step
    places = {plane.first: plane.name[0] for plane in picture.planes}
    stated = {
        "file": path,
        "bytes": Path(path).stat().st_size,
        **{name: value for name, value in said.items() if value not in (None, "", ())},
        **({"codes": f"{len(table)}, which stand for the data numbers {table[0]} to {max(table)}"} if table else {}),
        "rows": picture.shape[0],
        "cols": picture.shape[1],
        "channels": list(levels),
        "filters": ["".join(places.get((row, col), "?") for col in range(step[1])) for row in range(step[0])],
        "black_dn": [plane.black for plane in levels.values()],
        "white_dn": [plane.white for plane in levels.values()],
    }
    return stated if Path(path).suffix.lower() == ".dng" else {**stated, "read": CHANGED}


def _stated(value: Any) -> str:
    """Return numbers, texts and rows of them in one line."""
    if isinstance(value, list | tuple):
        return ("; " if value and isinstance(value[0], tuple) else ", ").join(map(_stated, value))
    if isinstance(value, float):
        return f"{value:.6g}"
    return _printable(str(value), _LONGEST_SENTENCE)


def _figures(held: Held) -> list[tuple[str, str]]:
    record = held.record
    black_dn = record.black_level_dn + np.array(record.black_offsets_dn)
    channels, pattern = _printable(", ".join(record.channels)), _printable(" / ".join(record.cfa_pattern))
    error, one = record.error_estimate, record.description.get(CUSTOM_STAGES)
    alone = f"no, it was taken with custom stages: {_printable(', '.join(map(str, one)))}" if one else "yes"
    whole = "whole: it fits its checksum"
    if image := _part(record.description, "image"):
        source = _printable(str(image.get("source") or ""))
        alone = f"with the light {source}" if source else "no, its light was an array in Python"
    if not held.fits:
        described = " × ".join(map(str, record.size or ()))
        alone = f"no, its record describes {described} photosites"
        whole = f"{whole}, but is not of this image: another program cut or scaled it"
    return [
        ("file", f"{held.path} ({held.form}, {readable(held.size_bytes)})"),
        ("product", f"{held.product}, {held.rows} × {held.cols}"),
        ("camera", _printable(record.camera)),
        ("channels", f"{channels}; colour filters {pattern}"),
        ("levels", f"black {_levels(black_dn)} DN, white {_levels(record.white_levels_dn)} DN"),
        *((("codes", f"companded: {stated_points(record.companding)}"),) if record.companding else ()),
        ("gain", f"{record.electrons_per_dn:.6g} e⁻ per DN"),
        ("seed", str(record.seed)),
        ("error", "unknown" if error is None else f"{error:.2g} of a perfect diffuser"),
        ("written by", _printable(record.software)),
        ("reproducible", alone),
        ("record", whole),
    ]


def _summary(description: Any) -> list[tuple[str, str]]:
    """Return the stages in a line each, from light to accuracy; absent ones are omitted."""
    camera, scene = _part(description, "camera"), _part(description, "scene")
    optics = [_part(camera, "lens"), *_parts(camera, "extra_optics"), _part(camera, "olpf"), _part(camera, "photosite")]
    accuracy = f"tolerance {_word(description.get('tolerance'))}, method {_word(description.get('method'))}"
    shapes = scene.get("shapes")
    number = len(shapes) if isinstance(shapes, list) else 0
    rows = [
        ("scene", f"{number} shape{'' if number == 1 else 's'}, background {_word(scene.get('background'))}"),
        ("light", _stage(description.get("light"))),
        ("exposure", _stage(description.get("exposure"))),
        ("window", (_stage(description.get("region")) or "the whole frame") + _of_frame(camera)),
        ("noise", "on" if description.get("noise") is True else "off"),
        ("computed", accuracy),
    ]
    if image := _part(description, "image"):
        given = f"{_word(image.get('unit'))} of {_word(image.get('source')) or 'an array in Python'}, without a lens"
        rows = [("scene", given), *rows[1:-1]]
    stated = {label: _printable(value) for label, value in rows}
    stated["optics"], stated["custom stages"] = _in_turn(optics), _in_turn(_parts(camera, "extra_stages"))
    order = ("scene", "light", "optics", "exposure", "window", "noise", "custom stages", "computed")
    return [(label, stated[label]) for label in order if stated.get(label)]


def _of_frame(camera: Mapping[str, Any]) -> str:
    """Return the frame of a window, with the pitch: the sensor's name may mention another."""
    if not camera.keys() >= {"rows", "cols", "pitch_um"}:
        return ""
    rows, cols, pitch_um = (_word(camera[key]) for key in ("rows", "cols", "pitch_um"))
    return f" of {rows} × {cols} photosites of {pitch_um} µm"


def _part(tree: Any, key: str) -> Mapping[str, Any]:
    part = tree.get(key) if isinstance(tree, Mapping) else None
    return part if isinstance(part, Mapping) else {}


def _parts(tree: Mapping[str, Any], key: str) -> list[Mapping[str, Any]]:
    parts = tree.get(key)
    return [part for part in parts if isinstance(part, Mapping)] if isinstance(parts, list) else []


def _in_turn(stages: list[Mapping[str, Any]]) -> str:
    """Return the present stages, abbreviated."""
    stated = [_printable(_stage(stage)) for stage in stages if stage]
    return " → ".join([*stated[:_MOST_STAGES], *(["…"] if len(stated) > _MOST_STAGES else [])])


def _stage(tree: Any) -> str:
    """Return a stage as ``Airy(f_number=8)``; absent parameters omitted, tables as sizes."""
    if not isinstance(tree, Mapping):
        return ""
    given = [(key, value) for key, value in tree.items() if key != "kind" and value not in (None, 0, [])]
    words = [
        f"{key}: {_size(value)}" if isinstance(value, list) and not _is_short(value) else f"{key}={_word(value)}"
        for key, value in given
    ]
    return f"{_word(tree.get('kind'))}({', '.join(words)})"


def _size(table: Any) -> str:
    """Return the shape of a table, from its first items."""
    return f"{len(table)}{f' × {_size(table[0])}' if isinstance(table[0], list) and table[0] else ''}"


def _is_short(values: list[Any]) -> bool:
    return len(values) <= _SHORT_LIST and not any(isinstance(value, list | Mapping) for value in values)


def _word(value: Any) -> str:
    if isinstance(value, Mapping):
        return str(value.get("name") or value.get("kind"))
    return f"{value:g}" if isinstance(value, float) else str(value)


def _levels(levels_dn: I64) -> str:
    return _printable(" / ".join(", ".join(map(str, row)) for row in levels_dn.tolist()))


def _printable(text: str, most: int = _MOST_DISPLAYED) -> str:
    """Return untrusted text in one line without control sequences."""
    displayed = text if len(text) <= most else f"{text[:most]}…"
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in displayed)


def _flat(tree: Any) -> Any:
    """Return the tree with each table of numbers (a curve's, say) as one line, and long lists truncated."""
    if isinstance(tree, dict):
        return {key: _flat(value) for key, value in tree.items()}
    if isinstance(tree, list):
        rest = len(tree) - _MOST_DISPLAYED
        if len(tree) > 12 and all(isinstance(value, int | float) for value in tree):
            return ", ".join(f"{value:.6g}" for value in tree)
        return [_flat(value) for value in tree[:_MOST_DISPLAYED]] + ([f"… and {rest} more"] if rest > 0 else [])
    return tree


def _indented(text: str) -> str:
    return "".join(f"  {line}\n" for line in text.splitlines()).rstrip()
