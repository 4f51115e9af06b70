"""ICC profiles: only their names are read."""

from __future__ import annotations

import struct

_MOST_TAGS = 200


def profile_name(profile: bytes) -> str:
    """Return an ICC profile's description (ICC.1:2022, 9.2.41): "unnamed" if it has none, empty without a profile.

    >>> profile_name(b"")
    ''
    """
    if not profile:
        return ""
    if len(profile) < 132:
        return "unnamed"
    (count,) = struct.unpack_from(">I", profile, 128)
    for k in range(min(count, _MOST_TAGS)):
        if 144 + 12 * k > len(profile):
            break
        name, at, size = struct.unpack_from(">4sII", profile, 132 + 12 * k)
        if name == b"desc":
            return _text(profile[at : at + min(size, 4096)]) or "unnamed"
    return "unnamed"


def _text(tag: bytes) -> str:
    """Return the text of a description, of version 2 (ASCII) or 4 (UTF-16 of several languages)."""
    if tag[:4] == b"desc" and len(tag) > 12:
        (length,) = struct.unpack_from(">I", tag, 8)
        return tag[12 : 12 + min(length, 1024)].rstrip(b"\0").decode("latin-1").strip()
    if tag[:4] == b"mluc" and len(tag) >= 28:
        length, at = struct.unpack_from(">II", tag, 20)
        return tag[at : at + min(length, 1024)].decode("utf-16-be", "replace").strip()
    return ""
