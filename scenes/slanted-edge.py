"""The twin of slanted-edge.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 4.88

camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8, transmission=1.0))
square = camsim.Rectangle(width_um=250 * PITCH_UM, height_um=250 * PITCH_UM, rotate_deg=4, reflectance=0.05)
frame = camera.expose(
    camsim.Scene(background=0.9, shapes=[square]),
    light=camsim.Light("D55", illuminance_lux=5000),
    exposure=camsim.Exposure(time_s=0.01, iso=200),
    region=camsim.Region(rows=446, cols=446),
    tolerance=1e-6,
    seed=1,
)
