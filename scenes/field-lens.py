"""The twin of field-lens.yaml: the same picture, byte by byte."""

import camsim

camera = camsim.Camera.from_yaml("mono-345", lens=camsim.read_lens("double-gauss"))
square = camsim.Rectangle(width_um=200, height_um=130, centre_um=(-3380, -2740), rotate_deg=5, reflectance=0.05)
frame = camera.expose(
    camsim.Scene(background=0.9, shapes=[square]),
    light=camsim.Light(line_nm=550, illuminance_lux=5000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=64, cols=96, origin=(200, 200)),
    tolerance=1e-4,
    seed=1,
)
