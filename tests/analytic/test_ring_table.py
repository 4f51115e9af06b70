"""Rings along short edges, looked up: against Hankel functions by plain quadrature, and against nodes one by one."""

import math

import numpy as np
import pytest
from scipy import special

import camsim
from camsim.numerics.quadrature import gauss_legendre
from camsim.optics import OpticalSystem
from camsim.rendering.boundary import engine as boundary_engine
from camsim.rendering.boundary import image as boundary_image
from camsim.rendering.boundary import ring_counts
from camsim.rendering.boundary.ring_table import BEYOND, MARGIN, ring_step, ring_table, tabled_part
from camsim.rendering.boundary.rings import (
    oscillation_lengths,
    piece_nodes,
    piece_phases,
    ring_amplitudes,
)
from camsim.rendering.render import plan_render

PITCH_UM = 4.0
AIRY = camsim.Airy(f_number=5.6)
FARTHEST = 60.0


class Rings:
    """A table of two pairs' rings in two channels, and random pieces that it holds for."""

    def __init__(self, lens, blur, turns, tolerance):
        rng = np.random.default_rng(1)
        self.near, self.turns = max(10.0 * blur, 3.0), turns
        self.blur = blur * np.array([0.93, 1.0, 1.06])
        # Another photosite than a square one, turned: nothing but half a turn leaves it as it is.
        height = 1.0 if turns == 4 else 0.6
        x, w = gauss_legendre(14 + math.ceil(6.0 / blur))
        nodes = 0.5 * np.stack(np.meshgrid(x, height * x), axis=-1).reshape(-1, 2)
        angle = 0.0 if turns == 4 else 0.4
        turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
        self.nodes, self.shares = nodes @ turn, 0.25 * np.outer(w, w).ravel()
        self.weights = rng.uniform(-1.0, 1.0, (2, 2, self.blur.size))
        oscillations = lens.pattern().oscillations
        self.amplitude = ring_amplitudes(
            oscillations, self.blur, self.nodes, self.shares, turns=turns, nearest=self.near
        )
        self.lengths, self.phases = oscillation_lengths(oscillations, self.blur), piece_phases(tolerance)
        rows = math.ceil((FARTHEST - self.near) / ring_step(self.lengths.min(), tolerance)) + MARGIN + BEYOND
        self.table = ring_table(
            self.amplitude, self.lengths, self.weights, nearest=self.near, rows=rows, tolerance=tolerance
        )
        distance, angle = rng.uniform(self.near, 0.9 * FARTHEST, 120), rng.uniform(0.0, 2.0 * np.pi, 120)
        long = np.exp(rng.uniform(-3.0, 0.5, 120)) * blur
        short = piece_nodes(long, self.lengths.min(), tolerance) > 0.0
        self.pieces = [
            (r * math.sin(a), (r * math.cos(a), r * math.cos(a) + size), complex(np.exp(1j * rng.uniform(0.0, 6.3))))
            for r, a, size in zip(distance[short], angle[short], long[short], strict=True)
            if math.hypot(r * math.sin(a), r * math.cos(a) + size) > self.near
        ]
        # Rings fall by r³, and more where pieces are met square on, or where the footprint lets little pass.
        self.sizes = np.array([(b - a) / math.hypot(h, 0.5 * (a + b)) ** 3 for h, (a, b), _ in self.pieces])
        assert len(self.pieces) > 60

    def looked_up(self, pair, channel):
        values = self.table.values[pair, channel]
        assert max(math.hypot(h, s) for h, ends, _ in self.pieces for s in ends) < self.table.until
        return np.array([tabled_part(*piece, values, self.table, self.turns, self.phases) for piece in self.pieces])

    def by_hankel_functions(self, pair, channel):
        """−V·n along each piece, V = (E − smooth powers)·d/2πd² averaged: of 1 − E ½·Re (H0² + H1²) oscillates."""
        x, w = np.polynomial.legendre.leggauss(16)
        found = []
        for h, (s1, s2), way in self.pieces:
            along = 0.5 * (s1 + s2) + 0.5 * (s2 - s1) * x
            tx, ty = way.real, way.imag
            places = np.multiply.outer(along, [tx, ty]) - h * np.array([-ty, tx])
            d = places[:, None] + self.nodes
            r = np.hypot(d[..., 0], d[..., 1])
            swings = np.zeros_like(r)
            for blur, weight in zip(self.blur, self.weights[pair, channel], strict=True):
                u = np.pi * r / blur
                swings += (
                    weight * 0.5 * (special.j0(u) ** 2 - special.y0(u) ** 2 + special.j1(u) ** 2 - special.y1(u) ** 2)
                )
            across = -(d @ np.array([-ty, tx])) * -swings / (2.0 * np.pi * r**2)
            found.append(0.5 * (s2 - s1) * w @ across @ self.shares)
        return np.array(found)


@pytest.mark.parametrize(("turns", "blur"), [(2, 0.3), (4, 1.0), (2, 3.0)])
def test_pieces_by_hankel_functions(blur, turns):
    """The sign of an angle, a wavelength, a harmonic: any of them left out would be as large as the rings are."""
    rings = Rings(AIRY, blur, turns, 1e-9)
    found, true = rings.looked_up(0, 1), rings.by_hankel_functions(0, 1)
    strongest = np.abs(true / rings.sizes).max()
    # Amplitudes hold to 1e-6 of themselves.
    assert np.abs((found - true) / rings.sizes).max() <= 2e-6 * strongest


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
