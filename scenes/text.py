"""The twin of text.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=4))
scene = camsim.Scene(
    background=0.9,
    shapes=[
        camsim.Text(
            text="exact optics 0123", size_um=24 * PITCH_UM, at_um=(0, -30 * PITCH_UM), align="centre", reflectance=0.05
        ),
        camsim.Text(
            text="exact optics 0123456789", size_um=14 * PITCH_UM, at_um=(0, 0), align="centre", reflectance=0.05
        ),
        camsim.Text(
            text="exact optics 0123456789",
            size_um=9 * PITCH_UM,
            at_um=(0, 22 * PITCH_UM),
            align="centre",
            weight="Bold",
            reflectance=0.05,
        ),
        camsim.Text(
            text="exact optics 0123456789",
            size_um=6 * PITCH_UM,
            at_um=(0, 38 * PITCH_UM),
            align="centre",
            reflectance=0.05,
        ),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light(line_nm=550, illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=110, cols=240),
    tolerance=1e-3,
    seed=1,
)
