"""Files as an enemy would change them: bytes, fields of every format with their checksums mended, records.

Every mutation is drawn from the generator that is given, and nothing else.
"""

from __future__ import annotations

import copy
import io
import json
import struct
import zipfile
import zlib
from collections.abc import Callable
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from camsim.files.describe import canonical, checksum

EXTREMES = (0, 1, 2, 3, 255, 256, 0x7FFF, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
WRONG: tuple[Any, ...] = (
    None, True, -1, 0, 1, 2**31, 2**63, 10**19, -1e300, 1e300, 1e-300, 5e-324, 0.5, -0.0,
    "", "x", "RGGB", "a\n\x1b[31m", "\ud800", [], [[]], [0], [1, 2], [None], {}, {"a": 1},
    {"kind": "Airy"}, {"kind": "Path"}, {"kind": ["Airy"]}, {"kind": "Frame"}, {"kind": "Gaussian", "sigma_um": 0},
    {"kind": "Curve", "wavelength_nm": [1], "values": [2]},
)  # fmt: skip


def by_bytes(rng: np.random.Generator, content: bytes) -> bytes:
    """Change, cut out, double a few bytes, exchange some for extreme numbers, or bring others from elsewhere."""
    data = bytearray(content)
    for _ in range(int(rng.integers(1, 6))):
        # Headers are at the beginning and a DNG's directories at the end: most mutations go there.
        reach = len(data) if rng.random() < 0.4 else min(len(data), int(rng.choice([16, 400, 1500, 12000])))
        at = int(rng.integers(0, max(1, reach)))
        if rng.random() < 0.5:
            at = max(0, len(data) - 1 - at)
        how = rng.integers(0, 8)
        if how == 0:
            data[at : at + 1] = bytes([int(rng.integers(0, 256))])
        elif how == 1 and data:
            data[min(at, len(data) - 1)] ^= 1 << int(rng.integers(0, 8))
        elif how == 2:
            data[at : at + 4] = int(rng.choice([*EXTREMES, len(content)])).to_bytes(4, "little")
        elif how == 3:
            del data[at : at + int(rng.integers(1, 200))]
        elif how == 4:
            data = data[:at]
        elif how == 5:
            data[at:at] = data[at : at + int(rng.integers(1, 200))]
        elif how == 6:
            begin, length = int(rng.integers(0, max(1, len(data)))), int(rng.integers(1, 400))
            data[at : at + length] = data[begin : begin + length]
        else:
            data[at:at] = rng.bytes(int(rng.integers(1, 20)))
    return bytes(data)


def _number(rng: np.random.Generator, bits: int) -> int:
    """Return an extreme number, one near one, or any."""
    drawn = int(rng.choice(EXTREMES)) + int(rng.integers(-2, 3)) if rng.random() < 0.7 else int(rng.integers(0, 2**32))
    return drawn % (1 << bits)


def by_tags(rng: np.random.Generator, content: bytes) -> bytes:
    """Change number, type, count or value of entries in a directory of a classic TIFF."""
    data = bytearray(content)
    order = "<" if content[:2] == b"II" else ">"
    (at,) = struct.unpack_from(f"{order}I", data, 4)
    (count,) = struct.unpack_from(f"{order}H", data, at)
    below = [
        struct.unpack_from(f"{order}I", data, entry + 8)[0]
        for entry in range(at + 2, at + 2 + 12 * count, 12)
        if struct.unpack_from(f"{order}H", data, entry)[0] == 330
    ]
    if below and rng.random() < 0.7:
        at = below[0]
        (count,) = struct.unpack_from(f"{order}H", data, at)
    for _ in range(int(rng.integers(1, 4))):
        entry = at + 2 + 12 * int(rng.integers(0, count))
        how = rng.integers(0, 5)
        if how == 0:
            struct.pack_into(
                f"{order}H", data, entry, int(rng.choice([254, 256, 273, 279, 330, 33422, 50712, 50714, 50717]))
            )
        elif how == 1:
            struct.pack_into(f"{order}H", data, entry + 2, int(rng.integers(0, 20)))
        elif how == 2:
            struct.pack_into(f"{order}I", data, entry + 4, _number(rng, 32))
        elif how == 3:
            struct.pack_into(f"{order}I", data, entry + 8, _number(rng, 32))
        else:
            kind, n, value = struct.unpack_from(f"{order}HII", data, entry + 2)
            size = {1: 1, 3: 2, 4: 4, 5: 8, 10: 8, 12: 8}.get(kind, 1)
            place = entry + 8 if size * n <= 4 else value
            if place + size * n <= len(data) and n:
                which = place + size * int(rng.integers(0, n))
                data[which : which + min(size, 4)] = _number(rng, 32).to_bytes(4, "little" if order == "<" else "big")[
                    : min(size, 4)
                ]
    return bytes(data)


def by_chunks(rng: np.random.Generator, content: bytes) -> bytes:
    """Change, drop, double or move chunks of a PNG; their checksums fit."""
    chunks, at = [], 8
    while at < len(content):
        length, kind = struct.unpack_from(">I4s", content, at)
        chunks.append([kind, content[at + 8 : at + 8 + length]])
        at += 12 + length
    for _ in range(int(rng.integers(1, 4))):
        k = int(rng.integers(0, len(chunks)))
        kind, body = chunks[k]
        how = rng.integers(0, 7)
        if how == 0 and len(chunks) > 1:
            del chunks[k]
        elif how == 1:
            chunks.insert(int(rng.integers(0, len(chunks))), [kind, body])
        elif how == 2 and kind == b"IHDR" and len(body) == 13:
            fields = list(struct.unpack(">2I5B", body))
            which = int(rng.integers(0, 7))
            fields[which] = _number(rng, 32 if which < 2 else 8)
            chunks[k][1] = struct.pack(">2I5B", *fields)
        elif how == 3 and kind == b"IDAT":
            try:
                chunks[k][1] = zlib.compress(by_bytes(rng, zlib.decompress(body)))
            except zlib.error:
                chunks[k][1] = by_bytes(rng, body)
        elif how == 4:
            extra = [b"gAMA", b"cHRM", b"PLTE", b"tRNS", b"iCCP", b"sRGB", b"zTXt", b"acTL", b"fcTL", b"eXIf", b"abcd"]
            chunks.insert(k, [extra[int(rng.integers(0, len(extra)))], rng.bytes(int(rng.integers(0, 40)))])
        else:
            chunks[k][1] = by_bytes(rng, body) if body else rng.bytes(4)
    return content[:8] + b"".join(
        struct.pack(">I4s", len(body), kind) + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    )


def by_members(rng: np.random.Generator, content: bytes) -> bytes:
    """Write an NPZ anew with arrays whose headers and numbers are changed, packed or not."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    for _ in range(int(rng.integers(1, 4))):
        name = list(members)[int(rng.integers(0, len(members)))]
        how = rng.integers(0, 5)
        if how == 0:
            members[name] = by_bytes(rng, members[name])
        elif how == 1 and name.endswith(".npy"):
            members[name] = by_array_header(rng, members[name])
        elif how == 2:
            del members[name]
            if not members:
                break
        elif how == 3:
            members[["mosaic.npy", "record.json", "truth.npy", "../x.npy", "a"][int(rng.integers(0, 5))]] = members[
                name
            ]
        elif name.endswith(".npy"):
            members[name] = members[name][: int(rng.integers(0, len(members[name]) + 1))]
    out = io.BytesIO()
    method = int(rng.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA]))
    with zipfile.ZipFile(out, "w", method) as archive:
        for name, body in members.items():
            archive.writestr(name, body)
    return out.getvalue()


def by_array_header(rng: np.random.Generator, content: bytes) -> bytes:
    """Change what an array of numpy's says of itself."""
    if len(content) < 10:
        return content
    (length,) = struct.unpack_from("<H", content, 8)
    text = content[10 : 10 + length].decode("latin-1")
    sizes = [str(_number(rng, 63)) for _ in range(int(rng.integers(0, 4)))]
    new = [
        ("'<u2'", ["'|O'", "'<f8'", "'|V4'", "'>u2'", "'|u1'", "'<f2'", "'<c16'", "'<U9'", "[('a','<u2')]", "'|b1'"]),
        ("'<f8'", ["'|O'", "'<f4'", "'<u2'", "'<i8'"]),
        ("False", ["True", "0", "None"]),
        (text[text.find("(") : text.find(")") + 1], [f"({', '.join(sizes)},)", "()", "(-1, 5)", "(1e9,)", "(" * 500]),
        ("'shape'", ["'shap'", "'shape': (1,), 'shape'"]),
    ]
    old, others = new[int(rng.integers(0, len(new)))]
    text = text.replace(old, others[int(rng.integers(0, len(others)))])
    return content[:8] + struct.pack("<H", len(text)) + text.encode("latin-1") + content[10 + length :]


def exr_attributes(content: bytes) -> tuple[list[tuple[bytes, bytes, bytes]], int]:
    """Return name, type and bytes of each attribute of a file of one part, and where the header ends."""
    found, at = [], 8
    while content[at]:
        name, kind, rest = content[at:].split(b"\0", 2)
        (length,) = struct.unpack_from("<i", rest)
        found.append((name, kind, rest[4 : 4 + length]))
        at += len(name) + len(kind) + 6 + length
    return found, at + 1


def exr_with(content: bytes, attributes: list[tuple[bytes, bytes, bytes]], chunks: int) -> bytes:
    """Return the file with other attributes, its table of chunks moved along."""
    _, end = exr_attributes(content)
    head = (
        content[:8] + b"".join(n + b"\0" + k + b"\0" + struct.pack("<i", len(v)) + v for n, k, v in attributes) + b"\0"
    )
    table = struct.unpack_from(f"<{chunks}Q", content, end)
    moved = struct.pack(f"<{chunks}Q", *(offset + len(head) - end for offset in table))
    return head + moved + content[end + 8 * chunks :]


def by_attributes(rng: np.random.Generator, content: bytes) -> bytes:
    """Change, drop or double attributes of an OpenEXR file; its chunks stay where they are found."""
    attributes, end = exr_attributes(content)
    (first,) = struct.unpack_from("<Q", content, end)
    for _ in range(int(rng.integers(1, 4))):
        one = [
            k
            for k, (name, _, _) in enumerate(attributes)
            if name.startswith((b"data", b"chan", b"comp", b"disp", b"line"))
        ]
        k = int(rng.choice(one)) if one and rng.random() < 0.7 else int(rng.integers(0, len(attributes)))
        name, kind, value = attributes[k]
        how = rng.integers(0, 5)
        if how == 0 and len(attributes) > 1:
            del attributes[k]
        elif how == 1:
            attributes.insert(k, (b"tiles", b"tiledesc", struct.pack("<2IB", _number(rng, 32), _number(rng, 32), 0)))
        elif how == 2 and len(value) >= 4:
            at = 4 * int(rng.integers(0, len(value) // 4))
            attributes[k] = (name, kind, value[:at] + struct.pack("<I", _number(rng, 32)) + value[at + 4 :])
        elif how == 3:
            attributes[k] = (name, [b"int", b"string", b"box2i", b"float"][int(rng.integers(0, 4))], value)
        else:
            attributes[k] = (name, kind, by_bytes(rng, value) if value else b"\0")
    changed = exr_with(content, attributes, (first - end) // 8)
    if rng.random() < 0.2:  # tiled, long names, deep, several parts
        changed = changed[:4] + struct.pack("<I", 2 | int(rng.choice([0x200, 0x400, 0x800, 0x1000]))) + changed[8:]
    return changed


def by_record(rng: np.random.Generator, content: bytes, suffix: str, record: dict[str, Any]) -> bytes:
    """Put another record into a file, changed in some places; its checksum fits."""
    tree = json.loads(json.dumps(record))
    for _ in range(int(rng.integers(1, 3))):
        _change(rng, tree if rng.random() < 0.3 else tree["description"])
        if not isinstance(tree.get("description"), dict):
            break
    return with_record(content, suffix, signed(tree))


def signed(tree: dict[str, Any]) -> str:
    """Return a record as text with a checksum that fits."""
    said = {key: value for key, value in tree.items() if key != "sha256"}
    return canonical({**said, "sha256": checksum(canonical(said))})


def _change(rng: np.random.Generator, tree: Any) -> None:
    """Exchange, drop or add one value, anywhere in a tree."""
    while True:
        keys = list(tree) if isinstance(tree, dict) else list(range(len(tree)))
        if not keys:
            return
        key = keys[int(rng.integers(0, len(keys)))]
        if isinstance(tree[key], (dict, list)) and tree[key] and rng.random() < 0.75:
            tree = tree[key]
            continue
        break
    how, value = rng.integers(0, 6), tree[key]
    if how == 0:
        del tree[key]
    elif how == 1 and isinstance(tree, dict):
        tree[f"{key}x"] = tree.pop(key)
    elif how == 2 and isinstance(value, (int, float)) and not isinstance(value, bool):
        tree[key] = value * float(rng.choice([-1.0, 0.0, 1e-9, 0.5, 2.0, 10.0, 1e3, 1e6, 1e12]))
    elif how == 3 and isinstance(value, list):
        tree[key] = value * int(rng.integers(2, 50))
    elif how == 4:
        deep: Any = 1
        for _ in range(int(rng.choice([3, 40, 70, 400]))):
            deep = [deep] if rng.random() < 0.5 else {"a": deep}
        tree[key] = deep
    else:
        tree[key] = copy.deepcopy(WRONG[int(rng.integers(0, len(WRONG)))])  # or a later change would change all


def with_record(content: bytes, suffix: str, text: str) -> bytes:
    """Return the bytes of a file with another record in it; everything else is as it was."""
    return _WITH_RECORD[suffix](content, text)


def _png_with(content: bytes, text: str) -> bytes:
    body = b"zTXtcamsim\0\0" + zlib.compress(text.encode("latin-1"))
    chunk = struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))
    # The last text counts.
    return content[:-12] + chunk + content[-12:]


def _npz_with(content: bytes, text: str) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(out, "w") as new:
        for name in old.namelist():
            new.writestr(name, text if name == "record.json" else old.read(name))
    return out.getvalue()


def _exr_with(content: bytes, text: str) -> bytes:
    attributes, end = exr_attributes(content)
    (first,) = struct.unpack_from("<Q", content, end)
    changed = [(n, k, text.encode("ascii") if n == b"camsim:record" else v) for n, k, v in attributes]
    return exr_with(content, changed, (first - end) // 8)


def _dng_with(content: bytes, text: str) -> bytes:
    xmp = (
        '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
        f'<rdf:Description rdf:about="" xmlns:c="urn:camsim:frame/1/"><c:Record>{escape(text)}</c:Record>'
        "</rdf:Description></rdf:RDF></x:xmpmeta>"
    )
    return _tag_moved(content, 700, xmp.encode("ascii"))


def _tiff_with(content: bytes, text: str) -> bytes:
    return _tag_moved(content, 270, text.encode("ascii") + b"\0")


def _tag_moved(content: bytes, number: int, value: bytes) -> bytes:
    """Return a TIFF whose tag holds another value, at the end of the file."""
    data = bytearray(content) + bytes(len(content) % 2)
    (at,) = struct.unpack_from("<I", data, 4)
    (count,) = struct.unpack_from("<H", data, at)
    for entry in range(at + 2, at + 2 + 12 * count, 12):
        if struct.unpack_from("<H", data, entry)[0] == number:
            struct.pack_into("<II", data, entry + 4, len(value), len(data))
    return bytes(data) + value


_WITH_RECORD: dict[str, Callable[[bytes, str], bytes]] = {
    ".png": _png_with, ".npz": _npz_with, ".exr": _exr_with, ".dng": _dng_with, ".tiff": _tiff_with,
}  # fmt: skip

BY_FORMAT: dict[str, Callable[[np.random.Generator, bytes], bytes]] = {
    ".dng": by_tags, ".tiff": by_tags, ".png": by_chunks, ".npz": by_members, ".npy": by_array_header,
    ".exr": by_attributes,
}  # fmt: skip
"""What knows the fields of a format."""
