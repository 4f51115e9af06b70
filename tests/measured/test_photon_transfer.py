"""What goes into a sensor comes back from its flats and darks, by EMVA 1288's procedures."""

import math
from typing import Any

import numpy as np
import pytest
from tolerances import STATISTICAL

import camsim
from camsim.api import load_camera
from camsim.measure.noise.photon_transfer import photon_transfer
from camsim.measure.noise.stack import Level, Photosites, stack

SIDE, FRAMES, TIME_S = 240, 12, 0.01
LEVELS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)


def codes_of(
    camera: camsim.Camera, level: float, *, seed: int, count: int = FRAMES, time_s: float = TIME_S
) -> list[Any]:
    """Codes of flats at a level of the full well (0: darks)."""
    saturation_e = camera.adc.saturation_e(camera.adc.base_iso, camera.well_as_read_e(camera.adc.base_iso))
    one = camsim.Light(line_nm=550.0, irradiance_w_per_m2=1.0, at="sensor")
    watts = saturation_e / camera.diffuser_electrons(one, TIME_S).max()
    flat = camsim.Capture(
        camera=camera,
        scene=camsim.Scene(background=1.0 if level else 0.0),
        light=camsim.Light(line_nm=550.0, irradiance_w_per_m2=watts * (level or 1.0), at="sensor"),
        exposure=camsim.Exposure(time_s=time_s, iso=camera.adc.base_iso),
        seed=seed,
        tolerance=1e-2,
    )
    return [frame.mosaic for frame in flat.frames(count)]


def measured(camera: camsim.Camera) -> Any:
    whole = Photosites(np.ones((camera.rows, camera.cols), dtype=bool))
    dark = stack(codes_of(camera, 0.0, seed=50), whole)

    def exposed(level: float, **taken: int) -> Level:
        return Level(exposure=level, light=stack(codes_of(camera, level, **taken), whole), dark=dark)

    return photon_transfer(
        flats=[exposed(level, seed=n) for n, level in enumerate(LEVELS)],
        darks=[(t, stack(codes_of(camera, 0.0, seed=60, time_s=t), whole)) for t in (0.001, 5.0, 15.0, 30.0)],
        brightest=exposed(3.0, seed=70, count=2),
    )


@pytest.fixture(scope="module")
def mono() -> camsim.Camera:
    return load_camera("mono-345", lens=camsim.Airy(f_number=8.0)).replace(rows=SIDE, cols=SIDE)


@pytest.fixture(scope="module")
def small(mono: camsim.Camera) -> camsim.Camera:
    return mono.replace(rows=90, cols=90)


def test_a_machine_vision_camera_gives_back_its_profile(mono: camsim.Camera) -> None:
    found = measured(mono)
    # What stands in sensors/mono-345.yaml, and how far off it may be.
    for name, value, tolerance in (
        ("gain_dn_per_e", 1 / 2.7, 0.005),
        ("read_noise_e", math.hypot(2.4, math.sqrt(2.0 * 0.001)), 0.01),
        ("full_well_e", 10_700.0, 0.005),
        ("dark_current_e_per_s", 2.0, 0.02),
        ("dsnu_e", 0.6, 0.02),
        ("prnu", 0.005, 0.02),
    ):
        estimate = getattr(found, name)
        assert estimate.measurable, name
        assert abs(estimate.value - value) <= max(tolerance * value, STATISTICAL * estimate.sigma), name
        # And the estimator knows its own error: it is neither blind nor timid.
        assert abs(estimate.value - value) <= STATISTICAL * estimate.sigma, name
        assert estimate.sigma < 0.5 * value, name
    assert found.linearity_error.value < 0.001


def test_a_bent_response_is_seen(small: camsim.Camera) -> None:
    """A loss of 2 % at the full well is a parabola of ±0.25 % about the best line; its mean over levels lies below."""
    bent = small.replace(nonlinearity=camsim.PolynomialResponse((-0.02,), 10_700.0))
    found = measured(bent)
    assert 0.001 < found.linearity_error.value < 0.004


def test_a_clipped_black_is_not_measurable(small: camsim.Camera) -> None:
    low = small.replace(adc=camsim.Adc(bit_depth=12, black_level_dn=1, electrons_per_dn=2.7, base_iso=100.0))
    assert "black is clipped" in measured(low).read_noise_e.why_not


@pytest.mark.parametrize(("cols", "lines"), [(2, (100, 1)), (3, (1, 3))])
def test_a_strip_of_few_columns_has_lines_too(rng: np.random.Generator, cols: int, lines: tuple[int, int]) -> None:
    """Rows, or columns, share offsets and nothing else differs: the stated error of the pattern holds."""
    channel = np.ones((100, cols), dtype=bool)
    stacks = []
    for _ in range(150):
        codes = np.rint(np.broadcast_to(rng.normal(5000.0, 300.0, lines), channel.shape)).astype(np.uint16)
        stacks.append(stack([codes, codes], Photosites(channel)))
    scatter = np.std([s.pattern.dn2 for s in stacks])
    stated = np.mean([s.pattern.sigma_dn2 for s in stacks])
    assert 0.75 < stated / scatter < 1.4


def test_rows_and_columns_are_no_independent_numbers(rng: np.random.Generator) -> None:
    """On noise whose rows share an offset the stated error of the variance holds, over many trials."""
    channel = np.ones((40, 50), dtype=bool)
    stacks = []
    for _ in range(60):
        frames = [rng.normal(500.0, 3.0, (40, 50)) + rng.normal(0.0, 6.0, (40, 1)) for _ in range(8)]
        stacks.append(stack([np.rint(f).astype(np.uint16) for f in frames], Photosites(channel)))
    variance = np.array([s.variance_dn2 for s in stacks])
    assert np.mean(variance) == pytest.approx(9.0 + 36.0 + 1 / 12, rel=0.05)
    stated = np.mean([s.variance_sigma_dn2 for s in stacks])
    assert 0.7 < stated / np.std(variance) < 1.4
    pattern = np.array([s.pattern.dn2 for s in stacks])
    assert np.abs(np.mean(pattern)) < 0.5
