"""A data set of crops of six kinds of scenes: samples a second, and what readers without camsim make of it.

``python -m bench.training_set`` makes 2000 crops of 256² with their truth, of 24 optical images (six kinds of scenes,
two f-numbers, two illuminants) and three ISOs, reads every one with webdataset and again with NumPy and ``tarfile``
alone, fits variance against mean of the codes, looks for scenes in two splits and validates the metadata with
mlcroissant. Fixed patterns are off, because they come on top of the noise model that samples state.
"""

from __future__ import annotations

import argparse
import io
import json
import math
import shutil
import sys
import tarfile
import tempfile
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

import camsim

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "astronaut.jpg"
SIDE, CROP, EACH = 512, 256, 6
F_NUMBERS, ILLUMINANTS = (4.0, 8.0), ("A", "D65")
TOP = """
camsim: scene/1
lens: {kind: airy, f_number: 8}
light: {illuminant: D55, illuminance_lux: 2000}
exposure: {time_s: auto, iso: 200}
"""
KINDS = {
    "leaves": "kind: chart, name: dead-leaves, width: 540, height: 540, least_radius: 20, largest_radius: 120, seed: 3",
    "random": "kind: chart, name: random, width: 540, height: 540, shapes: 40, seed: 11",
    "star": "kind: chart, name: siemens-star, radius: 245, cycles: 72, light: 0.9",
    "e-sfr": "kind: chart, name: e-sfr, height: 500",
    "colours": "kind: chart, name: colorchecker, width: 500",
    "photograph": "kind: picture, file: photograph.jpg, width: 540",
}
IMAGES = len(KINDS) * len(F_NUMBERS) * len(ILLUMINANTS)
SHAPE = """
scene:
  unit: pixel
  background: {reflectance: 0.3}
  shapes:
    - {%s}
"""


def main() -> None:
    """Print what was made and what readers found; exit with 1 when something is not as stated."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=2000, help="about")
    parser.add_argument("--workers", type=int, help="as of camsim dataset")
    parser.add_argument("-o", "--output", help="keep the data set in this folder")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        for name, shape in KINDS.items():
            (Path(place) / f"{name}.yaml").write_text(TOP + SHAPE % shape, encoding="utf-8")
        shutil.copy(PICTURE, Path(place) / "photograph.jpg")
        folder = Path(options.output or Path(place) / "set")
        study = Path(place) / "set.yaml"
        study.write_text(json.dumps(_study(math.ceil(options.samples / EACH / IMAGES))), encoding="utf-8")
        began_s, began_cpu_s = time.perf_counter(), time.process_time()
        made = camsim.dataset(study, folder, workers=options.workers)
        wall_s, cpu_s = time.perf_counter() - began_s, time.process_time() - began_cpu_s
        count = len(made.rows)
        print(f"{count} samples of {CROP}², {len(KINDS)} kinds of scenes, {IMAGES} optical images: ", end="")
        print(f"{count / wall_s:.1f} a second", end="")
        print(f", {count / cpu_s:.1f} a second of CPU time" if options.workers == 0 else "")
        good = [made.failed == 0, _with_webdataset(folder, count), _with_numpy(folder, count)]
        good += [_splits(made.rows), _validated(folder)]
    sys.exit(0 if all(good) else 1)


def _study(draws: int) -> dict[str, Any]:
    return {
        "camsim": "dataset/1",
        "scene": [f"{name}.yaml" for name in KINDS],
        "sensor": "d40-like",
        "set": {
            "region": {"rows": SIDE, "cols": SIDE},
            "render.tolerance": 1e-3,
            "sensor.charge.prnu": 0.0,
            "sensor.charge.dsnu_e": 0.0,
        },
        "vary": {
            "exposure.iso": {"choice": [200, 800, 3200]},
            "lens.f_number": list(F_NUMBERS),
            "light.illuminant": list(ILLUMINANTS),
        },
        "draws": draws,
        "crops": {"rows": CROP, "cols": CROP, "each": EACH},
        "splits": {"train": 0.6, "val": 0.2, "test": 0.2},
    }


def _with_webdataset(folder: Path, count: int) -> bool:
    import webdataset

    urls = sorted(str(path) for path in folder.glob("*.tar"))
    keys = {
        sample["__key__"]
        for sample in webdataset.WebDataset(urls, shardshuffle=False).decode()
        if sample["noisy.npy"].shape == (CROP, CROP) and sample["truth.npy"].shape == (CROP, CROP, 3)
    }
    print(f"webdataset: {len(keys)} samples")
    return len(keys) == count


def _with_numpy(folder: Path, count: int) -> bool:
    """Fit variance = shot · mean + read² to all samples of an ISO; hold it against what they state."""
    sums: dict[float, Any] = defaultdict(lambda: [np.zeros((2, 2)), np.zeros(2), None])
    read = 0
    for path in sorted(folder.glob("*.tar")):
        with tarfile.open(path) as tar:
            parts: dict[str, dict[str, Any]] = defaultdict(dict)
            for member in tar:
                key, part = member.name.split(".", 1)
                content = tar.extractfile(member)
                assert content is not None
                parts[key][part] = content.read()
                if len(parts[key]) == 4:
                    _add(sums, parts.pop(key))
                    read += 1
    good = read == count
    print(f"NumPy and tarfile: {read} samples")
    for iso, (squares, right, stated) in sorted(sums.items()):
        found = np.linalg.solve(squares, right)
        off = found / np.array(stated) - 1.0
        good &= bool(np.all(np.abs(off) < 0.02))
        shot, read_off = (f"{value:.5g} ({100 * error:+.2f} %)" for value, error in zip(found, off, strict=True))
        print(f"  ISO {iso:g}: shot {shot} DN, read {read_off} DN²")
    return good


def _add(sums: dict[float, Any], parts: dict[str, Any]) -> None:
    about = json.loads(parts["json"])
    noisy, mean = (np.load(io.BytesIO(parts[part])).astype(float) for part in ("noisy.npy", "clean.npy"))
    mean /= about["electrons_per_dn"]
    used = mean < 0.8 * (about["white_level_dn"] - about["black_level_dn"])
    mean, square = mean[used], (noisy[used] - about["black_level_dn"] - mean[used]) ** 2
    stated = about["shot_dn"], about["read_dn2"]
    # A square of a normal deviate has a variance that goes with its mean's square.
    weight = 1.0 / (stated[0] * mean + stated[1]) ** 2
    one = sums[about["iso"]]
    one[0] += [[np.sum(weight * mean**2), np.sum(weight * mean)], [np.sum(weight * mean), np.sum(weight)]]
    one[1] += [np.sum(weight * mean * square), np.sum(weight * square)]
    one[2] = stated


def _splits(rows: tuple[dict[str, Any], ...]) -> bool:
    of = defaultdict(set)
    for row in rows:
        of[row["scene"]].add(row["split"])
    twice = [scene for scene, splits in of.items() if len(splits) > 1]
    print(
        f"scenes in two splits: {len(twice)}; {', '.join(f'{scene} {min(one)}' for scene, one in sorted(of.items()))}"
    )
    return not twice


def _validated(folder: Path) -> bool:
    import mlcroissant

    issues = mlcroissant.Dataset(jsonld=str(folder / "croissant.json")).metadata.ctx.issues
    print(f"mlcroissant: {len(issues.errors)} errors, {len(issues.warnings)} warnings")
    return not issues.errors


if __name__ == "__main__":
    main()
