"""The twin of colorchecker.yaml: the same picture, byte by byte."""

import camsim

PITCH_UM = 4.88
NAMES = [
    *("dark skin", "light skin", "blue sky", "foliage", "blue flower", "bluish green"),
    *("orange", "purplish blue", "moderate red", "purple", "yellow green", "orange yellow"),
    *("blue", "green", "red", "yellow", "magenta", "cyan"),
    *("white 9.5", "neutral 8", "neutral 6.5", "neutral 5", "neutral 3.5", "black 2"),
]
PLACES = [(x, y) for y in (-108, -36, 36, 108) for x in (-180, -108, -36, 36, 108, 180)]

camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=5.6, transmission=1.0))
patches = [
    camsim.Rectangle(
        width_um=60 * PITCH_UM,
        height_um=60 * PITCH_UM,
        centre_um=(x * PITCH_UM, y * PITCH_UM),
        reflectance=camsim.reflectance(name),
    )
    for (x, y), name in zip(PLACES, NAMES, strict=True)
]
frame = camera.expose(
    camsim.Scene(background=0.05, shapes=patches),
    light=camsim.Light("D65", illuminance_lux=2000),
    exposure=camsim.Exposure(time_s="auto", iso=200),
    region=camsim.Region(rows=300, cols=444),
    tolerance=1e-6,
    seed=1,
)
