"""The twin of grey-steps.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=5.6))
scene = camsim.Scene(
    background=0.18,
    shapes=[
        camsim.charts.step_wedge(
            width_um=240 * PITCH_UM,
            height_um=50 * PITCH_UM,
            densities=[0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95, 1.1, 1.25, 1.4, 1.7, 2.0],
        ),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light("D65", illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=80, cols=260),
    tolerance=1e-4,
    seed=1,
)
