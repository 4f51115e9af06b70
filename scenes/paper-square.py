"""The twin of paper-square.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 4.88

camera = camsim.Camera.from_yaml("paper-488", lens=camsim.Airy(f_number=8, transmission=1.0))
square = camsim.Rectangle(width_um=250 * PITCH_UM, height_um=250 * PITCH_UM, rotate_deg=4, reflectance=0.0)
frame = camera.expose(
    camsim.Scene(background=1.0, shapes=[square]),
    light=camsim.Light(line_nm=550, illuminance_lux=5000),
    exposure=camsim.Exposure(time_s="auto", iso=100),
    region=camsim.Region(rows=446, cols=446),
    tolerance=1e-6,
    noise=False,
)
