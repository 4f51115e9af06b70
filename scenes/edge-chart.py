"""The twin of edge-chart.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 4.88
ANGLES_DEG = [3, 5, 8, 12, 17, 22, 12, 17, 22, -4, -7, -10, -4, -7, -10, -15, -20, -25, -15, -20, -25, 3, 5, 8]
LEVELS = [
    *(0.05, 0.2, 0.45, 0.6, 0.05, 0.2, 0.2, 0.45, 0.6, 0.05, 0.2, 0.45),
    *(0.45, 0.6, 0.05, 0.2, 0.45, 0.6, 0.6, 0.05, 0.2, 0.45, 0.6, 0.05),
]
PLACES = [(x, y) for y in (-705, -235, 235, 705) for x in (-1200, -720, -240, 240, 720, 1200)]

camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=5.6))
squares = [
    camsim.Rectangle(
        width_um=240 * PITCH_UM,
        height_um=240 * PITCH_UM,
        centre_um=(x * PITCH_UM, y * PITCH_UM),
        rotate_deg=angle_deg,
        reflectance=level,
    )
    for (x, y), angle_deg, level in zip(PLACES, ANGLES_DEG, LEVELS, strict=True)
]
frame = camera.expose(
    camsim.Scene(background=0.9, shapes=squares),
    light=camsim.Light("D55", illuminance_lux=5000),
    exposure=camsim.Exposure(time_s=0.01, iso=200),
    tolerance=1e-5,
    seed=1,
)
