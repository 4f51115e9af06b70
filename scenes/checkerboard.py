"""The twin of checkerboard.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=4))
scene = camsim.Scene(
    background=0.5,
    shapes=[
        camsim.charts.checkerboard(side_um=18 * PITCH_UM, rows=6, cols=8, rotate_deg=7, light=0.9),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light(line_nm=550, illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=150, cols=200),
    tolerance=1e-4,
    seed=1,
)
