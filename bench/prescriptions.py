"""Prescriptions by strangers, imported and held against two other ray traces.

``python -m bench.prescriptions [FILE.zmx[=MM] …]`` imports each (MM: the largest image height, in place of the
file's own) and compares MTF at three fields, two directions and three wavelengths with rays and path differences of
optiland, which reads the file itself, and with ``tests/truth/lens_rays.py``; distortion likewise. Without files it
takes optiland's own samples, written as Zemax files by optiland. What is refused stands there with its reason. Where a
rim cuts optiland's pupil between its rays, its figures are off by up to 0.005.
"""

from __future__ import annotations

import importlib
import inspect
import math
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from camsim.config import lens_import, yaml_source
from camsim.config.lens_files import lens_of
from camsim.config.lens_rays import NEAR_AXIS, Prescription
from camsim.core.arrays import F64
from camsim.errors import CamsimError
from camsim.optics import FieldLens
from tests.truth import lens_rays as truth

FIELDS = (0.0, 0.7, 1.0)  # of the largest
NM = (450.0, 550.0, 650.0)
PER_MM = np.array([10.0, 20.0, 40.0])
WITHIN = 0.01
SAMPLES = ("objectives", "simple", "telescopes", "miscellaneous")
BY_HEIGHTS = {"DoubleGauss": 2, "TelescopeDoublet": 3}  # besides: fields by heights in the paraxial, in the real image
BEYOND, ACROSS = 1.06, 121  # of the pupil's radius, to where optiland is asked for rays, and how many a diameter has


class Held(NamedTuple):
    """The largest differences of an imported lens: of MTF, and of where chief rays fall (a fraction)."""

    mtf_truth: float
    mtf_optiland: float
    fall_truth: float
    fall_optiland: float


def samples(folder: Path) -> Iterator[Path]:
    """Yield optiland's samples as Zemax files."""
    from optiland.fileio.zemax import save_zemax_file

    for name in SAMPLES:
        module = importlib.import_module(f"optiland.samples.{name}")
        for _, kind in inspect.getmembers(module, inspect.isclass):
            if kind.__module__ == module.__name__:
                file, optic = folder / f"{kind.__name__}.zmx", kind()
                save_zemax_file(optic, str(file))
                yield file
                if by := BY_HEIGHTS.get(kind.__name__):
                    yield _by_height(file, optic, by)


def _by_height(file: Path, optic: Any, by: int) -> Path:
    """Return a copy of a file whose largest field is the height in the image where optiland has it."""
    largest = math.radians(float(optic.fields.max_field))
    real_mm = float(abs(optic.trace_generic(0.0, 1.0, 0.0, 0.0, optic.primary_wavelength).y[0]))
    height_mm = real_mm if by == 3 else abs(float(optic.paraxial.f2())) * math.tan(largest)
    stated = file.read_text(encoding="utf-8").replace("FTYP 0", f"FTYP {by}")
    lines = [f"YFLN 0 {height_mm!r} 0" if line.startswith("YFLN") else line for line in stated.splitlines()]
    copy = file.with_stem(f"{file.stem}-FTYP-{by}")
    copy.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return copy


def transfers(lens: FieldLens, height_um: float, nm: float) -> F64:
    """Return MTF of a lens file at a height: along the radius and across it."""
    placed, per_um, none = lens.at(min(height_um, lens.height_um[-1]), 0.0), PER_MM / 1e3, 0.0 * PER_MM
    return np.abs([placed.otf(per_um, none, nm), placed.otf(none, per_um, nm)])


def fallen_um(lens: FieldLens, ideal_um: float) -> float:
    """Return where what would fall at a height without distortion falls."""
    return float(lens.distorted(np.array([[ideal_um, 0.0]]))[0, 0])


class Rays:
    """The second trace: ``tests/truth``, of surfaces as camsim reads them."""

    def __init__(self, stated: Prescription) -> None:
        self._lens = stated.of_wavelengths((stated.middle_nm,))
        self._um = stated.middle_nm / 1e3
        self.rows = [
            (
                each.curvature_per_mm,
                each.conic,
                dict(each.powers),
                each.thickness_mm,
                "mirror" if each.mirror else _index(each.index),
                each.rim_mm,
            )
            for each in stated.surfaces
        ]
        self.stop = next(k for k, each in enumerate(stated.surfaces) if each.stop)
        self.aim = stated.aim

    def chief_mm(self, angle: float) -> tuple[float, float]:
        """Return where a field's chief ray enters and falls."""
        if self.aim:
            return truth.chief_mm(self.rows, self.stop, angle, self._um)
        near, _ = truth.chief_mm(self.rows, self.stop, NEAR_AXIS, self._um)
        entry = near / math.tan(NEAR_AXIS) * math.tan(angle)
        at, *_ = truth.trace(self.rows, self.stop, angle, np.array([entry]), np.zeros(1), self._um)
        return entry, float(at[0, 0])

    def transfers(self, angle: float, nm: float) -> F64:
        """Return MTF along the radius and across it."""
        middle, *halves = self._lens.vignetted(angle)
        entry, height = self.chief_mm(angle)
        radius = self._lens.stop_mm if self.aim else self._lens.radius_mm
        pupil = truth.Ellipse(
            in_stop=self.aim,
            middle=radius * middle + (0.0 if self.aim else entry),
            along=radius * halves[0],
            across=radius * halves[1],
        )
        reach = 1.5 * self._lens.radius_mm
        return np.array(
            truth.mtf_through(
                self.rows, self.stop, pupil, angle, nm / 1e3, PER_MM, (entry, height), reach, self._lens.sphere_mm
            )
        )


def _index(index: Any) -> Any:
    return truth.AIR if index is None else lambda um: float(index(np.array([1e3 * um]))[0])


class Optiland:
    """The file as optiland reads and traces it, in fields of angles: rays, path differences and pupils are its own."""

    def __init__(self, file: Path, stated: Prescription, full: float) -> None:
        from optiland.fileio import load_zemax_file

        self.optic = load_zemax_file(str(file))
        if stated.aim:
            self.optic.ray_tracer.set_aiming("robust")
        self.optic.fields.fields.clear()
        self.optic.fields.set_type("angle")
        for share in (0.0, 1.0):
            self.optic.fields.add(y=share * math.degrees(full))
        self.optic.wavelengths.wavelengths.clear()
        self.optic.wavelengths.add(value=stated.middle_nm / 1e3, is_primary=True)
        self._vignetted = stated.of_wavelengths((stated.middle_nm,)).vignetted

    def fallen_mm(self, share: float, um: float) -> float:
        """Return where the chief ray falls."""
        rays = self.optic.trace_generic(0.0, share, 0.0, 0.0, um)
        return float(np.hypot(rays.x, rays.y)[0])

    def transfers(self, share: float, angle: float, nm: float) -> F64:
        """Return MTF along the radius and across it: of its wavefront on its sphere about the chief ray."""
        from optiland.distribution import BaseDistribution
        from optiland.wavefront import Wavefront

        axis = np.linspace(-BEYOND, BEYOND, ACROSS)
        x, y = (each.ravel() for each in np.meshgrid(axis, axis))
        radius = np.hypot(x, y)
        x, y, radius = (each[radius <= BEYOND] for each in (x, y, radius))
        middle, along, across = self._vignetted(angle)

        class Places(BaseDistribution):
            def generate_points(self, num_points: int) -> None:
                self.x, self.y = across * x, middle + along * y

        places = Places()
        places.generate_points(0)
        found = Wavefront(self.optic, [(0.0, share)], [nm / 1e3], distribution=places).data
        [wave] = found.values()
        centre = np.ravel(wave.reference_center)
        cosines = np.array([wave.pupil_y - centre[1], wave.pupil_x - centre[0]]) / float(np.ravel(wave.radius)[0])
        stopped = ~(np.asarray(wave.intensity) > 0.0)
        known = np.any(cosines + centre[1::-1, None], axis=0)
        rim = np.where(stopped, np.maximum(radius, 1.0) + 0.1, radius)
        return np.array(truth.overlaps(cosines[:, known], wave.opd[known], rim[known], nm / 1e3, PER_MM))


def held(file: Path, stated: Prescription, full: float, lens: FieldLens) -> Held:
    """Compare an imported lens with the other traces."""
    rays, other = Rays(stated), Optiland(file, stated, full)
    scale = abs(rays.chief_mm(1e-3)[1]) / math.tan(1e-3)
    worst = np.zeros(4)
    for share in FIELDS:
        angle = share * full
        height_um = 1e3 * abs(rays.chief_mm(angle)[1])
        for nm in NM:
            each = transfers(lens, height_um, nm)
            worst[0] = max(worst[0], np.abs(each - rays.transfers(angle, nm)).max())
            worst[1] = max(worst[1], np.abs(each - other.transfers(share, angle, nm)).max())
        if share:
            fallen = fallen_um(lens, 1e3 * scale * math.tan(angle))
            worst[2] = max(worst[2], abs(fallen / height_um - 1.0))
            right_um = 1e3 * other.fallen_mm(share, stated.middle_nm / 1e3)
            worst[3] = max(worst[3], abs(fallen / right_um - 1.0))
    return Held(*worst.tolist())


def row(file: Path, field_mm: float | None) -> str:
    """Return what becomes of a file, on a line."""
    began = time.process_time()
    try:
        stated, full, notes = lens_import.read_zemax(file, field_mm=field_mm)
        traced = lens_import.lens_file(stated, full, name=file.stem, source=file.name, notes=notes)
        traced.check_mtf(WITHIN, file.name)
    except CamsimError as refused:
        return f"{file.name}: refused in {time.process_time() - began:.1f} s of one core: {refused}"
    seconds = time.process_time() - began
    lens = lens_of(yaml_source.parse(traced.text.encode("utf-8"), file.name, Path()))
    largest = f"{math.degrees(full):.3g}°, {lens.height_um[-1] / 1e3:.3g} mm, f/{lens.f_number:.3g}"
    found = held(file, stated, full, lens)
    return (
        f"{file.name} ({largest}): {seconds:.1f} s of one core; MTF off {found.mtf_truth:.4f} (own), "
        f"{found.mtf_optiland:.4f} (optiland); "
        f"distortion off {100 * found.fall_truth:.4f} %, {100 * found.fall_optiland:.4f} %"
    )


def main(given: list[str]) -> None:
    """Print a line of each."""
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as place:
        files = [(Path(name), float(mm) if mm else None) for name, _, mm in (one.partition("=") for one in given)]
        for file, field_mm in files or [(one, None) for one in samples(Path(place))]:
            print(row(file, field_mm), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
