"""Other people's programs over files of every kind: not one warning, not one wrong number.

``make test-clients`` installs the programs and runs these tests; a program that is missing is a failure.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rawpy

from camsim.files import SUFFIXES, save
from camsim.frame import Frame

pytestmark = pytest.mark.clients

X_TRANS = "GBGGRG RGRBGB GBGGRG GRGGBG BGBRGR GRGGBG"
KINDS: dict[str, dict[str, Any]] = {
    "RGGB": {"pattern": "RG GB"},
    "BGGR": {"pattern": "BG GR"},
    "GRBG": {"pattern": "GR BG"},
    "GBRG, odd size": {"pattern": "GB RG", "rows": 447, "cols": 445},
    "X-Trans": {"pattern": X_TRANS, "rows": 516, "cols": 600},
    "mono": {"pattern": "Y"},
    "14 bit": {"bit_depth": 14, "black_level_dn": 512, "white_level_dn": 16383},
    "16 bit": {"bit_depth": 16, "black_level_dn": 1024, "white_level_dn": 65535},
    "smallest": {"rows": 22, "cols": 22},
    "high ISO, long, slow": {"iso": 409600.0, "time_s": 3600.0, "f_number": 64.0},
}


@pytest.fixture(params=KINDS)
def case(request: pytest.FixtureRequest, tmp_path: Path, make_frame: Callable[..., Frame]) -> tuple[Frame, Path]:
    frame = make_frame(**{"rows": 446, "cols": 446, **KINDS[request.param]})
    save(frame, tmp_path / "a.dng")
    return frame, tmp_path / "a.dng"


def run(*command: str | Path) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(command, capture_output=True, check=True, timeout=60)


def test_exiftool_validates_the_dng(case: tuple[Frame, Path]) -> None:
    frame, path = case
    answer = run("exiftool", "-validate", "-warning", "-error", "-a", "-s", path).stdout.decode()
    assert answer.split() == ["Validate", ":", "OK"]
    (read,) = json.loads(run("exiftool", "-j", "-n", "-G1", path).stdout)
    assert read["IFD0:WhiteLevel"] == frame.white_level_dn
    assert read["IFD0:ImageWidth"] == frame.mosaic.shape[1]
    assert read["IFD0:Orientation"] == 1
    assert read["ExifIFD:ExposureTime"] == pytest.approx(frame.time_s)
    assert read["ExifIFD:FNumber"] == pytest.approx(frame.f_number)
    assert read["XMP-camsim:Seed"] == frame.seed
    record = read["XMP-camsim:Record"]
    assert (json.loads(record) if isinstance(record, str) else record)["description"] == frame.description


def test_exiftool_validates_tiff_and_png(tmp_path: Path, frame: Frame) -> None:
    for suffix, product in ((".tiff", "mosaic"), (".png", "mosaic"), (".png", "preview")):
        save(frame, tmp_path / f"a{suffix}", product=product)
        answer = run("exiftool", "-validate", "-warning", "-error", "-a", "-s", tmp_path / f"a{suffix}").stdout
        assert answer.decode().split() == ["Validate", ":", "OK"], suffix


def test_dcraw_unpacks_the_codes(case: tuple[Frame, Path]) -> None:
    frame, path = case
    # -D: no interpolation and no scaling; -4: 16-bit linear; -c: to the standard output, as PGM.
    answer = run("dcraw", "-D", "-4", "-t", "0", "-c", path)
    assert answer.stderr == b""
    header, size, largest, pixels = answer.stdout.split(b"\n", 3)
    assert (header, largest) == (b"P5", b"65535")
    cols, rows = map(int, size.split())
    codes = np.frombuffer(pixels, ">u2").reshape(rows, cols)
    np.testing.assert_array_equal(codes, frame.mosaic)


ADOBE = """
import dngpy, numpy, sys
file = dngpy.Dng(sys.argv[1])
codes = file.raw_pixels[..., 0]
assert numpy.array_equal(codes, numpy.load(sys.argv[2])), "codes differ"
print(file.get_bayer_pattern(), *file.get_white_balance())
"""


def test_adobes_library_reads_the_codes_without_a_warning(case: tuple[Frame, Path]) -> None:
    frame, path = case
    np.save(path.with_suffix(".npy"), frame.mosaic)
    answer = run(sys.executable, "-c", ADOBE, path, path.with_suffix(".npy"))
    # Adobe's validator prints its warnings to either stream.
    assert answer.stderr == b""
    words = answer.stdout.decode().split()
    if frame.channels == ("Y",):
        assert words == []
        return
    *pattern, red, green, blue = words
    if len(frame.cfa_pattern) == 2:
        assert pattern == ["".join(frame.cfa_pattern)]
    seen = frame.colour.sensitivity @ frame.colour.light
    np.testing.assert_allclose([float(red), float(green), float(blue)], seen / seen.max(), rtol=1e-5)


def test_less_than_22_photosites_open_in_adobes_library_only(tmp_path: Path, make_frame: Callable[..., Frame]) -> None:
    for size in (5, 21):
        frame = make_frame(size, size)
        save(frame, tmp_path / "a.dng")
        np.save(tmp_path / "a.npy", frame.mosaic)
        assert run(sys.executable, "-c", ADOBE, tmp_path / "a.dng", tmp_path / "a.npy").stderr == b""
        with pytest.raises(rawpy.LibRawFileUnsupportedError):
            rawpy.imread(str(tmp_path / "a.dng"))
        refused = subprocess.run(["dcraw", "-i", tmp_path / "a.dng"], capture_output=True, check=False)
        assert b"Cannot decode file" in refused.stderr


def test_every_suffix_is_known_to_exiftool_as_what_it_is(tmp_path: Path, frame: Frame) -> None:
    for suffix in set(SUFFIXES) - {".npy"}:
        save(frame, tmp_path / f"a{suffix}")
        kind = run("exiftool", "-s3", "-FileType", tmp_path / f"a{suffix}").stdout.decode().strip()
        assert kind == {".tif": "TIFF"}.get(suffix, suffix[1:].upper())
