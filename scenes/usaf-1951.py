"""The twin of usaf-1951.yaml: the same picture, byte by byte."""

import camsim

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=4))
scene = camsim.Scene(
    background=0.5,
    shapes=[
        camsim.charts.usaf_1951(groups=[4, 5, 6, 7], light=0.9),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light(line_nm=550, illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=250, cols=310),
    tolerance=1e-3,
    seed=1,
)
