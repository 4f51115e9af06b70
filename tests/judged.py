"""A small picture with its truth, for the judge of demosaicing: greys with fine detail, and some colours."""

from __future__ import annotations

import functools

import camsim

GREY = tuple(
    camsim.Disc(radius_um=4.88 * radius, centre_um=(10.0, -6.0), reflectance=0.1 + 0.7 * (k % 2))
    for k, radius in enumerate((26.0, 23.5, 21.0, 18.5, 16.0, 13.5, 11.0, 8.5, 6.0))
)
COLOURED = (
    camsim.Rectangle(
        width_um=90.0, height_um=110.0, centre_um=(-90, -80), rotate_deg=12.0, reflectance=camsim.reflectance("orange")
    ),
    camsim.Rectangle(
        width_um=90.0, height_um=110.0, centre_um=(80, 85), rotate_deg=-9.0, reflectance=camsim.reflectance("blue sky")
    ),
    camsim.Rectangle(
        width_um=80.0, height_um=80.0, centre_um=(-90, 90), rotate_deg=20.0, reflectance=camsim.reflectance("foliage")
    ),
)


@functools.cache
def capture(cfa: str = "RGGB", *, coloured: bool = True, side: int = 96, noise: bool = False) -> camsim.Capture:
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=5.6))
    return camsim.Capture(
        camera=camera.replace(olpf=None, cfa=camsim.Cfa.bayer(cfa)),
        scene=camsim.Scene(background=0.45, shapes=[*GREY, *(COLOURED if coloured else ())]),
        light=camsim.Light("D65", illuminance_lux=2000.0),
        exposure=camsim.Exposure(time_s="auto", iso=200.0),
        region=camsim.Region(rows=side, cols=side),
        tolerance=1e-3,
        noise=noise,
        scene_name="rings",
    )


@functools.cache
def frame(cfa: str = "RGGB", *, coloured: bool = True) -> camsim.Frame:
    return capture(cfa, coloured=coloured).frame(products=("mosaic", "truth"))
