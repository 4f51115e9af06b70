"""Metadata in every file: a reproducible text description of the computation."""

from __future__ import annotations

import functools
import hashlib
import json
import math
import unicodedata
from typing import Any

import numpy as np

from camsim.camera.frame import Frame
from camsim.errors import OutputError

RECORD_FORMAT = "frame/1"
"""Name and version of the record format."""

XMP_NAMESPACE = "urn:camsim:frame/1/"
"""XML namespace of camsim's properties in XMP."""


def description_json(frame: Frame) -> str:
    """Return the whole description as compact ASCII JSON, keys sorted: equal captures give equal text."""
    return canonical(dict(frame.description))


def description_hash(frame: Frame) -> str:
    """SHA-256 of :func:`description_json`: equal for captures of equal configuration."""
    return checksum(description_json(frame))


def record(frame: Frame, product: str) -> dict[str, Any]:
    """Return the record of a file: the description, and the figures that explain the values.

    ``sha256`` is the checksum of the rest, by which a reader detects changes.
    """
    said = {
        "camsim": RECORD_FORMAT,
        "software": software(),
        "product": product,
        "camera": frame.camera_name,
        "channels": list(frame.channels),
        "cfa_pattern": list(frame.cfa_pattern),
        "black_level_dn": frame.black_level_dn,
        "black_offsets_dn": [list(row) for row in frame.black_offsets_dn],
        "white_level_dn": frame.white_level_dn,
        "electrons_per_dn": frame.electrons_per_dn,
        "seed": frame.seed,
        "error_estimate": _error(frame, product),
        "description_sha256": description_hash(frame),
        "description": dict(frame.description),
    }
    return {**said, "sha256": checksum(canonical(said))}


def record_json(frame: Frame, product: str) -> str:
    """Return :func:`record` as compact ASCII JSON."""
    return canonical(record(frame, product))


def checksum(text: str) -> str:
    """Return the SHA-256 of ASCII text as hexadecimal digits."""
    return hashlib.sha256(text.encode("ascii")).hexdigest()


@functools.cache
def software() -> str:
    """Return the program's name and version, such as ``camsim 0.1.0``; a bare checkout has no version."""
    from importlib import metadata

    try:
        return f"camsim {metadata.version('camsim-spectral')}"
    except metadata.PackageNotFoundError:
        return "camsim"


def error_text(frame: Frame, product: str) -> str:
    """Return the estimated error of the rendering, such as ``3.2e-07``, or the word unknown."""
    error = _error(frame, product)
    return "unknown" if error is None else f"{error:.2g}"


def exif_datetime(frame: Frame) -> str:
    """Return the exposure's date as EXIF writes it, ``2000:01:01 00:00:00``."""
    return frame.datetime.replace("-", ":")


def ascii_text(text: str) -> str:
    """Return the nearest ASCII, for ASCII-only tags.

    >>> ascii_text("D40-like, 4.88 µm – é")
    'D40-like, 4.88 um - e'
    """
    plain = text.translate({ord("µ"): "u", ord("μ"): "u", ord("–"): "-", ord("—"): "-", 0: " "})
    return unicodedata.normalize("NFKD", plain).encode("ascii", "ignore").decode("ascii").strip()


def _error(frame: Frame, product: str) -> float | None:
    """Return the error estimate for the product of a file; the truth has a separate one.

    In thousandths of the tolerance, at least one, to two digits: finer digits differ between processors.
    """
    error = frame.report.truth_error_estimate if product == "truth" else frame.report.error_estimate
    if error is None or not math.isfinite(error):
        return None
    thousandth = 1e-3 * frame.report.tolerance
    if thousandth == 0.0:  # given light has no error
        return 0.0
    return float(f"{max(round(error / thousandth), 1) * thousandth:.2g}")


def canonical(tree: Any) -> str:
    """Return a tree as compact ASCII JSON, keys sorted: equal trees give equal text."""
    try:
        return json.dumps(
            tree, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False, default=_plain
        )
    except ValueError:
        raise OutputError("what the file would say of itself holds a number that is not finite") from None


def _plain(value: Any) -> Any:
    """Turn numpy's numbers and arrays into Python's."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"a description holds plain values only, not {type(value).__name__}")
