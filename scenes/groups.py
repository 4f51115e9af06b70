"""The twin of groups.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 3.45

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=4))
scene = camsim.Scene(
    background=0.9,
    shapes=[
        camsim.RepeatOnGrid(
            cols=4,
            rows=5,
            step_um=(14 * PITCH_UM, 18 * PITCH_UM),
            shapes=[camsim.Disc(radius_um=5 * PITCH_UM, centre_um=(-80 * PITCH_UM, 0), reflectance=0.2)],
        ),
        camsim.RepeatOnRing(
            count=12,
            shapes=[
                camsim.Rectangle(
                    width_um=16 * PITCH_UM, height_um=5 * PITCH_UM, centre_um=(36 * PITCH_UM, 0), reflectance=0.05
                )
            ],
        ),
        camsim.Group(
            mirror="left-right",
            move_um=(80 * PITCH_UM, 0),
            clip=camsim.Disc(radius_um=32 * PITCH_UM, reflectance=0),
            shapes=[
                camsim.Rectangle(width_um=80 * PITCH_UM, height_um=80 * PITCH_UM, reflectance=0.6),
                camsim.Text(text="R", size_um=70 * PITCH_UM, align="centre", vertical="middle", reflectance=0.05),
            ],
        ),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light(line_nm=550, illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=130, cols=240),
    tolerance=1e-4,
    seed=1,
)
