"""Names of a study's files: a template with the index and the varying keys."""

from __future__ import annotations

import os
import re
import string
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from camsim.camera.frame import Product
from camsim.errors import InvalidValueError
from camsim.files import check_output
from camsim.files.naming import split_product

_ALWAYS = ("index", "frame", "scene")


@dataclass(frozen=True, slots=True)
class Template:
    """A file's name with fields in braces, such as ``iso{exposure_iso}/{index:05d}.dng``."""

    text: str
    product: Product
    keys: tuple[str, ...]

    @classmethod
    def of(cls, text: str, keys: Iterable[str]) -> Template:
        """Validate FILE[:PRODUCT]; ``keys``: those that vary, with underscores for dots."""
        path, product = split_product(text)
        known = (*_ALWAYS, *(field_of(key) for key in keys))
        try:
            fields = [field for _, field, _, _ in string.Formatter().parse(path) if field is not None]
        except ValueError as error:
            raise InvalidValueError(f"{text!r}: {error}; write fields as {{index}}", key="files") from None
        for field in fields:
            if field not in known:
                raise InvalidValueError(f"{text!r}: no field {{{field}}}; there are {', '.join(known)}", key="files")
        if os.path.isabs(path) or ".." in PurePosixPath(path).parts:
            raise InvalidValueError(f"{text!r} leads out of the folder; name files under it", key="files")
        template = cls(path, check_output(PurePosixPath(path).name, product), tuple(keys))
        if "frame" not in fields:
            stem, suffix = os.path.splitext(path)
            template = cls(stem + "{frame_if_many}" + suffix, template.product, template.keys)
        return template

    def name(self, *, index: int, frame: int, frames: int, scene: str, settings: Mapping[str, Any]) -> str:
        """Return the file's name for one frame of a capture."""
        values = {field_of(key): _in_a_name(settings.get(key, "as-it-is")) for key in self.keys}
        width = len(str(frames - 1))
        many = f"-{frame:0{width}d}" if frames > 1 else ""
        try:
            return self.text.format(**values | {"index": index, "frame": frame, "scene": scene, "frame_if_many": many})
        except (ValueError, TypeError) as error:
            raise InvalidValueError(f"{self.text!r}: {error}", key="files") from None


def _in_a_name(value: Any) -> Any:
    """Return a value in a form valid in file names on every system; numbers are unchanged, for their formats.

    >>> _in_a_name({"kind": "four-spot", "split_pitches": 0.75}), _in_a_name("a/b: c"), _in_a_name(None)
    ('kind-four-spot_split_pitches-0.75', 'a-b-c', 'none')
    """
    if value is None:
        return "none"
    if isinstance(value, Mapping):
        return "_".join(f"{key}-{_in_a_name(one)}" for key, one in value.items())
    if isinstance(value, list | tuple):
        return "_".join(str(_in_a_name(one)) for one in value)
    return re.sub(r"[^\w.+-]+", "-", value).strip("-") if isinstance(value, str) else value


def columns_of(key: str, value: Any) -> dict[str, Any]:
    """Return the manifest's columns of a varying key: the value, and if that is a table, each of its values.

    >>> columns_of("sensor.olpf", {"kind": "four-spot", "split_um": 3.0})["sensor_olpf_split_um"]
    3.0
    """
    columns = {field_of(key): value}
    if isinstance(value, Mapping):
        for name, one in value.items():
            columns |= columns_of(f"{key}.{name}", one)
    return columns


def field_of(key: str) -> str:
    """Return a key as the name of a template's field and a manifest's column.

    >>> field_of("lens.f_number")
    'lens_f_number'
    """
    return key.replace(".", "_")
