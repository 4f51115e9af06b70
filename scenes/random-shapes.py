"""The twin of random-shapes.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 4.88

camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=5.6))
scene = camsim.Scene(
    background=0.35,
    shapes=[
        camsim.charts.random(width_um=140 * PITCH_UM, height_um=110 * PITCH_UM, shapes=40, seed=11),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light("D65", illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=100, cols=130),
    tolerance=1e-3,
    seed=1,
)
