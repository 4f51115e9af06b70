"""The programs that judge our DNGs, each asked for the codes as they are and for a picture in XYZ.

All develop in the same way: camera white balance, no brightening, no curve, linear. Where a program cannot do one of
the two, it returns None. A program that cannot open a file raises Refused.
"""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rawpy
import tifffile

from tests.libraw import developed

WHITE_DN = np.float32(65535)

# IEC 61966-2-1.
SRGB_TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]],
    dtype=np.float32,
)

# ISO 22028-2 to XYZ relative to D50, and on to D65 after Bradford (B. Lindbloom, brucelindbloom.com).
PROPHOTO_TO_XYZ = (
    np.array(
        [[0.9555766, -0.0230393, 0.0631636], [-0.0282895, 1.0099416, 0.0210077], [0.0122982, -0.0204830, 1.3299098]]
    )
    @ np.array([[0.7976749, 0.1351917, 0.0313534], [0.2880402, 0.7118741, 0.0000857], [0.0, 0.0, 0.8252100]])
).astype(np.float32)

RAWTHERAPEE_PROFILE = Path(__file__).parents[1] / "data" / "rawtherapee.pp3"


class Refused(Exception):
    """A program does not open a file; says what it said."""


@dataclass(frozen=True)
class Program:
    """One program: ``codes`` and ``picture`` take a DNG and an empty folder.

    codes   : (rows, cols) or (rows, cols, 3) uint16 as stored, or None
    picture : (rows, cols, 3) XYZ relative to D65, or (rows, cols) linear grey, Y = 1 at the white level; or None
    """

    name: str
    version: Callable[[], str]
    codes: Callable[[Path, Path], np.ndarray | None]
    picture: Callable[[Path, Path], np.ndarray | None]


def run(*command: str | Path, cwd: Path | None = None, home: Path | None = None) -> subprocess.CompletedProcess[bytes]:
    env = {**os.environ, **({"HOME": str(home), "XDG_CONFIG_HOME": str(home)} if home else {})}
    return subprocess.run(command, capture_output=True, check=False, timeout=600, cwd=cwd, env=env)


def quiet(answer: subprocess.CompletedProcess[bytes]) -> bytes:
    """Return what a program printed; raises Refused when it complained."""
    if answer.returncode or answer.stderr:
        raise Refused(answer.stderr.decode(errors="replace").strip()[:200] or f"exit code {answer.returncode}")
    return answer.stdout


def first_number(text: str) -> str:
    found = re.search(r"\d+\.\d+(\.\d+)?", text)
    assert found is not None, text
    return found.group()


def netpbm(content: bytes) -> np.ndarray:
    """Return the image of a 16-bit PGM or PPM."""
    kind, size, largest, pixels = content.split(b"\n", 3)
    cols, rows = map(int, size.split())
    assert largest == b"65535"
    shape = (rows, cols) if kind == b"P5" else (rows, cols, 3)
    return np.frombuffer(pixels, ">u2").reshape(shape)


def tag(path: Path, number: int) -> object:
    with tifffile.TiffFile(path) as file:
        return file.pages.first.tags[number].value


def is_grey(path: Path) -> bool:
    return tag(path, 262) == 34892 and tag(path, 277) == 1


def as_shot_neutral(path: Path) -> np.ndarray:
    parts = np.array(tag(path, 50728), dtype=np.float64)
    return parts[::2] / parts[1::2]


# LibRaw of today, in this process.


def rawpy_codes(path: Path, folder: Path) -> np.ndarray:
    try:
        with rawpy.imread(str(path)) as raw:
            codes = raw.raw_image_visible.copy()
    except rawpy.LibRawError as error:
        raise Refused(str(error)) from error
    # Of a linear file LibRaw keeps a fourth, empty plane.
    return codes[:, :, :3] if codes.ndim == 3 else codes


def rawpy_picture(path: Path, folder: Path) -> np.ndarray:
    try:
        return developed(path, "raw")[:, :, 0] if is_grey(path) else developed(path)
    except rawpy.LibRawError as error:
        raise Refused(str(error)) from error


# dcraw and the tools of Debian's LibRaw take the same options: -4 16 bits and linear, -w camera white balance,
# -o 5 XYZ, -q 0 bilinear, -t 0 not turned.


def dcraw_codes(path: Path, folder: Path) -> np.ndarray:
    return netpbm(quiet(run("dcraw", "-D", "-4", "-t", "0", "-c", path)))


def dcraw_picture(path: Path, folder: Path) -> np.ndarray:
    # It warns when asked for a white balance that a grey file has not.
    balance = () if is_grey(path) else ("-w",)
    return netpbm(quiet(run("dcraw", "-4", *balance, "-o", "5", "-q", "0", "-t", "0", "-c", path))) / WHITE_DN


def libraw_codes(path: Path, folder: Path) -> np.ndarray:
    copy = folder / "a.dng"
    copy.symlink_to(path)
    answer = run("unprocessed_raw", "-q", "-T", copy)
    written = sorted(folder.glob("a.dng*.tiff"))
    if answer.returncode or answer.stderr or not written:
        raise Refused(answer.stderr.decode(errors="replace").strip() or "wrote nothing")
    planes = [np.asarray(tifffile.imread(file)) for file in written]
    return planes[0] if len(planes) == 1 else np.stack(planes[:3], axis=2)


def libraw_picture(path: Path, folder: Path) -> np.ndarray:
    target = folder / "a.tiff"
    quiet(run("dcraw_emu", "-4", "-T", "-w", "-o", "5", "-q", "0", "-t", "0", "-Z", target, path))
    if not target.exists():
        raise Refused("wrote nothing")
    return np.asarray(tifffile.imread(target)) / WHITE_DN


def simple_dcraw_opens(path: Path, folder: Path) -> None:
    """Refuse what the two other tools of LibRaw do not take without a word."""
    copy = folder / "b.dng"
    copy.symlink_to(path)
    quiet(run("simple_dcraw", copy))
    assert b"is not" not in quiet(run("raw-identify", copy))


def rawtherapee_picture(path: Path, folder: Path) -> np.ndarray:
    target = folder / "a.tif"
    answer = run(
        "rawtherapee-cli", "-o", target, "-p", RAWTHERAPEE_PROFILE, "-q", "-t", "-b16", "-Y", "-c", path, home=folder
    )
    said = answer.stderr.decode(errors="replace")
    if "Error" in said or not target.exists():
        raise Refused(said.strip())
    encoded = np.asarray(tifffile.imread(target)) / WHITE_DN
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return linear @ PROPHOTO_TO_XYZ.T


def darktable_picture(path: Path, folder: Path) -> np.ndarray:
    target = folder / "a.tif"
    settings = {
        "plugins/darkroom/workflow": "none",
        "plugins/darkroom/chromatic-adaptation": "legacy",
        "plugins/imageio/format/tiff/bpp": "32",
    }
    answer = run(
        "darktable-cli", path, target, "--icc-type", "LIN_REC709", "--core", "--configdir", folder / "config",
        "--cachedir", folder / "cache", "--library", ":memory:", "--disable-opencl",
        *(word for key, value in settings.items() for word in ("--conf", f"{key}={value}")),
        home=folder,
    )  # fmt: skip
    if answer.returncode or not target.exists():
        raise Refused((answer.stdout + answer.stderr).decode(errors="replace").strip()[-200:])
    # It balances to green, where the others leave the most responsive channel as it is.
    green = 1.0 if is_grey(path) else as_shot_neutral(path)[1]
    # Of an array that it misreads it sometimes makes infinities; as zeros they are wrong enough.
    picture = np.nan_to_num(np.asarray(tifffile.imread(target)), nan=0.0, posinf=0.0, neginf=0.0)
    return np.clip(picture, -10, 10) @ SRGB_TO_XYZ.T / np.float32(green)


ADOBE = """
import dngpy, numpy, sys
file = dngpy.Dng(sys.argv[1])
codes = file.raw_pixels
numpy.save(sys.argv[2], codes[..., 0] if codes.shape[-1] == 1 else codes)
"""


def adobe_codes(path: Path, folder: Path) -> np.ndarray:
    # In a process of its own: Adobe's validator prints its warnings to either stream.
    said = quiet(run(sys.executable, "-c", ADOBE, path, folder / "codes.npy"))
    if said:
        raise Refused(said.decode(errors="replace").strip())
    return np.load(folder / "codes.npy")


def nothing(path: Path, folder: Path) -> None:
    """Stand for what a program has no way to give."""


def version_of(*command: str) -> Callable[[], str]:
    def version() -> str:
        answer = run(*command)
        return first_number((answer.stdout + answer.stderr).decode(errors="replace"))

    return version


def rawpy_version() -> str:
    return f"{rawpy.__version__} (LibRaw {'.'.join(map(str, rawpy.libraw_version))})"


def adobe_version() -> str:
    from importlib.metadata import version

    return f"through dngpy {version('dngpy')}"


PROGRAMS = (
    Program("rawpy", rawpy_version, rawpy_codes, rawpy_picture),
    Program("dcraw", version_of("dcraw"), dcraw_codes, dcraw_picture),
    Program("LibRaw tools", version_of("dpkg-query", "-W", "libraw-bin"), libraw_codes, libraw_picture),
    Program("RawTherapee", version_of("rawtherapee-cli", "-v"), nothing, rawtherapee_picture),
    Program("darktable", version_of("darktable-cli", "--version"), nothing, darktable_picture),
    Program("Adobe SDK", adobe_version, adobe_codes, nothing),
)
