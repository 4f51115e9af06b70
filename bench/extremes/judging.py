"""Stiff and extreme cases: each is right to its tolerance, or refused with a reason; never silently wrong.

Lengths are in pitches of 4 µm unless a case says otherwise. The truth is never the engine that is judged: the boundary
integral by plain quadrature (tests/truth/boundary.py, "quadrature"), the light beyond a straight edge ray by ray
("rays"), the Fourier engine to 1e-10 ("fourier"), or what must come out whatever the optics ("identity").
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import integrate, special

import camsim
from camsim.core.arrays import F64
from camsim.optics import OpticalSystem
from camsim.rendering import render_channels
from tests.truth.lattice import Lens, photosite_value

PITCH_UM = 4.0
ASKED = 1e-6
FINE = 1e-10
Outline = Sequence[tuple[float, float]] | F64


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What came of a case.

    reached : largest error against the truth, of full scale; None where it was refused
    asked   : the tolerance
    seconds : of the rendering, kernels compiled
    verdict : "right", "refused" or "wrong"
    truth   : what judged it; of a refusal the sentence
    """

    reached: float | None
    asked: float
    seconds: float
    verdict: str
    truth: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ExtremeCase:
    """A case by name, in words, and what runs it."""

    name: str
    input: str
    run: Callable[[], Outcome]


def _points_um(outline: Outline, pitch_um: float) -> tuple[tuple[float, float], ...]:
    return tuple((float(x), float(y)) for x, y in np.asarray(outline, float) * pitch_um)


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """Shapes (outline, reflectance) on a background through an Airy lens, OLPF and square photosite; pitches."""

    shapes: Sequence[tuple[Outline, float]]
    lambda_n: float = 1.0
    side: float = 1.0
    split: float = 0.0
    background: float = 0.0
    rows: int = 8
    cols: int = 8
    pitch_um: float = PITCH_UM
    wavelength_nm: float = 500.0
    tolerance: float = ASKED

    @property
    def optics(self) -> list[camsim.optics.OpticalStage]:
        """The stages."""
        f_number = self.lambda_n * self.pitch_um * 1e3 / self.wavelength_nm
        stages: list[camsim.optics.OpticalStage] = [
            camsim.Airy(f_number=f_number),
            camsim.SquarePhotosite(side_um=self.side * self.pitch_um),
        ]
        return [*stages, camsim.FourSpotOlpf(split_um=self.split * self.pitch_um)] if self.split else stages

    @property
    def scene(self) -> camsim.Scene:
        """The scene, µm."""
        shapes = [
            camsim.Polygon(points_um=_points_um(outline, self.pitch_um), reflectance=reflectance)
            for outline, reflectance in self.shapes
        ]
        return camsim.Scene(background=self.background, shapes=shapes)

    def render(self, method: str = "auto", tolerance: float | None = None) -> camsim.Rendering:
        """Render it."""
        return camsim.render(
            self.scene,
            self.optics,
            camsim.Grid(rows=self.rows, cols=self.cols, pitch_um=self.pitch_um),
            wavelength_nm=self.wavelength_nm,
            tolerance=tolerance or self.tolerance,
            method=method,
        )

    def centre(self, row: int, col: int) -> tuple[float, float]:
        """Return x, y of a photosite's centre."""
        return col + 0.5 - 0.5 * self.cols, row + 0.5 - 0.5 * self.rows


Rendered = Callable[[], camsim.Rendering]


def timed(render: Rendered) -> tuple[F64, float]:
    """Return an image, and the seconds of a second rendering: the first may have to compile."""
    render()
    begin = time.perf_counter()
    image = render().image
    return image, time.perf_counter() - begin


def judged(picture: Picture, truth: Callable[[F64], float], words: str, *, render: Rendered | None = None) -> Outcome:
    """Render the picture (or what ``render`` does in its place) and judge.

    truth : image → its largest error
    """
    image, seconds = timed(render or picture.render)
    reached = truth(image)
    scale = max([1.0, picture.background, *(reflectance for _, reflectance in picture.shapes)])
    right = math.isfinite(reached) and reached <= picture.tolerance * scale
    return Outcome(
        reached=reached / scale,
        asked=picture.tolerance,
        seconds=seconds,
        verdict="right" if right else "wrong",
        truth=words,
    )


def by_quadrature(picture: Picture, places: Sequence[tuple[int, int]], *, render: Rendered | None = None) -> Outcome:
    """Judge photosites (row, col) by plain quadrature over the picture's shapes, which may not overlap."""
    lens = Lens(blur=np.array([picture.lambda_n]), weights=np.ones(1))

    def worst(image: F64) -> float:
        errors = []
        for row, col in places:
            x, y = picture.centre(row, col)
            value = picture.background
            for outline, reflectance in picture.shapes:
                share = photosite_value(np.asarray(outline, float), x, y, lens, side=picture.side, split=picture.split)
                value += (reflectance - picture.background) * share
            errors.append(float(abs(value - image[row, col])))
        return max(errors)

    return judged(picture, worst, f"quadrature, {len(places)} photosites", render=render)


def by_fourier(picture: Picture) -> Outcome:
    """Judge the whole image by the Fourier engine to 1e-10."""
    return judged(
        picture,
        lambda image: float(np.abs(image - picture.render("fourier", FINE).image).max()),
        "fourier to 1e-10, all photosites",
    )


def by_identity(picture: Picture, expected: Callable[[], F64 | float], words: str) -> Outcome:
    """Judge the image by what must come out."""
    return judged(picture, lambda image: float(np.abs(image - expected()).max()), f"identity: {words}")


def by_rays(picture: Picture, edge: float, light: float) -> Outcome:
    """Judge photosites in the middle row across a straight vertical edge, bright to its right, by the light per ray."""

    def across(distance: float) -> float:
        def lost(angle: float) -> float:
            x = math.pi * abs(distance) / math.cos(angle) / picture.lambda_n
            return float(special.j0(x) ** 2 + special.j1(x) ** 2)

        beyond = integrate.quad(lost, 0.0, 0.5 * math.pi - 1e-12, limit=4000, epsabs=1e-10)[0] / math.pi
        return 1.0 - beyond if distance >= 0.0 else beyond

    def worst(image: F64) -> float:
        row = picture.rows // 2
        values = [light * across(picture.centre(row, col)[0] - edge) for col in range(picture.cols)]
        return float(np.abs(image[row] - values).max())

    return judged(picture, worst, f"rays, {picture.cols} photosites")


def refused(name: str, words: str, attempt: Callable[[], object]) -> ExtremeCase:
    """Return a case that must be refused in one sentence."""

    def run() -> Outcome:
        begin = time.perf_counter()
        try:
            attempt()
        except camsim.CamsimError as error:
            verdict, sentence = "refused", str(error)
        else:
            verdict, sentence = "wrong", "nothing was said"
        return Outcome(reached=None, asked=ASKED, seconds=time.perf_counter() - begin, verdict=verdict, truth=sentence)

    return ExtremeCase(name=name, input=words, run=run)


def square(side: float, *, centre: tuple[float, float] = (0.0, 0.0), turn_deg: float = 0.0) -> F64:
    """Return the corners of a square."""
    angle = math.radians(turn_deg)
    corners = 0.5 * side * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    outline: F64 = corners @ turn + centre
    return outline


CORNERS = ((0, 0), (1, 2), (4, 4), (7, 3))  # photosites of an 8 × 8 grid: corner, outside, inside, border
SLANTED = square(4.7, centre=(0.3, -0.2), turn_deg=17.0)


def star(corners: int, radius: float) -> F64:
    """Return an outline that goes in and out, not twice alike."""
    angle = 2.0 * np.pi * np.arange(corners) / corners
    wave = radius * (1.0 + 0.2 * np.sin(7 * angle) + 0.05 * np.cos(np.arange(corners) * 2.4))
    outline: F64 = np.stack([wave * np.cos(angle), wave * np.sin(angle)], axis=1)
    return outline


def mesh(count: int, side: float) -> list[F64]:
    """Return count² tiles of a square that share crooked edges, corner for corner."""
    steps = np.linspace(-0.5 * side, 0.5 * side, count + 1)
    x, y = np.meshgrid(steps, steps)
    rng = np.random.default_rng(4)
    shake = rng.uniform(-0.3, 0.3, (2, count + 1, count + 1)) * side / count
    shake[:, [0, -1]] = shake[:, :, [0, -1]] = 0.0
    points = np.stack([x + shake[0], y + shake[1]], axis=-1)
    corners = [points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]]
    return list(np.stack(corners, axis=2).reshape(-1, 4, 2))


def metamers() -> Outcome:
    """Two neighbours that a channel sees alike and that blur differently."""
    violet = camsim.Curve((449.0, 450.0, 451.0), (0.0, 0.8, 0.0))
    red = camsim.Curve((649.0, 650.0, 651.0), (0.0, 0.4, 0.0))
    picture = Picture(shapes=[(square(4.0, centre=(-2.0, 0.0)), 1.0), (square(4.0, centre=(2.0, 0.0)), 1.0)])
    left, right = (np.asarray(outline, float) for outline, _ in picture.shapes)
    scene = camsim.Scene(
        background=0.0,
        shapes=[
            camsim.Polygon(points_um=_points_um(outline, PITCH_UM), reflectance=spectrum)
            for outline, spectrum in ((left, violet), (right, red))
        ],
    )

    def render() -> camsim.Rendering:
        return render_channels(
            scene,
            OpticalSystem.of(picture.optics),
            camsim.Grid(rows=8, cols=8, pitch_um=PITCH_UM),
            response=np.array([[0.5, 1.0]]),
            wavelength_nm=np.array([450.0, 650.0]),
            channel=np.zeros((8, 8), np.uint8),
            tolerance=ASKED,
        )

    image, seconds = timed(render)
    reached = 0.0
    for row, col in CORNERS:
        x, y = picture.centre(row, col)
        value = sum(
            0.4 * photosite_value(outline, x, y, Lens(blur=np.array([nm / 500.0]), weights=np.ones(1)), side=1.0)
            for outline, nm in ((left, 450.0), (right, 650.0))
        )
        reached = max(reached, float(abs(value - image[row, col])) / 1.5)
    verdict = "right" if reached <= ASKED else "wrong"
    return Outcome(
        reached=reached, asked=ASKED, seconds=seconds, verdict=verdict, truth=f"quadrature, {len(CORNERS)} photosites"
    )


def cases() -> tuple[ExtremeCase, ...]:
    """Return every case, in the order in which they are reported."""
    from bench.extremes.rendering_cases import ALL

    return ALL
