"""Charts as they were photographed: the star's contrast is the system's MTF, ghosts are where theory puts them."""

import io

import numpy as np
import zxingcpp
from PIL import Image

import camsim

PITCH_UM, WAVELENGTH_NM = 4.0, 500.0
LENS, PHOTOSITE = camsim.Airy(f_number=5.6), camsim.SquarePhotosite(side_um=3.0)


def rendered(chart, rows, cols, optics, **window):
    grid = camsim.Grid(rows=rows, cols=cols, pitch_um=PITCH_UM, **window)
    scene = camsim.Scene(background=0.5, shapes=[chart])
    found = camsim.render(scene, optics, grid, wavelength_nm=WAVELENGTH_NM, tolerance=1e-4)
    assert found.error_estimate <= 1e-4
    y, x = np.indices((rows, cols)) + 0.5 - 0.5 * np.array([rows, cols])[:, None, None]
    return found.image, x, y


def mtf(optics, frequency, angle):
    """Of lens, OLPF and photosite, at cycles per pitch."""
    fx, fy = frequency / PITCH_UM * np.cos(angle), frequency / PITCH_UM * np.sin(angle)
    return np.prod([stage.otf(fx, fy, WAVELENGTH_NM) for stage in optics], axis=0)


def test_contrast_of_the_siemens_star_is_the_mtf():
    """Of hard sectors the fundamental has 4/π of their contrast; at radius r it has cycles/(2π·r).

    Averages over a circle take those of the MTF over all directions; a ring of photosites is fitted by the fundamental,
    the third harmonic and their change with the radius.
    """
    cycles, side = 24, 72
    star = camsim.charts.siemens_star(radius_um=60.0 * PITCH_UM, cycles=cycles, dark=0.1, light=0.9, rotate_deg=2.0)
    image, x, y = rendered(star, side, side, [LENS, PHOTOSITE])
    radius, angle = np.hypot(x, y), np.arctan2(y, x) - np.radians(2.0)
    every = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    for middle in (9.0, 12.0, 16.0, 22.0, 30.0):
        ring = np.abs(radius - middle) < 1.5
        r, phi = radius[ring] - middle, cycles * angle[ring]
        assert cycles / (2.0 * np.pi * middle) < 0.5
        waves = [f(k * phi) for k in (1, 3) for f in (np.cos, np.sin)]
        basis = np.stack([np.ones_like(r), *waves, *(wave * r for wave in waves), *(wave * r**2 for wave in waves)])
        fitted = np.linalg.lstsq(basis.T, image[ring], rcond=None)[0]
        expected = mtf([LENS, PHOTOSITE], cycles / (2.0 * np.pi * middle), every).mean()
        contrast = -fitted[1] / (0.4 * 4.0 / np.pi)
        assert abs(contrast / expected - 1.0) < 5e-3, middle
        assert abs(fitted[2]) < 2e-3


def test_the_zone_plate_s_ghosts_are_where_theory_puts_them():
    """Where the rings have one line pair per photosite, photosites see a second middle: cos(π·k·(u² + v²)) about there,
    with the fundamental's contrast at that frequency; the OLPF, whose transfer is nearly zero there, takes it away."""
    rim, cycles_per_pitch = 26.0, 1.25
    plate = camsim.charts.zone_plate(
        radius_um=rim * PITCH_UM, rim_period_um=PITCH_UM / cycles_per_pitch, dark=0.1, light=0.9
    )
    at, k = rim / cycles_per_pitch, cycles_per_pitch / rim
    sharp = camsim.Airy(f_number=2.8)
    seen = {}
    for name, optics in (
        ("none", [sharp, PHOTOSITE]),
        ("olpf", [sharp, camsim.FourSpotOlpf(split_um=0.5 * PITCH_UM), PHOTOSITE]),
    ):
        image, x, y = rendered(plate, 9, 50, optics)
        near = np.hypot(x - at, y) < 3.6
        square = np.pi * k * ((x - at) ** 2 + y**2)[near]
        basis = np.stack([np.ones_like(square), np.cos(square), np.sin(square)])
        fitted = np.linalg.lstsq(basis.T, image[near], rcond=None)[0]
        seen[name] = np.hypot(*fitted[1:])
    assert abs(seen["none"] / (0.4 * 4.0 / np.pi * mtf([sharp, PHOTOSITE], 1.0, 0.0)) - 1.0) < 0.05
    assert seen["olpf"] < 0.1 * seen["none"]


def test_a_qr_code_is_read_off_the_developed_picture(tmp_path):
    """Turned, blurred, mosaicked, noisy and developed: by an independent reader, who does not read mirrored codes."""
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=5.6))
    code = camsim.charts.qr(text="camsim: exact optics", width_um=100 * camera.pitch_um, rotate_deg=10.0)
    frame = camera.expose(
        camsim.Scene(background=0.4, shapes=[code]),
        light=camsim.Light(line_nm=550, illuminance_lux=2000),
        exposure=camsim.Exposure(time_s="auto", iso=400),
        region=camsim.Region(rows=128, cols=128),
        tolerance=1e-3,
        seed=1,
        products=("mosaic", "preview"),
    )
    camsim.save(frame, tmp_path / "code.png")
    picture = Image.open(io.BytesIO((tmp_path / "code.png").read_bytes())).convert("L").resize((512, 512))
    (found,) = zxingcpp.read_barcodes(np.asarray(picture))
    assert found.text == "camsim: exact optics"
    # Upright: its position marks are at the upper left, upper right and lower left.
    assert abs(found.orientation - 10) <= 2
