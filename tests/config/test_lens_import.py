"""A lens file from rays whose law is known; that optiland traces them well is asked where optiland is."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import camsim
from camsim.config import lens_import

FOCAL_MM, F_NUMBER, FULL_DEG = 50.0, 4.0, 20.0
IDEAL_MM = FOCAL_MM * math.tan(math.radians(FULL_DEG))


def height_mm(share: float) -> float:
    """Where the chief ray falls: 4 % less far at the rim than without distortion."""
    ideal = FOCAL_MM * math.tan(math.radians(share * FULL_DEG))
    return ideal * (1.0 - 0.04 * (ideal / IDEAL_MM) ** 2)


def light(share: Any) -> Any:
    """The light at a field angle: by the pupil's aberrations more than on the axis before it falls."""
    return 1.0 + 0.2 * share**2 - 0.5 * share**4


class Rays:
    """What optiland's ``Optic`` is asked, of a lens with coma, lateral colour and vignetting."""

    paraxial = SimpleNamespace(FNO=lambda: F_NUMBER, f2=lambda: FOCAL_MM)
    fields = SimpleNamespace(max_field=FULL_DEG)

    @staticmethod
    def trace_generic(hx: Any, hy: Any, px: Any, py: Any, wavelength_um: float) -> Any:
        centre = np.array([height_mm(float(h)) for h in np.atleast_1d(hx)]) * (1.0 + 2e-3 * (wavelength_um - 0.55))
        slope = np.sqrt(light(hx)) / (2.0 * F_NUMBER)
        return SimpleNamespace(x=centre + 0.3 * (3 * px**2 + py**2), L=0.1 * hx + slope * px, M=slope * py)


def waves(share: float) -> dict[int, float]:
    """Defocus, astigmatism and coma; and what no lens of revolution has, a sine."""
    return {4: 0.1 + 0.2 * share**2, 5: 0.1 * share**2, 7: 0.3 * share, 8: 0.05 * share}


def test_what_rays_tell_stands_in_the_lens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def zernike(optic: Any, share: float, wavelength_nm: float) -> np.ndarray:
        coefficients = np.zeros(lens_import.TERMS)
        for index, value in waves(share).items():
            coefficients[index] = value * 550.0 / wavelength_nm
        return coefficients

    monkeypatch.setattr(lens_import, "_zernike", zernike)
    file = tmp_path / "made.yaml"
    file.write_text(lens_import.lens_file(Rays(), name="made", source="a law"), encoding="utf-8")
    lens = camsim.read_lens(file)
    shares = np.linspace(0.0, 1.0, lens_import.HEIGHTS)
    assert lens.f_number == F_NUMBER
    np.testing.assert_allclose(lens.height_um, [1e3 * height_mm(share) for share in shares], atol=6e-4)
    np.testing.assert_allclose(lens.relative_illumination, np.minimum(light(shares), 1.0), atol=6e-6)
    assert lens.zernike == (4, 5, 8)
    at_650 = [[waves(share)[k] * 550.0 / 650.0 for k in (4, 5, 8)] for share in shares]
    np.testing.assert_allclose(lens.waves[lens.wavelength_nm.index(650.0)], at_650, atol=6e-6)
    # 2e-3 of the height for a micrometre more of wavelength.
    farther_um = [0.1 * 2.0 * height_mm(share) for share in shares]
    np.testing.assert_allclose(lens.lateral_colour_um[lens.wavelength_nm.index(650.0)], farther_um, atol=6e-5)
    for share in (0.2, 0.5, 0.9):
        ideal_um = 1e3 * FOCAL_MM * math.tan(math.radians(share * FULL_DEG))
        fallen_um = lens.distorted(np.array([[0.6 * ideal_um, 0.8 * ideal_um]]))
        assert math.hypot(*fallen_um[0]) == pytest.approx(1e3 * height_mm(share), abs=0.5)
