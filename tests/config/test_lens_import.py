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
from camsim.errors import InputError

FOCAL_MM, F_NUMBER, FULL_DEG = 50.0, 4.0, 20.0
IDEAL_MM = FOCAL_MM * math.tan(math.radians(FULL_DEG))


def height_mm(share: Any, barrel: float = 0.04) -> Any:
    """Where the chief ray falls: 4 % less far at the rim than without distortion."""
    ideal = FOCAL_MM * np.tan(np.radians(share * FULL_DEG))
    return ideal * (1.0 - barrel * (ideal / IDEAL_MM) ** 2)


class Rays:
    """What optiland's ``Optic`` is asked, of a lens with coma, lateral colour, vignetting and a sensor out of focus."""

    paraxial = SimpleNamespace(FNO=lambda: F_NUMBER, f2=lambda: FOCAL_MM)
    fields = SimpleNamespace(max_field=FULL_DEG)
    barrel = 0.04

    def trace_generic(self, hx: Any, hy: Any, px: Any, py: Any, wavelength_um: float) -> Any:
        centre = height_mm(hx, self.barrel) * (1.0 + 2e-3 * (wavelength_um - 0.55))
        x = centre + 0.05 * hx * (3 * px**2 + py**2) + 0.1 * px
        y = 0.1 * hx * px * py + 0.1 * py
        return SimpleNamespace(x=x, y=y, i=np.where(np.hypot(px - 0.6 * hx, py) < 1.2, 1.0, 0.0))


def counted(inner_mm: float, outer_mm: float) -> float:
    """The light of an even sky that falls into a ring of the sensor, ray by ray, over the ring's area."""
    draws = np.random.default_rng(5)
    low, high = max(0.0, inner_mm - 0.4) / 19.0, min((outer_mm + 0.4) / 17.4, 1.0)  # shares that can fall there
    share = low + (high - low) * (np.arange(400_000) + draws.random(400_000)) / 400_000
    radius, angle = np.sqrt(draws.random(share.size)), 2.0 * np.pi * draws.random(share.size)
    rays = Rays().trace_generic(share, 0.0, radius * np.cos(angle), radius * np.sin(angle), 0.55)
    fallen = np.hypot(rays.x, rays.y)
    theta = np.radians(share * FULL_DEG)
    of_sky = 2.0 * np.pi * np.sin(theta) * np.cos(theta) * math.radians(FULL_DEG) * (high - low) / share.size
    ring = (fallen >= inner_mm) & (fallen < outer_mm) & (rays.i > 0.0)
    return float(of_sky[ring].sum()) / (math.pi * (outer_mm**2 - inner_mm**2))


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
    on_axis = counted(0.0, 1.0)
    for k in (3, 6, 9, 11):
        middle_mm = float(height_mm(shares[k]))
        right = counted(middle_mm - 0.4, middle_mm + 0.4) / on_axis
        assert lens.relative_illumination[k] == pytest.approx(right, rel=0.01)
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


def test_light_that_grows_off_the_axis_is_refused() -> None:
    """Behind a strong barrel: what would fall into a ring is drawn into a smaller one."""
    barrel = Rays()
    barrel.barrel = 0.2
    with pytest.raises(InputError, match=r"^'made' gives 1\.\d+ of the axis's light .*; give it a smaller field$"):
        lens_import.lens_file(barrel, name="made", source="a law")
