"""The twin of bars.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=4))
scene = camsim.Scene(
    background=0.5,
    shapes=[
        camsim.charts.bars(lp_per_mm=[50, 100, 140], pairs=9, length_um=60 * PITCH_UM, light=0.9),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light(line_nm=550, illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=100, cols=240),
    tolerance=1e-4,
    seed=1,
)
