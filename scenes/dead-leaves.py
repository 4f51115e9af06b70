"""The twin of dead-leaves.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=4))
scene = camsim.Scene(
    background=0.35,
    shapes=[
        camsim.charts.dead_leaves(
            width_um=124 * PITCH_UM,
            height_um=94 * PITCH_UM,
            least_radius_um=2.5 * PITCH_UM,
            largest_radius_um=20 * PITCH_UM,
            seed=3,
        ),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light(line_nm=550, illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=90, cols=120),
    tolerance=1e-3,
    seed=1,
)
