"""Forty captures and tests as on other processors.

``python -m bench.machines`` takes the captures once for each of ``MACHINES``, a process each, and compares codes and
every kind of file with the first one's. It exits with 1 where a code differs, or where more than two captures of a kind
have other bytes: a mean that lies at the edge of its step may fall on either side. ``python -m bench.machines tests
ARGUMENT…`` runs pytest on each with these arguments. ``make test-machines`` does both, with some of the tests.

SkylakeX wants a processor with AVX-512: without it OpenBLAS takes another core, and nothing is learnt there.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

MACHINES: Mapping[str, Mapping[str, str]] = {
    "Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
    "SkylakeX": {"OPENBLAS_CORETYPE": "SkylakeX"},
    "Zen": {"OPENBLAS_CORETYPE": "Zen"},
    "Sandybridge": {"OPENBLAS_CORETYPE": "Sandybridge"},
    "generic": {"NUMBA_CPU_NAME": "generic"},
    "plain": {"NPY_DISABLE_CPU_FEATURES": " ".join(name for name in __cpu_dispatch__ if __cpu_features__[name])},
}
"""What OpenBLAS, Numba and NumPy are told to take for the processor that they run on."""

OTHERS = 2
"""Captures of forty whose files of one kind may differ in a last bit."""

ALL = ("mosaic", "truth", "spectral")
KINDS = (
    *("dng:mosaic", "dng:truth", "exr:truth", "exr:electrons", "exr:spectral", "tiff:mosaic", "tiff:truth"),
    *("png:preview", "png:mosaic", "npy:mosaic", "npy:electrons", "npy:truth", "npz:frame"),
)

_WAVES = "lens={kind: wavefront, f_number: 4, zernike_waves: [[8, 0.1], [5, 0.07]], defocus_um: 6}"
_BLADES = "lens={kind: wavefront, f_number: 5.6, pupil: {shape: bladed, blades: 7, rotate_deg: 10, obstruction: 0.1}}"
_ANNULAR = "lens={kind: annular-airy, f_number: 8, obstruction: 0.4}"
_FAR = "lens={kind: field, file: double-gauss, falloff: {kind: cos4, exit_pupil_mm: 60}}"
_ASTRAY = "lens={kind: elliptical-gaussian, f_number: 4, sigma_um: 2, sigma_across_um: 4, rotate_deg: 30}"
_MEASURED = "lens={kind: measured-psf, f_number: 4, irradiance: [[0, 1, 0], [1, 4, 1], [0, 1, 0]], spacing_um: 1.5}"
_RADIAL = "lens={kind: radial-otf, f_number: 4, freq_per_um: [0, 0.05, 0.2], values: [1, 0.5, 0]}"

# Scene, sensor (None: the scene's own) and what is set besides.
CAPTURES: tuple[tuple[str, str | None, tuple[str, ...]], ...] = (
    ("slanted-edge", None, ()),
    ("slanted-edge", None, ("sensor.olpf=null", "exposure.iso=1600")),
    ("slanted-edge", "x-trans-376", ("render.tolerance=1e-5",)),
    ("slanted-edge", "phone-080", ("lens.f_number=2",)),
    ("slanted-edge", "pi-155", (_WAVES, "render.tolerance=1e-4")),
    ("slanted-edge", "machine-colour-345", (_BLADES, "render.tolerance=1e-4")),
    ("slanted-edge", "medium-format-376", (_ANNULAR,)),
    ("slanted-edge", "astronomy-376", ("lens.f_number=16",)),
    (
        "slanted-edge",
        "d40-like",
        (_RADIAL, "files.colour_matrix=scene", "light={blackbody_k: 3200, illuminance_lux: 900}"),
    ),
    ("slanted-edge", "d40-like", ("light={line_nm: 532, illuminance_lux: 900}", "render.method=fourier")),
    ("slanted-edge", "mono-345", (_MEASURED, "render.tolerance=1e-4")),
    ("slanted-edge", "mono-345", (_ASTRAY, "render.tolerance=1e-8")),
    ("flat-field", None, ()),
    ("flat-field", "phone-080", ("lens.veiling_glare=0.03",)),
    ("flat-field", "mono-345", ("noise.enabled=false",)),
    ("colorchecker", None, ("light={illuminant: A, illuminance_lux: 500}",)),
    ("colorchecker", "x-trans-376", ("files.colour_matrix=scene",)),
    ("colorchecker", "machine-colour-345", ("render.tolerance=1e-4", "lens.transmission=0.9")),
    ("colorchecker-card", None, ()),
    ("bars", None, ()),
    ("bars", "pi-155", ("exposure.time_s=auto",)),
    ("checkerboard", None, ()),
    ("dead-leaves", None, ()),
    ("leaves-in-colour", None, ()),
    ("dot-grid", None, ("lens.f_number=11",)),
    ("drawing", None, ()),
    ("e-sfr", None, ()),
    ("edge-grid", "d40-like", ("noise.enabled=false",)),
    ("field-lens", None, ()),
    ("field-lens", "d40-like", (_FAR, "light={illuminant: D65, illuminance_lux: 5000}")),
    ("grey-steps", "d40-like", ()),
    ("groups", None, ()),
    ("lens-grid", None, ()),
    ("qr-code", None, ()),
    ("random-shapes", None, ()),
    ("shapes", None, (_WAVES,)),
    ("siemens-star", "d40-like", ("render.tolerance=1e-4",)),
    ("starfield", None, ()),
    ("text", None, ()),
    ("zone-plate", None, ()),
)


def captures() -> bool:
    """Take the captures on every machine, say what is the same, and return whether enough is."""
    with tempfile.TemporaryDirectory() as place:
        found = {name: _taken_on(name, Path(place)) for name in MACHINES}
    first, *rest = found
    same = True
    print(f"of {len(CAPTURES)} captures as on {first}:")
    for name in rest:
        pairs = list(zip(CAPTURES, found[name], found[first], strict=True))
        counts = {kind: sum(mine[kind] == other[kind] for _, mine, other in pairs) for kind in ("codes", *KINDS)}
        print(f"{name}: " + ", ".join(f"{kind} {count}" for kind, count in counts.items()), flush=True)
        for (scene, *with_), mine, other in pairs:
            if differ := [kind for kind in counts if mine[kind] != other[kind]]:
                print(f"  {scene} {with_}: {', '.join(differ)}")
        same &= counts["codes"] == len(CAPTURES) and min(counts.values()) >= len(CAPTURES) - OTHERS
    return same


def tests(arguments: Sequence[str]) -> bool:
    """Run pytest on every machine, and return whether all pass."""
    passed = True
    for name in MACHINES:
        print(f"{name}:", flush=True)
        passed &= not subprocess.run([sys.executable, "-m", "pytest", *arguments], env=_environment(name)).returncode
    return passed


def _environment(name: str) -> dict[str, str]:
    stated = {key for machine in MACHINES.values() for key in machine}
    return {key: value for key, value in os.environ.items() if key not in stated} | dict(MACHINES[name])


def _taken_on(name: str, place: Path) -> list[dict[str, str]]:
    """Return a checksum of the codes and of every kind of file, capture by capture."""
    file = place / f"{name}.json"
    subprocess.run([sys.executable, "-m", "bench.machines", "take", str(file)], env=_environment(name), check=True)
    found: list[dict[str, str]] = json.loads(file.read_text(encoding="utf-8"))
    return found


def _take(to: Path) -> None:
    import camsim
    from camsim.errors import OutputError

    found = []
    for scene, sensor, changes in CAPTURES:
        overrides = ["region.rows=64", "region.cols=72", *changes]
        if not camsim.load(scene, sensor=sensor, overrides=overrides).light.is_one_line:
            overrides.append("files.spectral_nm=[480, 610]")  # and not 31 planes
        frame = camsim.capture(scene, sensor=sensor, overrides=overrides, seed=11, products=ALL)
        sums = {"codes": _sum(frame.mosaic.tobytes())}
        for kind in KINDS:
            suffix, product = kind.split(":")
            file = to.parent / f"a.{suffix}"
            try:
                camsim.save(frame, file, product=product, force=True, allow_odd_cfa=True)  # type: ignore[arg-type]
                sums[kind] = _sum(file.read_bytes())
            except OutputError as error:  # of arrays that a DNG cannot hold
                sums[kind] = str(error)
        found.append(sums)
    to.write_text(json.dumps(found), encoding="utf-8")


def _sum(held: bytes) -> str:
    return hashlib.sha256(held).hexdigest()


if __name__ == "__main__":
    match sys.argv[1:]:
        case []:
            sys.exit(not captures())
        case ["tests", *arguments]:
            sys.exit(not tests(arguments))
        case ["take", file]:
            _take(Path(file))
        case other:
            sys.exit(f"{' '.join(other)}: give nothing, or tests and arguments of pytest")
