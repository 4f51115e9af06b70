"""The twin of starfield.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=8))
scene = camsim.Scene(
    background=0.001,
    shapes=[
        camsim.charts.points(
            radius_um=1 * PITCH_UM, stars=120, width_um=190 * PITCH_UM, height_um=140 * PITCH_UM, faintest=5, seed=2
        ),
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
