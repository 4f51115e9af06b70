"""The twin of shapes.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 4.88


def at(x, y):
    """Return a place given in photosites."""
    return x * PITCH_UM, y * PITCH_UM


camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=5.6))
scene = camsim.Scene(
    background=0.9,
    shapes=[
        camsim.Rectangle(
            width_um=30 * PITCH_UM,
            height_um=20 * PITCH_UM,
            centre_um=at(-75, -30),
            rotate_deg=15,
            reflectance=camsim.reflectance("dark skin"),
        ),
        camsim.Polygon(points_um=[at(-50, -42), at(-24, -38), at(-34, -14)], reflectance=camsim.reflectance("blue")),
        camsim.RegularPolygon(
            sides=6, radius_um=15 * PITCH_UM, centre_um=at(0, -28), reflectance=camsim.reflectance("green")
        ),
        camsim.Star(
            tips=5,
            radius_um=17 * PITCH_UM,
            inner_radius_um=7 * PITCH_UM,
            centre_um=at(38, -28),
            rotate_deg=-90,
            reflectance=camsim.reflectance("red"),
        ),
        camsim.Disc(radius_um=14 * PITCH_UM, centre_um=at(78, -28), reflectance=camsim.reflectance("yellow")),
        camsim.Ellipse(
            radius_x_um=17 * PITCH_UM,
            radius_y_um=10 * PITCH_UM,
            centre_um=at(-75, 26),
            rotate_deg=-20,
            reflectance=camsim.reflectance("magenta"),
        ),
        camsim.Ring(
            radius_um=16 * PITCH_UM,
            inner_radius_um=9 * PITCH_UM,
            centre_um=at(-34, 26),
            reflectance=camsim.reflectance("cyan"),
        ),
        camsim.Sector(
            radius_um=17 * PITCH_UM,
            from_deg=30,
            turn_deg=300,
            centre_um=at(4, 26),
            reflectance=camsim.reflectance("orange"),
        ),
        camsim.Path(
            segments_um=[
                ("move", *at(28, 40)),
                ("cubic", *at(26, 0), *at(60, 20), *at(42, 28)),
                ("arc", 9 * PITCH_UM, 9 * PITCH_UM, 0, 0, 1, *at(56, 40)),
                ("close",),
            ],
            reflectance=camsim.reflectance("black 2"),
        ),
        camsim.Line(
            segments_um=[("move", *at(68, 42)), ("line", *at(76, 12)), ("line", *at(92, 40))],
            width_um=5 * PITCH_UM,
            join="round",
            cap="round",
            reflectance=camsim.reflectance("neutral 5"),
        ),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light("D65", illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=120, cols=200),
    tolerance=1e-3,
    seed=1,
)
