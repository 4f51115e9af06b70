"""The twin of colorchecker-card.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 4.88

camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=5.6))
scene = camsim.Scene(
    background=0.18,
    shapes=[
        camsim.charts.colorchecker(width_um=180 * PITCH_UM, rotate_deg=3, spectra="BabelColor Average"),
    ],
)
frame = camera.expose(
    scene,
    light=camsim.Light("D65", illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=150, cols=210),
    tolerance=1e-3,
    seed=1,
)
