"""Mutated DNG, EXR, TIFF and PNG files through the readers behind ``camsim info`` and ``camsim recapture``.

python bench/fuzz_readers.py [COUNT] [SEED]   (12 000 mutations unless said otherwise, over 10 000 of DNG and EXR)

Every file must give either what it holds or one sentence, within 2 s, and the process must stay below 512 MB.
What still reads must hold the record that was written: a changed one is never believed.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

SLOWEST_S = 2.0
MOST_MIB = 512


def mutated(rng: np.random.Generator, content: bytes) -> bytes:
    """Return the file with a few bytes changed, cut out, doubled or exchanged for extreme numbers."""
    data = bytearray(content)
    for _ in range(int(rng.integers(1, 6))):
        # Headers are at the beginning and a DNG's directories at the end: most mutations go there.
        reach = len(data) if rng.random() < 0.4 else min(len(data), int(rng.choice([16, 400, 1500, 12000])))
        at = int(rng.integers(0, max(1, reach)))
        if rng.random() < 0.5:
            at = max(0, len(data) - 1 - at)
        how = rng.integers(0, 7)
        if how == 0:
            data[at : at + 1] = bytes([int(rng.integers(0, 256))])
        elif how == 1 and data:
            data[min(at, len(data) - 1)] ^= 1 << int(rng.integers(0, 8))
        elif how == 2:
            extreme = rng.choice([0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0xFFFF, len(content)])
            data[at : at + 4] = int(extreme).to_bytes(4, "little")
        elif how == 3:
            del data[at : at + int(rng.integers(1, 200))]
        elif how == 4:
            data = data[:at]
        elif how == 5:
            data[at:at] = data[at : at + int(rng.integers(1, 200))]
        else:
            data[at:at] = rng.bytes(int(rng.integers(1, 20)))
    return bytes(data)


def samples(folder: Path) -> list[Path]:
    """Write one small file of every kind."""
    import camsim

    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    shape = camsim.Rectangle(width_um=40.0, height_um=40.0, rotate_deg=4.0, reflectance=0.05)
    frame = camera.expose(
        camsim.Scene(background=0.9, shapes=[shape]),
        light=camsim.Light("D55", illuminance_lux=5000.0),
        exposure=camsim.Exposure(time_s=0.01, iso=200.0),
        region=camsim.Region(rows=24, cols=26),
        products=("mosaic", "truth"),
    )
    written = []
    for name in ("a.dng", "packed.dng", "a.exr", "electrons.exr", "a.tiff", "a.png", "a.npz"):
        product = "electrons" if name == "electrons.exr" else None
        camsim.save(frame, folder / name, product=product, compress=name == "packed.dng")
        written.append(folder / name)
    return written


def fuzz(count: int, seed: int, folder: Path) -> tuple[Counter[str], float]:
    """Read ``count`` mutations; returns how many ended how, and the slowest reading in seconds."""
    from camsim.cli.info import json_of_file, text_of_file
    from camsim.errors import CamsimError
    from camsim.files.describe import canonical
    from camsim.files.reading import read_file

    rng = np.random.default_rng(seed)
    files = samples(folder)
    originals = {path: (path.read_bytes(), canonical(read_file(path).record.as_dict())) for path in files}
    # Five in six are DNG and EXR.
    weights = np.array([4.0 if path.suffix in (".dng", ".exr") else 1.0 for path in files])
    ends: Counter[str] = Counter()
    slowest_s = 0.0
    for _ in range(count):
        path = files[rng.choice(len(files), p=weights / weights.sum())]
        content, record = originals[path]
        victim = folder / f"mutated{path.suffix}"
        victim.write_bytes(mutated(rng, content))
        began = time.perf_counter()
        try:
            held = read_file(victim)
            text_of_file(str(victim))
            json_of_file(str(victim))
            assert canonical(held.record.as_dict()) == record, "a changed record was believed"
            ends["read, record as written"] += 1
        except CamsimError as error:
            message = str(error)
            assert message.startswith(f"cannot read {str(victim)!r}: "), message
            assert "\n" not in message, message
            ends[f"{path.suffix[1:]} refused"] += 1
        slowest_s = max(slowest_s, time.perf_counter() - began)
    return ends, slowest_s


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 12_000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    with tempfile.TemporaryDirectory() as folder:
        ends, slowest_s = fuzz(count, seed, Path(folder))
    peak_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    for end, number in sorted(ends.items()):
        print(f"{number:6}  {end}")
    print(f"{count} mutations, none crashed; slowest {slowest_s:.3f} s, peak {peak_mib:.0f} MiB")
    assert slowest_s < SLOWEST_S, slowest_s
    assert peak_mib < MOST_MIB, peak_mib


if __name__ == "__main__":
    main()
