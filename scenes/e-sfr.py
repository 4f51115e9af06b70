"""The twin of e-sfr.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=5.6))
scene = camsim.Scene(
    background=0.2,
    shapes=[
        camsim.charts.e_sfr(height_um=240 * PITCH_UM),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light(line_nm=550, illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=250, cols=380),
    tolerance=1e-4,
    seed=1,
)
