"""Files that no accident makes: each asks for memory, time or code that a reader must not give."""

from __future__ import annotations

import io
import json
import pickle
import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from mutations import exr_attributes, exr_with, signed, with_record


class Runs:
    """What a pickle can do: make a file when it is read."""

    def __init__(self, proof: Path) -> None:
        self.proof = proof

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.proof,)


def crafted(files: Mapping[str, bytes], record: dict[str, Any], proof: Path) -> Iterator[tuple[str, bytes]]:
    """Yield names and contents; every one is to be refused: by the command that its name begins with, or by all.

    files  : whole files by name, as ``fuzz_readers.samples`` writes them
    record : that of all of them
    proof  : a file that is there afterwards if anything of a stranger's was run
    """
    yield from _arrays(proof)
    yield from _archives(files["a.npz"], proof)
    yield from _pictures(files)
    yield from _records(files, record)


def _arrays(proof: Path) -> Iterator[tuple[str, bytes]]:
    out = io.BytesIO()
    np.save(out, np.array([[Runs(proof)]], object), allow_pickle=True)
    yield "pickle.npy", out.getvalue()
    yield "pickled.npy", pickle.dumps(Runs(proof))
    for name, shape in (("tera", "(1000000, 1000000)"), ("digits", f"({'9' * 3000},)"), ("negative", "(-4, 9)")):
        yield f"{name}.npy", array_header(f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}")
    yield "code.npy", array_header(f"{{'descr': open({str(proof)!r}, 'w'), 'fortran_order': False, 'shape': (4, 4), }}")
    yield "deep.npy", array_header("(" * 60_000)
    yield "long.npy", b"\x93NUMPY\2\0" + struct.pack("<I", 2**32 - 1) + b"{" * 5000


def array_header(text: str) -> bytes:
    """Return the beginning of an array with any header, and a few numbers."""
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text.encode("latin-1") + bytes(128)


def _archives(content: bytes, proof: Path) -> Iterator[tuple[str, bytes]]:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}

    def packed(method: int, **changes: bytes) -> bytes:
        out = io.BytesIO()
        with zipfile.ZipFile(out, "w", method, compresslevel=1) as archive:
            for name, body in {**members, **{name.replace("_", "."): body for name, body in changes.items()}}.items():
                archive.writestr(name, body)
        return out.getvalue()

    pickled = io.BytesIO()
    np.save(pickled, np.array([[Runs(proof)]], object), allow_pickle=True)
    yield "pickle.npz", packed(zipfile.ZIP_STORED, mosaic_npy=pickled.getvalue())
    yield "lzma.npz", packed(zipfile.ZIP_LZMA)
    zeros = bytes(300 << 20)
    head = "{'descr': '<u2', 'fortran_order': False, 'shape': (15360, 10240), }"
    yield "measure-bomb.npz", packed(zipfile.ZIP_DEFLATED, mosaic_npy=array_header(head)[:-128] + zeros)
    yield "info-text-bomb.npz", packed(zipfile.ZIP_DEFLATED, record_json=zeros[: 40 << 20])
    del zeros
    whole = packed(zipfile.ZIP_STORED)
    # A member that says terabytes, in the directory and in its own header.
    tera = "{'descr': '<u2', 'fortran_order': False, 'shape': (4000000, 4000000), }"
    yield "tera.npz", packed(zipfile.ZIP_STORED, mosaic_npy=array_header(tera))
    claimed = bytearray(whole)
    at = whole.rfind(b"mosaic.npy") - 46  # its entry in the directory
    struct.pack_into("<2I", claimed, at + 20, 0xFFFFFFFE, 0xFFFFFFFE)
    yield "claims.npz", bytes(claimed)
    end = bytearray(whole)
    struct.pack_into("<I", end, len(end) - 10, 0x7FFFFFFF)  # the directory's length
    yield "directory.npz", bytes(end)
    many = io.BytesIO()
    with zipfile.ZipFile(many, "w") as archive:
        for number in range(3000):
            archive.writestr(f"a{number}.npy", b"")
    yield "members.npz", many.getvalue()


def png(*chunks: tuple[bytes, bytes]) -> bytes:
    """Return a PNG of chunks, their checksums right."""
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I4s", len(body), kind) + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    )


def _pictures(files: Mapping[str, bytes]) -> Iterator[tuple[str, bytes]]:
    head = struct.pack(">2I5B", 60_000, 60_000, 16, 0, 0, 0, 0)
    yield "claims.png", png((b"IHDR", head), (b"IDAT", zlib.compress(bytes(1000))), (b"IEND", b""))
    widest = struct.pack(">2I5B", 2**31 - 1, 2**31 - 1, 16, 6, 0, 0, 1)
    yield "widest.png", png((b"IHDR", widest), (b"IDAT", b""), (b"IEND", b""))
    yield "empty.png", png((b"IHDR", struct.pack(">2I5B", 0, 0, 16, 0, 0, 0, 0)), (b"IEND", b""))
    text = b"camsim\0\0" + zlib.compress(bytes(1 << 26), 9)
    grey = struct.pack(">2I5B", 8, 8, 16, 0, 0, 0, 0)
    pixels = (b"IDAT", zlib.compress(bytes(8 * 17)))
    yield "bomb.png", png((b"IHDR", grey), (b"zTXt", text), pixels, (b"IEND", b""))
    huge = struct.pack(">2I5B", 2**30, 2**30, 8, 2, 0, 0, 0)
    yield "two-headers.png", png((b"IHDR", grey), (b"IHDR", huge), pixels, (b"IEND", b""))
    yield "measure-two-frames.jpg", jpeg(8, 8).partition(b"\xff\xda")[0] + jpeg(65_500, 65_500)[2:]
    yield "many.png", png((b"IHDR", grey), *(((b"abcd", b""),) * 70_000), pixels, (b"IEND", b""))
    yield "claims.jpg", jpeg(65_500, 65_500)
    yield "none.jpg", b"\xff\xd8\xff\xd9"
    window = struct.pack("<4i", 0, 0, 999_999, 499_999)
    for name, value in (("tera", window), ("largest", struct.pack("<4i", -(2**31), -(2**31), 2**31 - 1, 2**31 - 1))):
        attributes, end = exr_attributes(files["electrons.exr"])
        chunks = (struct.unpack_from("<Q", files["electrons.exr"], end)[0] - end) // 8
        windows = [(n, k, value if n == b"dataWindow" else v) for n, k, v in attributes]
        yield f"{name}.exr", exr_with(files["electrons.exr"], windows, chunks)
    tiled = [*attributes, (b"tiles", b"tiledesc", struct.pack("<2IB", 2**31 - 1, 2**31 - 1, 0))]
    whole = exr_with(files["electrons.exr"], tiled, chunks)
    yield "measure-tiles.exr", whole[:4] + struct.pack("<I", 0x202) + whole[8:]
    yield from _tiffs(files)


def jpeg(rows: int, cols: int) -> bytes:
    """Return the markers of a JPEG that claims a size."""
    frame = struct.pack(">BHHB", 8, rows, cols, 1) + bytes((1, 0x11, 0))
    scan = bytes((1, 1, 0, 0, 63, 0))
    return (
        b"\xff\xd8\xff\xc0" + struct.pack(">H", len(frame) + 2) + frame
        + b"\xff\xda" + struct.pack(">H", len(scan) + 2) + scan + bytes(50) + b"\xff\xd9"
    )  # fmt: skip


def tiff(**tags: int) -> bytes:
    """Return a TIFF of one strip or tile of a hundred bytes, its tags by the names below; ``x`` repeats one."""
    numbers = {"width": 256, "length": 257, "bits": 258, "compression": 259, "photometric": 262, "offset": 273,
               "samples": 277, "rows": 278, "count": 279, "next": 0, "tile_width": 322, "tile_length": 323,
               "tile_offset": 324, "tile_count": 325, "below": 330}  # fmt: skip
    following = tags.pop("next", 0)
    entries = sorted((numbers[name], value) for name, value in tags.items())
    head = b"II*\0" + struct.pack("<IH", 8, len(entries))
    return (
        head
        + b"".join(struct.pack("<HHII", number, 4, 1, value) for number, value in entries)
        + struct.pack("<I", following)
        + bytes(1000)
    )


def _tiffs(files: Mapping[str, bytes]) -> Iterator[tuple[str, bytes]]:
    whole = {"bits": 16, "compression": 1, "photometric": 1, "offset": 200, "count": 100}
    yield "claims.tiff", tiff(width=10**6, length=10**6, **whole)
    yield "packed.tiff", tiff(width=10**6, length=10**6, **{**whole, "compression": 8})
    yield "samples.tiff", tiff(width=10, length=10, samples=60_000, **whole)
    yield "rows.tiff", tiff(width=10, length=2**32 - 1, rows=1, **whole)
    yield "circle.tiff", tiff(width=5, length=5, next=8, below=8, **{**whole, "photometric": 3})
    tile = {"tile_offset": 200, "tile_count": 100, "tile_width": 2**31, "tile_length": 2**31}
    yield "tile.tiff", tiff(width=10, length=10, bits=16, compression=8, photometric=1, **tile)
    # One tile of lossless JPEG that claims the largest frame.
    dng = bytearray(files["packed.dng"])
    at = dng.index(b"\xff\xc3", dng.index(b"\xff\xd8"))
    struct.pack_into(">2H", dng, at + 5, 65_535, 65_535)
    yield "measure-frame.dng", bytes(dng)


def _records(files: Mapping[str, bytes], record: dict[str, Any]) -> Iterator[tuple[str, bytes]]:
    """Yield files of all formats with records that cannot be; the checksums fit."""

    def changed(*path: str, to: Any) -> str:
        tree = json.loads(json.dumps(record))
        at = tree
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] = to
        return signed(tree)

    deep: Any = 1
    for _ in range(80):
        deep = [deep]
    texts = {
        "deep": changed("description", "scene", to=deep),
        "deepest": '{"camsim":"frame/1","description":' + "[" * 200_000,
        "class": changed("description", "camera", "lens", to={"kind": "os.system", "command": "true"}),
        "module": changed("description", "camera", "lens", to={"kind": "__builtins__"}),
        "result": changed("description", "camera", "lens", to={"kind": "Frame"}),
        "field": changed("description", "camera", "lens", to={"kind": "Airy", "f_number": 8, "__class__": "x"}),
        "type": changed("description", "camera", "pitch_um", to="3.45"),
        "truth": changed("description", "camera", "rows", to=True),
        "huge": changed("description", "camera", "pitch_um", to=1e300),
        "place": changed("description", "camera", "lens", to={"kind": "FourSpotOlpf", "split_um": 1.0}),
        "size": changed("description", "region", to={"kind": "Region", "rows": 2000, "cols": 2000, "origin": None}),
        "tolerance": changed("description", "tolerance", to=-1.0),
        "channels": changed("channels", to=[["R"], 5]),
        "pattern": changed("cfa_pattern", to=["RG", "B"]),
        "level": changed("black_level_dn", to="128"),
        "part": changed("extra", to=1),
        "lists": changed("description", "scene", to=[[]] * 600_000),
        "digits": signed(record).replace('"seed":0', f'"seed":{"9" * 5000}'),
        "infinite": signed(record).replace('"seed":0', '"seed":1e999'),
    }
    described = ("class", "module", "result", "field", "type", "truth", "huge", "place", "size", "tolerance", "lists")
    for number, (name, text) in enumerate(texts.items()):
        file = ("a.dng", "a.tiff", "mosaic.png", "electrons.exr", "a.npz")[number % 5]
        suffix = Path(file).suffix
        # Without a capture to take again the figures and the pixels may still be read.
        only = "recapture-" if name in described and name != "lists" else ""
        yield f"{only}{name}{suffix}", with_record(files[file], suffix, text)
