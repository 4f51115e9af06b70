"""Mutated files through ``camsim info``, ``info --full``, ``info --json``, ``measure mtf`` and ``recapture``.

python bench/fuzz_readers.py [COUNT] [SEED] [FOLDER]   (20 000 files unless said otherwise, seed 1)

A third of the files have bytes changed, a third fields of their format (tags, chunks, members, attributes, array
headers, checksums mended), a third their record (the checksum mended). Every command must end with 0, or with 2 and
one sentence: no traceback, no warning; within 2 s of processor time and 500 MB beyond the file. Only what a record
really describes is captured for as long as that takes; such captures are counted apart. What is found is kept in
FOLDER.
"""

from __future__ import annotations

import contextlib
import functools
import io
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from crafted_files import crafted
from mutations import BY_FORMAT, by_bytes, by_record

SLOWEST_S = 2.0
MOST_BYTES = 500_000_000
_HANGS_S = 30
_ADDRESS_SPACE = 4 << 30
"""Beyond what the process has when it begins: a claim of terabytes fails at once and not by swapping."""


class Hangs(BaseException):
    """A command took half a minute of processor time; nothing of camsim's catches this."""


@dataclass(frozen=True, slots=True)
class Sample:
    """A whole file: how to measure it, its bytes and its record."""

    path: Path
    measure: tuple[str, ...]
    content: bytes
    record: dict[str, Any] | None


@dataclass(slots=True)
class Tally:
    """How often each command ended how, the slowest and the largest; what is wrong."""

    ends: Counter[str] = field(default_factory=Counter)
    slowest_s: dict[str, float] = field(default_factory=dict)
    most_bytes: dict[str, int] = field(default_factory=dict)
    wrong: list[str] = field(default_factory=list)


def samples(folder: Path) -> list[Sample]:
    """Write one small file of every kind, with an edge in it that can be measured."""
    import tifffile
    from PIL import Image

    import camsim
    from camsim.files.reading import read_file

    shape = camsim.Rectangle(width_um=200.0, height_um=400.0, centre_um=(100.0, 0.0), rotate_deg=5.0, reflectance=0.7)
    written: list[tuple[Path, tuple[str, ...]]] = []
    for sensor, names in (
        ("mono-345", ("a.dng", "packed.dng", "truth.dng", "a.tiff", "mosaic.png", "electrons.exr", "a.npz", "a.npy")),
        ("d40-like", ("bayer.dng", "packed-bayer.dng", "truth.tiff", "a.png", "truth.exr", "bayer.npz")),
    ):
        camera = camsim.Camera.from_yaml(sensor, lens=camsim.Airy(f_number=8.0))
        frame = camera.expose(
            camsim.Scene(background=0.1, shapes=[shape]),
            light=camsim.Light(line_nm=550.0, illuminance_lux=3000.0),
            exposure=camsim.Exposure(time_s="auto", iso=200.0),
            region=camsim.Region(rows=64, cols=64),
            tolerance=1e-3,
            products=("mosaic", "truth"),
        )
        for name in names:
            product = next((word for word in ("truth", "electrons", "mosaic") if name.startswith(word)), None)
            camsim.save(frame, folder / name, product=product, compress=name.startswith("packed"))
            written.append((folder / name, ("--gamma", "srgb") if name == "a.png" else ()))
    shades = np.linspace(20, 220, 64 * 64, dtype=np.uint8).reshape(64, 64)
    Image.fromarray(shades).save(folder / "a.jpg")
    np.savez_compressed(folder / "foreign.npz", picture=shades.astype(np.float32))
    tifffile.imwrite(
        folder / "foreign.tiff",
        shades.astype(np.float32),
        tile=(32, 48),
        compression="zlib",
        predictor=True,
        metadata=None,
    )
    foreign_dng(folder / "foreign.dng", shades)
    written += [(folder / "a.jpg", ("--gamma", "2.2")), (folder / "foreign.npz", ())]
    written += [(folder / "foreign.tiff", ()), (folder / "foreign.dng", ())]
    whole = []
    for path, options in written:
        ours = path.suffix not in (".npy", ".jpg") and path.stem != "foreign"
        record = {"camsim": "frame/1", **read_file(path).record.as_dict()} if ours else None
        whole.append(Sample(path, options, path.read_bytes(), record))
    return whole


def foreign_dng(path: Path, shades: Any) -> None:
    """Write a DNG as cameras do: a thumbnail, and below it packed strips with levels, a border and a table."""
    import tifffile

    tags = [
        (33421, "H", 2, (2, 2), True),
        (33422, "B", 4, bytes([2, 1, 1, 0]), True),
        (50712, "H", 256, tuple(range(0, 2560, 10)), True),
        (50713, "H", 2, (2, 2), True),
        (50714, "2I", 4, (100, 1, 200, 2, 300, 3, 400, 4), True),
        (50717, "I", 1, 2550, True),
        (50829, "I", 4, (2, 2, 64, 64), True),
    ]
    with tifffile.TiffWriter(path, byteorder=">") as tiff:
        version = [(50706, "B", 4, bytes([1, 4, 0, 0]), True)]
        thumbnail = np.zeros((8, 8, 3), np.uint8)
        tiff.write(thumbnail, subfiletype=1, subifds=1, photometric="rgb", extratags=version, metadata=None)
        tiff.write(shades, subfiletype=0, photometric=32803, rowsperstrip=10, extratags=tags, metadata=None)


def mutated(rng: np.random.Generator, sample: Sample) -> bytes:
    """Return one mutation of a file: of its bytes, its format's fields or its record."""
    how, suffix = rng.integers(0, 3), sample.path.suffix
    if how == 2 and sample.record is not None:
        return by_record(rng, sample.content, suffix, sample.record)
    if how == 1 and suffix in BY_FORMAT:
        return BY_FORMAT[suffix](rng, sample.content)
    return by_bytes(rng, sample.content)


def commands(victim: Path, measure: tuple[str, ...], folder: Path) -> dict[str, list[str]]:
    """Return what a user might do with a file from a stranger."""
    name = str(victim)
    again = ["recapture", name, "-q", "--force"]
    if victim.suffix in (".npy", ".jpg"):
        again += ["-o", str(folder / "again.dng")]
    return {
        "info": ["info", name],
        "info --full": ["info", "--full", name],
        "info --json": ["info", "--json", name],
        "measure": ["measure", "mtf", name, *measure],
        "recapture": again,
    }


def judged(arguments: list[str], size: int, tally: Tally, what: str, slowest_s: float = SLOWEST_S) -> str | None:
    """Run one command in this process; return what is wrong with how it ended."""
    out, err = io.StringIO(), io.StringIO()
    before = _resident()
    began = time.process_time()  # others may use the machine too
    wrong, code, caught = None, 1, None
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), _at_most(_HANGS_S):
            code = _command().main(arguments, standalone_mode=False) or 0
    except BaseException as error:  # whatever it is, it is what is looked for
        caught = error
        wrong = traceback.format_exc()
    taken_s, taken = time.process_time() - began, max(0, _peak() - before - size)
    said = err.getvalue()
    tally.most_bytes[what] = max(tally.most_bytes.get(what, 0), taken)
    end = "refused" if code == 2 else "done" if code == 0 else "WRONG"
    # What a record really describes, however odd, is computed for as long as that takes.
    computing = what == "recapture" and taken_s > slowest_s and (code == 0 or isinstance(caught, Hangs))
    tally.ends[f"{what}: {'a capture of more than 2 s' if computing else end}"] += 1
    if computing:
        return None
    tally.slowest_s[what] = max(tally.slowest_s.get(what, 0.0), taken_s)
    if wrong is not None:
        return wrong
    if code not in (0, 2) or (code == 2 and (said.count("\n") != 1 or len(said) > 2000)) or (code == 0 and said):
        return f"exit {code}: {said[:500]}"
    if taken_s > slowest_s:
        return f"{taken_s:.1f} s, exit {code}: {said[:200]}"
    return f"{taken / 1e6:.0f} MB, exit {code}: {said[:200]}" if taken > MOST_BYTES else None


def crafted_are_refused(whole: list[Sample], folder: Path, slowest_s: float = SLOWEST_S) -> tuple[list[str], int]:
    """Try every crafted file; returns what is wrong, and how many commands were run."""
    record = next(sample.record for sample in whole if sample.path.name == "a.dng")
    assert record is not None
    wrong, tally = [], Tally()
    for name, content in crafted({s.path.name: s.content for s in whole}, record, folder / "proof"):
        victim = folder / f"crafted-{name}"
        victim.write_bytes(content)
        for what, arguments in commands(victim, ("--gamma", "1"), folder).items():
            before = tally.ends[f"{what}: refused"]
            with contextlib.chdir(folder):
                found = judged(arguments, len(content), tally, what, slowest_s)
            asked = name.partition("-")[0] if "-" in name else what
            if found is not None or (asked == what and tally.ends[f"{what}: refused"] == before):
                wrong.append(f"{name}, {what}: {found or 'not refused'}")
        victim.unlink()
    return wrong, tally.ends.total()


def fuzz(
    count: int,
    seed: int,
    whole: list[Sample],
    folder: Path,
    kept: Path | None = None,
    slowest_s: float = SLOWEST_S,
) -> Tally:
    """Try ``count`` mutations of whole files; returns how they ended."""
    tally = Tally()
    with contextlib.chdir(folder):  # recapture writes where it is started
        for sample in whole:  # compiles what is not yet compiled
            for what, arguments in commands(sample.path, sample.measure, folder).items():
                if (wrong := judged(arguments, 0, Tally(), what)) and "MB" not in wrong and " s, exit" not in wrong:
                    tally.wrong.append(f"{sample.path.name}, unchanged, {what}: {wrong}")
    with warnings.catch_warnings(), contextlib.chdir(folder):
        warnings.simplefilter("error")
        for number in range(count):
            rng = np.random.default_rng([seed, number])
            sample = whole[int(rng.integers(0, len(whole)))]
            content = mutated(rng, sample)
            victim = folder / f"mutated{sample.path.suffix}"
            victim.write_bytes(content)
            for what, arguments in commands(victim, sample.measure, folder).items():
                wrong = judged(arguments, len(content), tally, what, slowest_s)
                if wrong is not None:
                    tally.wrong.append(f"{number} of {sample.path.name}, {what}: {wrong}")
                    if kept is not None:
                        (kept / f"{number}-{sample.path.name}").write_bytes(content)
                        (kept / f"{number}-{sample.path.name}.{what.split()[0]}.txt").write_text(
                            wrong, errors="replace"
                        )
            if number % 1000 == 999:
                print(f"{number + 1} files, {len(tally.wrong)} wrong", file=sys.stderr, flush=True)
    return tally


@functools.cache
def _command() -> Any:
    from typer.main import get_command

    from camsim.cli.app import app

    return get_command(app)


@contextlib.contextmanager
def _at_most(seconds: int) -> Iterator[None]:
    def stop(*_: object) -> None:
        raise Hangs

    previous = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, previous)


def _resident() -> int:
    """Return the bytes that this process holds, and begin to look for the most anew."""
    Path("/proc/self/clear_refs").write_text("5")
    return _status("VmRSS")


def _peak() -> int:
    return _status("VmHWM")


def _status(key: str) -> int:
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(key))
    return int(line.split()[1]) * 1024


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    kept = Path(sys.argv[3]) if len(sys.argv) > 3 else None
    if kept is not None:
        kept.mkdir(parents=True, exist_ok=True)
    limit = _status("VmSize") + _ADDRESS_SPACE
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whole = samples(folder)
        wrong, refused = crafted_are_refused(whole, folder)
        print(
            f"crafted files: {refused} commands, {len(wrong)} of them not refused as they should be", *wrong, sep="\n"
        )
        tally = fuzz(count, seed, whole, folder, kept)
    for end, number in sorted(tally.ends.items()):
        print(f"{number:7}  {end}")
    for what, slowest in tally.slowest_s.items():
        print(f"{what:12} slowest {slowest:5.2f} s, at most {tally.most_bytes[what] / 1e6:4.0f} MB beyond the file")
    for wrong in tally.wrong[:20]:
        print(wrong.strip().splitlines()[0], "|", wrong.strip().splitlines()[-1])
    print(f"{count} files, seed {seed}: {len(tally.wrong)} commands ended otherwise than with 0, or 2 and a sentence")
    sys.exit(bool(tally.wrong or wrong))


if __name__ == "__main__":
    main()
