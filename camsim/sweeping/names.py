"""How files of a study are called: a template with the index and the keys that vary."""

from __future__ import annotations

import os
import string
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from camsim.errors import InvalidValueError
from camsim.files import check_output
from camsim.files.naming import split_product
from camsim.frame import Product

_ALWAYS = ("index", "frame", "scene")


@dataclass(frozen=True, slots=True)
class Template:
    """A file's name with fields in braces, such as ``iso{exposure_iso}/{index:05d}.dng``."""

    text: str
    product: Product
    keys: tuple[str, ...]

    @classmethod
    def of(cls, text: str, keys: Iterable[str]) -> Template:
        """Judge FILE[:PRODUCT]; ``keys``: those that vary, whose dots are underscores here."""
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
        values = {field_of(key): settings.get(key, "as-it-is") for key in self.keys}
        width = len(str(frames - 1))
        many = f"-{frame:0{width}d}" if frames > 1 else ""
        try:
            return self.text.format(index=index, frame=frame, scene=scene, frame_if_many=many, **values)
        except (ValueError, TypeError) as error:
            raise InvalidValueError(f"{self.text!r}: {error}", key="files") from None


def field_of(key: str) -> str:
    """Return a key as a field of a template and as a column of the manifest has its name.

    >>> field_of("lens.f_number")
    'lens_f_number'
    """
    return key.replace(".", "_")
