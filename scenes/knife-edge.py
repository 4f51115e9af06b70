"""The twin of knife-edge.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 4.88

camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=4))
edge = camsim.Rectangle(
    width_um=4000 * PITCH_UM,
    height_um=8000 * PITCH_UM,
    centre_um=(1995.1282 * PITCH_UM, 139.5130 * PITCH_UM),
    rotate_deg=4,
    reflectance=0.05,
)
frame = camera.expose(
    camsim.Scene(background=0.9, shapes=[edge]),
    light=camsim.Light("D55", illuminance_lux=5000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=1600, cols=240),
    tolerance=1e-6,
    seed=1,
)
