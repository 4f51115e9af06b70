"""Raw files as camera makers write them, from their published structures: TIFF with sub-directories, and Fuji's own."""

import struct
from pathlib import Path
from typing import Any

import numpy as np

_SIZES = {"B": 1, "A": 2, "H": 3, "I": 4, "R": 5, "U": 7}
Tags = dict[int, tuple[str, Any]]


def _entry(order: str, kind: str, values: Any) -> tuple[int, int, bytes]:
    if kind in "AU":
        data = values.encode() + b"\0" if isinstance(values, str) else bytes(values)
        return _SIZES[kind], len(data), data
    each = list(values) if isinstance(values, list | tuple | bytes) else [values]
    if kind == "R":
        parts = [part for value in each for part in (round(value * 10_000), 10_000)]
        return 5, len(each), struct.pack(f"{order}{len(parts)}I", *parts)
    return _SIZES[kind], len(each), struct.pack(f"{order}{len(each)}{kind}", *each)


def _directory(order: str, tags: Tags, at: int) -> bytes:
    """A directory that lies at a place, its values behind it."""
    entries, values = b"", b""
    behind = at + 2 + 12 * len(tags) + 4
    for number, (kind, given) in sorted(tags.items()):
        code, count, data = _entry(order, kind, given)
        if len(data) > 4:
            data, values = struct.pack(order + "I", behind + len(values)), values + data + b"\0" * (len(data) % 2)
        entries += struct.pack(order + "HHI", number, code, count) + data.ljust(4, b"\0")
    return struct.pack(order + "H", len(tags)) + entries + struct.pack(order + "I", 0) + values


def tiff_raw(
    path: Path,
    data: bytes,
    raw: Tags,
    *,
    make: str,
    model: str,
    magic: bytes = b"II*\0",
    exif: Tags | None = None,
    below: bool = True,
    first: Tags | None = None,
    strip: tuple[int, int] = (273, 279),
) -> None:
    """A raw file in TIFF's form: maker and model first, the mosaic in a sub-directory (or in the first itself)."""
    order = "<" if magic[:2] == b"II" else ">"
    out = bytearray(magic + bytes(4))
    at_data = len(out)
    out += data + b"\0" * (len(data) % 2)
    raw = {**raw, strip[0]: ("I", at_data), strip[1]: ("I", len(data))}
    noted = exif or {33434: ("R", 0.008), 33437: ("R", 5.6), 34855: ("H", 400), 37386: ("R", 50.0)}
    at_exif = len(out)
    out += _directory(order, noted, at_exif)
    main: Tags = {271: ("A", make), 272: ("A", model), 274: ("H", 1), 34665: ("I", at_exif), **(first or {})}
    if below:
        at_raw = len(out)
        out += _directory(order, raw, at_raw)
        main[330] = ("I", at_raw)
    else:
        main |= raw
    out[4:8] = struct.pack(order + "I", len(out))
    out += _directory(order, main, len(out))
    path.write_bytes(bytes(out))


def mosaic_tags(codes: np.ndarray, bits: int, compression: int = 1) -> Tags:
    rows, cols = codes.shape
    return {
        254: ("I", 0), 256: ("I", cols), 257: ("I", rows), 258: ("H", bits), 259: ("H", compression),
        262: ("H", 32803), 277: ("H", 1), 278: ("I", rows), 284: ("H", 1), 33421: ("H", (2, 2)),
        33422: ("B", bytes((0, 1, 1, 2))),
    }  # fmt: skip


X_TRANS = ("GBGGRG", "RGRBGB", "GBGGRG", "GRGGBG", "BGBRGR", "GRGGBG")


def fuji_raw(path: Path, codes: np.ndarray, pattern: tuple[str, ...] = X_TRANS) -> None:
    """A RAF: offsets in its head, EXIF in a JPEG, a list of sizes and filters, and the codes in 16 bits."""
    noted: Tags = {33434: ("R", 0.008), 33437: ("R", 5.6), 34855: ("H", 400), 37386: ("R", 50.0)}
    main: Tags = {271: ("A", "FUJIFILM"), 272: ("A", "X-T1"), 34665: ("I", 0)}
    start = 8 + len(_directory("<", main, 8))
    main[34665] = ("I", start)
    exif = b"Exif\0\0II*\0" + struct.pack("<I", 8) + _directory("<", main, 8) + _directory("<", noted, start)
    jpeg = b"\xff\xd8\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + b"\xff\xd9"
    rows, cols = codes.shape
    letters = bytes("RGB".index(letter) for letter in reversed("".join(pattern)))
    each = [(0x100, struct.pack(">HH", rows, cols)), (0x121, struct.pack(">HH", rows, cols)), (0x131, letters)]
    sizes = struct.pack(">I", len(each)) + b"".join(struct.pack(">HH", tag, len(data)) + data for tag, data in each)
    head = b"FUJIFILMCCD-RAW 0201FF383501" + b"X-T1".ljust(32, b"\0") + b"0100".ljust(24, b"\0")
    at = 160
    offsets = struct.pack(">6I", at, len(jpeg), at + len(jpeg), len(sizes), at + len(jpeg) + len(sizes), 2 * codes.size)
    path.write_bytes((head + offsets).ljust(at, b"\0") + jpeg + sizes + codes.astype("<u2").tobytes())
