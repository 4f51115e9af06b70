"""The twin of drawing.yaml: the same picture, byte by byte."""

from pathlib import Path

import camsim

PITCH_UM = 4.88

camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=5.6))
scene = camsim.Scene(
    background=0.9,
    shapes=[
        camsim.read_svg(
            Path(__file__).with_name("drawing.svg"),
            width_um=170 * PITCH_UM,
            palette={"navy": camsim.reflectance("blue"), "crimson": camsim.reflectance("red")},
        ),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light("D65", illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=120, cols=180),
    tolerance=1e-3,
    seed=1,
)
