"""Crowds of round things and letters by transforms keep every tolerance at every photosite, judged by the other engine.

Where rings of a crowd fall silent the pattern is cut; what is beyond goes on coarser lattices, tile by tile.
"""

import numpy as np
import pytest

import camsim
from camsim.optics import OpticalSystem
from camsim.rendering import render_channels

PITCH_UM = 5.0
WAVELENGTH_NM = np.linspace(430.0, 670.0, 33)
RESPONSE = np.exp(-(((WAVELENGTH_NM - np.array([[620.0], [540.0], [460.0]])) / 35.0) ** 2))
RESPONSE /= RESPONSE.sum(axis=1, keepdims=True)


def leaves(rows, cols, count, seed):
    """Discs of greys, some of them far outside the frame."""
    return camsim.charts.dead_leaves(
        width_um=cols * PITCH_UM,
        height_um=rows * PITCH_UM,
        least_radius_um=2.0 * PITCH_UM,
        largest_radius_um=40.0 * PITCH_UM,
        discs=count,
        seed=seed,
    )


def crowd(kind, rows, cols):
    rng = np.random.default_rng(4)
    places = rng.uniform(-0.7, 0.7, (60, 2)) * (cols * PITCH_UM, rows * PITCH_UM)
    size, grey = rng.uniform(2.0, 9.0, 60) * PITCH_UM, rng.uniform(0.02, 0.98, 60)
    turn = rng.uniform(0.0, 360.0, 60)
    if kind == "discs":
        return [leaves(rows, cols, 200, 3)]
    if kind == "ellipses":
        return [
            camsim.Ellipse(radius_x_um=r, radius_y_um=0.4 * r, centre_um=tuple(p), rotate_deg=a, reflectance=g)
            for p, r, g, a in zip(places.tolist(), size.tolist(), grey.tolist(), turn.tolist(), strict=True)
        ]
    if kind == "rings":
        return [
            camsim.Ring(radius_um=r, inner_radius_um=0.6 * r, centre_um=tuple(p), reflectance=g)
            for p, r, g in zip(places.tolist(), size.tolist(), grey.tolist(), strict=True)
        ]
    text = "\n".join(["aBcSdgQ&R8"] * 4)
    return [camsim.Text(text=text, size_um=14.0 * PITCH_UM, align="centre", vertical="middle", reflectance=0.1)]


def rendered(shapes, method, tolerance, shape, response, stages):
    rows, cols = shape
    channel = (np.arange(rows)[:, None] + np.arange(cols)) % len(response)
    return render_channels(
        camsim.Scene(background=0.35, shapes=shapes),
        OpticalSystem.of(stages),
        camsim.Grid(rows=rows, cols=cols, pitch_um=PITCH_UM),
        response=response,
        wavelength_nm=WAVELENGTH_NM[: response.shape[1]],
        channel=channel.astype(np.uint8),
        method=method,
        tolerance=tolerance,
    ).image


STAGES = [camsim.Airy(f_number=5.6), camsim.SquarePhotosite(side_um=PITCH_UM)]


@pytest.mark.parametrize("kind", ["discs", "ellipses", "rings", "letters"])
def test_crowds_keep_every_tolerance(kind):
    shape = (16, 26)
    shapes = crowd(kind, *shape)
    finest = 1e-6 if kind == "discs" else 1e-5
    truth = rendered(shapes, "boundary", finest, shape, RESPONSE, STAGES)
    for tolerance in (1e-2, 1e-3, 1e-4):
        image = rendered(shapes, "fourier", tolerance, shape, RESPONSE, STAGES)
        assert np.abs(image - truth).max() <= 0.2 * tolerance


def test_one_wavelength_keeps_its_rings():
    """One wavelength's rings never fall silent: the pattern is cut far out, or not at all."""
    shape = (16, 26)
    shapes = crowd("discs", *shape)
    truth = rendered(shapes, "boundary", 1e-6, shape, np.ones((1, 1)), STAGES)
    for tolerance in (1e-2, 1e-3, 1e-4):
        image = rendered(shapes, "fourier", tolerance, shape, np.ones((1, 1)), STAGES)
        assert np.abs(image - truth).max() <= 0.5 * tolerance
