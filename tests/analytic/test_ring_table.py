"""Rings along short edges, looked up: the same images as by nodes one by one."""

import numpy as np
import pytest

import camsim
from camsim.optics import OpticalSystem
from camsim.rendering.boundary import engine as boundary_engine
from camsim.rendering.boundary import image as boundary_image
from camsim.rendering.boundary import ring_counts
from camsim.rendering.render import plan_render

PITCH_UM = 4.0


RED = camsim.Curve((450.0, 700.0), (0.05, 0.9), outside="hold")
GREYS_AND_RED = [(0.4, 1.0, 0.9), (2.0, 0.6, RED), (35.0, 0.7, 0.4)]


def planned(lens, olpf, radius, tolerance, waves, side=5):
    """Discs of three colours in two channels; jumps of greys are one another's multiples."""
    wavelength = np.linspace(500.0, 600.0, waves)
    discs = [
        camsim.Disc(radius_um=size * radius * PITCH_UM, centre_um=(x * PITCH_UM, 0.0), reflectance=reflectance)
        for x, size, reflectance in GREYS_AND_RED
    ]
    response = np.stack([wavelength / wavelength.sum(), wavelength[::-1] / wavelength.sum()])
    photosite = camsim.RectangularPhotosite(width_um=PITCH_UM, height_um=0.7 * PITCH_UM)
    square = camsim.SquarePhotosite(side_um=0.8 * PITCH_UM)
    return plan_render(
        camsim.Scene(background=0.1, shapes=discs),
        OpticalSystem.of([lens, photosite, olpf] if olpf else [lens, square]),
        camsim.Grid(rows=side, cols=side, pitch_um=PITCH_UM),
        response=response,
        wavelength_nm=wavelength,
        tolerance=tolerance,
        method="boundary",
    ).plan


def image_of(plan, side=5):
    channel = np.indices((side, side)).sum(axis=0).astype(np.uint8) % 2
    return np.concatenate(list(plan.bands(channel, lambda done: None)))


TURNED = camsim.TwoSpotOlpf(split_um=0.5 * PITCH_UM, rotate_deg=30.0)
SYSTEMS = {
    "as far as the scene": (camsim.Airy(f_number=7.0), None, 20.0, 1e-8, 9),
    "obstructed, turned, at 1e-9": (camsim.AnnularAiry(f_number=7.0, obstruction=0.4), TURNED, 14.0, 1e-9, 3),
    "one wavelength": (camsim.Airy(f_number=2.2), TURNED, 20.0, 1e-9, 1),
    "in foci alone": (camsim.Airy(f_number=3.6), None, 20.0, 1e-6, 12),
}


@pytest.mark.parametrize("system", list(SYSTEMS))
def test_images_by_a_table_by_half_of_one_and_by_none(system, monkeypatch):
    whole = planned(*SYSTEMS[system])
    tolerance = SYSTEMS[system][3]
    rows = whole.counts.ring_rows
    assert rows > 0
    if system == "in foci alone":
        assert whole.settings.negligible_end == whole.settings.near
        assert len(whole.settings.foci.radius)
    image = image_of(whole)
    values = 0.0
    for part in (0.0, 0.6):
        monkeypatch.setattr(ring_counts, "RING_BYTES", 8.0 * part * values)
        plan = planned(*SYSTEMS[system])
        assert (0 < plan.counts.ring_rows < 0.7 * rows) if part else plan.counts.ring_rows == 0
        assert np.abs(image_of(plan) - image).max() <= 1e-5 * tolerance
        values = whole.counts.table_values - plan.counts.table_values
    table = boundary_image.ring_table

    def silent(*given, **named):
        made = table(*given, **named)
        return made._replace(values=0.0 * made.values)

    monkeypatch.setattr(boundary_image, "ring_table", silent)
    # Where they meet in foci alone they are as loud as is allowed in the very middle, and no photosite is there.
    assert np.abs(image_of(whole) - image).max() > (0.01 if system == "in foci alone" else 1.0) * tolerance


def test_one_photosite_has_no_table(monkeypatch):
    """It would take longer to make than to do without; all parts of a photosite may have one together."""
    monkeypatch.setattr(boundary_engine, "MOST_PARTS", 0)
    lens, olpf, _, *rest = SYSTEMS["one wavelength"]
    many, one = (planned(lens, olpf, 5.0, *rest, side=side).counts for side in (8, 1))
    assert many.ring_rows
    assert not one.ring_rows
    assert one.ring_terms
