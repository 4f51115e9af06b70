"""The twin of edge-grid.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=5.6))
scene = camsim.Scene(
    background=0.9,
    shapes=[
        camsim.charts.slanted_edges(
            side_um=36 * PITCH_UM, rows=2, cols=4, spacing_um=60 * PITCH_UM, angles_deg=[3, 6, 12, 20], dark=[0.05, 0.4]
        ),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light(line_nm=550, illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=140, cols=260),
    tolerance=1e-4,
    seed=1,
)
