"""Six raw programs, and exiftool, over files of every kind; ``make test-clients`` installs them and prints the table.

A program that is missing is a failure, never a skip. What a program is known not to do is pinned: when a newer
version does it, the test says so.
"""

import functools
import json
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import table
from raw_programs import PROGRAMS, Program, Refused, quiet, run, simple_dcraw_opens

import camsim
from camsim.camera.frame import Frame
from camsim.files import SUFFIXES, save
from camsim.files.dng import TRUTH_WHITE_DN
from camsim.rendering.cube import SpectralCube
from camsim.sensor.colour_matrix import fit
from tests import colorchecker as chart
from tests.tables import rows

pytestmark = pytest.mark.clients

DAYLIGHT_MEAN, LAMP_MEAN = 1.1, 1.2
"""Largest mean ΔE2000 that a developed ColorChecker may have."""

AGREE_WITHIN = 0.1
GREY_WITHIN = 0.006


@dataclass(frozen=True)
class Kind:
    """A kind of file; ``known`` says of a program what it does instead of everything."""

    options: dict[str, Any] = field(default_factory=dict)
    product: str = "mosaic"
    known: dict[str, str] = field(default_factory=dict)
    limit: float = DAYLIGHT_MEAN
    compress: bool = False
    given: bool = False

    def frame(self) -> Frame:
        return chart.chart(**self.options)

    def write(self, path: Path) -> None:
        """Write the capture; or only its array, as somebody does who has nothing but codes, levels and a matrix."""
        frame = self.frame()
        if not self.given:
            save(frame, path, product=self.product, allow_odd_cfa=True, compress=self.compress)
            return
        mono = len(frame.channels) == 1
        camsim.write_dng(
            path,
            frame.mosaic.astype(np.uint8 if frame.white_level_dn < 256 else np.uint16),
            "mono" if mono else frame.cfa_pattern,
            black_level_dn=frame.black_level_dn + np.array(frame.black_offsets_dn),
            white_level_dn=frame.white_level_dn,
            colour_matrix=None if mono else fit(frame.colour, "D65").xyz_to_camera,
            compress=self.compress,
        )


# What a program may do instead: codes but no right picture, a picture but no codes, colours beyond the limit; refuse.
CODES, PICTURE, OFF, REFUSES = "codes only", "picture only", "colours off", "refuses"
NOBODY_DEVELOPS = {p.name: CODES for p in PROGRAMS}
# Lossless ones have more than 100 kB: RawTherapee refuses less. Of 8 bit half a code is 8 % of the black patch.
KINDS = {name: eval(kind) for name, kind in rows("kinds-of-files.txt", "for raw programs")}
BY_NAME = {program.name: program for program in PROGRAMS}


@functools.cache
def files() -> Path:
    """Write every kind once."""
    holder = tempfile.TemporaryDirectory()
    HOLDERS.append(holder)
    return Path(holder.name)


HOLDERS: list[tempfile.TemporaryDirectory[str]] = []


def file_of(name: str) -> Path:
    path = files() / f"{list(KINDS).index(name)}.dng"
    if not path.exists():
        KINDS[name].write(path)
    return path


@dataclass(frozen=True)
class Verdict:
    """What one program made of one file; ``misfit`` is a mean ΔE2000, or for grey the largest error of a patch."""

    exact: bool | None = None
    misfit: float | None = None
    said: str = ""

    def cell(self, kind: Kind) -> str:
        known, grey = kind.known, kind.options.get("pattern") == ("Y",)
        words = []
        if self.said:
            return "refuses"
        if self.exact:
            words.append("exact")
        if self.misfit is not None and CODES not in known.values():
            words.append("grey" if grey else f"ΔE {self.misfit:.2f}")
        elif self.misfit is not None:
            words.append("wrong colours")
        return ", ".join(words)


@functools.cache
def verdict(name: str, program: str) -> Verdict:
    kind, judge, path = KINDS[name], BY_NAME[program], file_of(name)
    frame = kind.frame()
    with tempfile.TemporaryDirectory() as folder:
        try:
            exact = codes_are_exact(kind, frame, judge, path, Path(folder))
            if program == "LibRaw tools":
                simple_dcraw_opens(path, subfolder(Path(folder), "others"))
            picture = judge.picture(path, subfolder(Path(folder), "picture"))
        except Refused as refusal:
            found = Verdict(said=str(refusal) or "nothing")
        else:
            found = Verdict(exact, None if picture is None else misfit(kind, frame, picture))
    table.note(name, program, found.cell(kind))
    return found


def subfolder(folder: Path, name: str) -> Path:
    (folder / name).mkdir()
    return folder / name


def codes_are_exact(kind: Kind, frame: Frame, judge: Program, path: Path, folder: Path) -> bool | None:
    if kind.known.get(judge.name) == PICTURE:
        with pytest.raises(Refused):
            judge.codes(path, subfolder(folder, "codes"))
        return None
    codes = judge.codes(path, subfolder(folder, "codes"))
    if codes is None:
        return None
    if kind.product == "mosaic":
        return np.array_equal(codes, frame.mosaic)
    assert frame.truth is not None
    saturation_e = (frame.white_level_dn - frame.black_level_dn) * frame.electrons_per_dn
    wanted = frame.truth.astype(np.float64) / saturation_e * TRUTH_WHITE_DN
    # Half a code, and what single precision rounds.
    return bool(np.abs(codes.reshape(wanted.shape) - wanted).max() <= 0.51)


def misfit(kind: Kind, frame: Frame, picture: np.ndarray) -> float:
    means = chart.patch_means(picture, *frame.mosaic.shape)
    if len(frame.channels) > 1:
        return float(chart.delta_e(kind.options.get("light", "D65"), means).mean())
    luminance = means if means.ndim == 1 else means[:, 1]
    span_dn = frame.white_level_dn - frame.black_level_dn
    recorded = (frame.mosaic.astype(np.float32)[:, :, None] - frame.black_level_dn) / span_dn
    return float(np.abs(luminance - chart.patch_means(recorded, *frame.mosaic.shape)[:, 0]).max())


@pytest.mark.parametrize("program", BY_NAME)
@pytest.mark.parametrize("name", KINDS)
def test_program_over_kind(name: str, program: str) -> None:
    kind = KINDS[name]
    found, known = verdict(name, program), kind.known.get(program)
    if known == REFUSES:
        assert found.said
        return
    assert found.said == ""
    assert found.exact is not False
    if known == CODES:
        assert found.misfit is None or found.misfit > 5, "develops it now: take it out of the list"
    elif known == OFF:
        assert found.misfit is not None
        assert found.misfit > kind.limit, "gets it right now: take it out of the list"
    elif found.misfit is not None:
        assert found.misfit <= (GREY_WITHIN if kind.options.get("pattern") == ("Y",) else kind.limit)


@pytest.mark.parametrize(
    "name", [name for name, kind in KINDS.items() if not {CODES, OFF, REFUSES} & {*kind.known.values()}]
)
def test_the_programs_agree(name: str) -> None:
    found = {program: verdict(name, program).misfit for program in BY_NAME}
    misfits = {program: value for program, value in found.items() if value is not None}
    assert len(misfits) == 5
    assert max(misfits.values()) - min(misfits.values()) <= AGREE_WITHIN, misfits


@pytest.mark.parametrize("name", KINDS)
def test_exiftool_validates(name: str) -> None:
    kind, path = KINDS[name], file_of(name)
    frame = kind.frame()
    answer = quiet(run("exiftool", "-validate", "-warning", "-error", "-a", "-s", path)).decode()
    assert answer.split() == ["Validate", ":", "OK"]
    table.note(name, "exiftool", "valid")
    (read,) = json.loads(quiet(run("exiftool", "-j", "-n", "-G1", path)))
    white = str(read["IFD0:WhiteLevel"]).split()
    # Where the first photosites are full: offsets move that as they move black.
    first_dn = frame.white_level_dn + (0 if kind.given else int(np.min(frame.black_offsets_dn)))
    assert set(white) == {str(first_dn if kind.product == "mosaic" else TRUTH_WHITE_DN)}
    assert read["IFD0:ImageWidth"] == frame.mosaic.shape[1]
    assert read["IFD0:Orientation"] == 1
    if kind.given:
        return
    assert read["ExifIFD:ExposureTime"] == pytest.approx(frame.time_s)
    assert read["ExifIFD:FNumber"] == pytest.approx(frame.f_number)
    assert read["XMP-camsim:Seed"] == frame.seed
    record = read["XMP-camsim:Record"]
    assert (json.loads(record) if isinstance(record, str) else record)["description"] == frame.description


def test_exiftool_validates_the_other_formats(tmp_path: Path) -> None:
    plane = np.ones((48, 66), np.float32)
    frame = chart.chart(48, 66, spectral=SpectralCube((550.0,), "W.m^-2.sr^-1", lambda k, take: take(plane) or 0.0))
    for suffix in sorted(set(SUFFIXES) - {".npy"}):
        for product in SUFFIXES[suffix].writers:
            path = tmp_path / f"a{suffix}"
            save(frame, path, product=product, force=True)
            kind = quiet(run("exiftool", "-s3", "-FileType", path)).decode().strip()
            assert kind == {".tif": "TIFF", ".npz": "ZIP"}.get(suffix, suffix[1:].upper())
            if suffix in (".tiff", ".tif", ".png"):
                answer = quiet(run("exiftool", "-validate", "-warning", "-error", "-a", "-s", path))
                assert answer.decode().split() == ["Validate", ":", "OK"], (suffix, product)


@pytest.mark.parametrize(
    ("program", "smallest"),
    [("rawpy", 22), ("dcraw", 22), ("LibRaw tools", 22), ("RawTherapee", 224), ("darktable", 6), ("Adobe SDK", 5)],
)
def test_smallest_files(tmp_path: Path, program: str, smallest: int) -> None:
    """RawTherapee refuses files of less than 100 kB, the descendants of dcraw less than 22 photosites a side."""
    judge = BY_NAME[program]
    for size in (smallest, smallest - 16):
        if size < 1:
            continue
        save(chart.chart(size, size), tmp_path / "a.dng", force=True)
        folder = subfolder(tmp_path, str(size))
        ask = judge.picture if program in ("RawTherapee", "darktable") else judge.codes
        if size == smallest:
            assert ask(tmp_path / "a.dng", folder) is not None
        else:
            with pytest.raises(Refused):
                ask(tmp_path / "a.dng", folder)


def test_exrheader_lists_the_attributes(tmp_path: Path) -> None:
    frame = chart.chart(48, 66)
    save(frame, tmp_path / "a.exr")
    said = quiet(run("exrheader", tmp_path / "a.exr")).decode()
    for words in (
        'camsim:seed (type string): "1099511627777"',
        'camsim:errorEstimate (type string): "4.5e-07"',
        'camsim:units (type string): "electrons"',
        "R, 32-bit floating-point",
    ):
        assert words in said, said
