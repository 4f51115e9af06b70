"""The twin of leaves-in-colour.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 4.88
NAMES = ["dark skin", "light skin", "blue sky", "foliage", "blue flower", "bluish green", "orange", "purplish blue"]
NAMES += ["moderate red"]

camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=5.6))
scene = camsim.Scene(
    background=0.35,
    shapes=[
        camsim.charts.dead_leaves(
            width_um=114 * PITCH_UM,
            height_um=84 * PITCH_UM,
            least_radius_um=3 * PITCH_UM,
            largest_radius_um=20 * PITCH_UM,
            seed=5,
            palette=[camsim.reflectance(name) for name in NAMES],
        ),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light("D65", illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=80, cols=110),
    tolerance=1e-3,
    seed=1,
)
