"""The twin of lens-grid.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=5.6))
scene = camsim.Scene(
    background=0.9,
    shapes=[
        camsim.charts.lens_grid(
            width_um=640 * PITCH_UM, height_um=440 * PITCH_UM, cols=7, rows=5, side_um=56 * PITCH_UM, rotate_deg=5
        ),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light(line_nm=550, illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=520, cols=720),
    tolerance=1e-4,
    seed=1,
)
