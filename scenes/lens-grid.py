"""The twin of lens-grid.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=5.6))
scene = camsim.Scene(
    background=0.9,
    shapes=[
        camsim.charts.lens_grid(
            width_um=300 * PITCH_UM, height_um=200 * PITCH_UM, cols=11, rows=7, side_um=14 * PITCH_UM
        ),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light(line_nm=550, illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=220, cols=320),
    tolerance=1e-4,
    seed=1,
)
