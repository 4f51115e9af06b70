"""The twin of zone-plate.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=2.8))
scene = camsim.Scene(
    background=0.5,
    shapes=[
        camsim.charts.zone_plate(radius_um=56 * PITCH_UM, rim_period_um=0.833333 * PITCH_UM),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light(line_nm=550, illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=120, cols=120),
    tolerance=1e-3,
    seed=1,
)
