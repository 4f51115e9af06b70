"""Advice for pictures and folders given in place of a YAML file: a scene that shows them, to be pasted."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Iterator
from pathlib import Path

from camsim.errors import CamsimError

_RAW = (".dng", ".nef", ".cr2", ".cr3", ".arw", ".raf", ".rw2", ".orf", ".pef", ".raw")
_NOT_READ = (".webp", ".heic", ".heif", ".avif", ".gif", ".bmp", ".jp2", ".psd")
# Of the sensor that the scene names; a photograph shrunk to half has what its own demosaicing and compression left.
_SENSOR, _FRAME, _SHARE = "d40-like", (2000, 3008), 0.5
_TEXT = """\
camsim: scene/1
sensor: {sensor}
lens: {{kind: airy, f_number: 4}}
light: {{illuminant: D65, illuminance_lux: 2000}}       # the white of sRGB
exposure: {{time_s: auto, iso: 200}}
region: {{rows: {rows}, cols: {cols}}}
scene:
  unit: pixel
  background: {{reflectance: 0.18}}
  shapes:                                             # sample: side of one of {width} × {height}, in photosites
    - {{kind: picture, file: {file}, sample: {sample:g}}}
render: {{tolerance: 1.0e-3}}
noise: {{enabled: true, seed: 1}}
"""


def is_picture(path: Path) -> bool:
    """Whether a file's name is one of a picture that can be in a scene."""
    from camsim.files.picture_samples import READERS

    return path.suffix.lower() in READERS


def scene_of(picture: Path, folder: Path) -> str:
    """Return a scene that shows a picture, for a file in ``folder``; raises CamsimError if impossible.

    A photosite has two samples a side, or more if the picture would exceed the sensor; the window lies inside.
    """
    from camsim.files.picture_samples import read_samples
    from camsim.files.reading import opened

    if not picture.resolve().is_relative_to(folder.resolve()):
        raise CamsimError(
            f"{str(picture)!r} lies outside {str(folder)!r}, the scene's folder; write the scene beside the picture, "
            f"with -o {picture.with_suffix('.yaml')}"
        )
    with opened(str(picture)) as (file, size):
        height, width = read_samples(picture, file, size).samples.shape[:2]
    share = float(f"{min(_SHARE, 0.999 * _FRAME[0] / height, 0.999 * _FRAME[1] / width):.3g}")
    rows, cols = (max(2, int(share * count) // 2 * 2) for count in (height, width))
    name = Path(os.path.relpath(picture.resolve(), folder.resolve())).as_posix()
    quoted = json.dumps(name, ensure_ascii=False)
    return _TEXT.format(sensor=_SENSOR, rows=rows, cols=cols, width=width, height=height, file=quoted, sample=share)


def way_out_of(path: Path) -> str:
    """Return a text on a path that is not YAML: what it is, and what to give instead; empty if unknown."""
    if path.is_dir():
        return _of_folder(path)
    suffix = path.suffix.lower()
    if suffix in _RAW:
        return (
            "is a camera's picture, not a YAML file; camsim info says what one of camsim's was taken of, and camsim "
            "recapture takes it again"
        )
    if suffix in _NOT_READ:
        return f"is a picture of a kind that is not read; save it as PNG or TIFF, then {_new(path.with_suffix('.png'))}"
    if not is_picture(path):
        return ""
    try:
        scene = scene_of(path, path.parent)
    except CamsimError as error:
        return f"is a picture, not a YAML file, and cannot be read: {error}"
    return f"is a picture, not a YAML file; a scene that shows it, which {_new(path)} writes:\n\n{scene}"


def _of_folder(folder: Path) -> str:
    pictures = sorted(_pictures(folder))
    if not pictures:
        return "is a folder; name a file in it"
    pattern = (Path(folder.name) / f"*{pictures[0].suffix}").as_posix()
    return (
        f"is a folder, of {len(pictures)} pictures; {_new(pictures[0])} makes a scene of one, and camsim dataset takes "
        "all of them by a file beside the folder, as docs/howto/photographs.md says:\n\n"
        "camsim: dataset/1\n"
        f"scene: scene.yaml                  # {_new(pictures[0])} -o scene.yaml\n"
        "set: {region: {rows: 128, cols: 128}}\n"
        f'vary: {{scene.shapes.0.file: {{glob: "{pattern}"}}}}\n'
        "crops: {rows: 64, cols: 64, each: 4}\n"
    )


def _pictures(folder: Path) -> Iterator[Path]:
    for path in folder.iterdir():
        if path.is_file() and is_picture(path):
            yield path


def _new(picture: Path) -> str:
    return f"camsim new scene --picture {shlex.quote(str(picture))}"
