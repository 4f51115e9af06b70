"""A window of the frame as it is transformed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import EllipsisType

from camsim.optics.protocols import Span

CHEAPER = 4.0  # times as many products as a transform has points
COARSE, COARSE_POINTS = 1.0 / 16.0, 16  # of a wave, and Lagrange nodes along either axis: 1e-12 of it


@dataclass(frozen=True, slots=True, kw_only=True)
class Tile:
    """A window of the frame and how it is transformed; lengths in pitches.

    row, col, rows, cols : the window
    inner, outer : radii of a round taper; of a rectangle half its sides along x and along y
    periods      : along x and y, whole
    cut          : highest frequency kept, cycles/pitch;  cuts: along x and along y, where the band ends sooner there
    low, high    : corners of what the scene is clamped to, from the tile's first photosite
    middle       : of a rectangle's taper, from where the pattern is brightest
    sharpness    : of the taper, β of its Kaiser–Bessel window
    """

    row: int
    col: int
    rows: int
    cols: int
    inner: tuple[float, float]
    outer: tuple[float, float]
    periods: tuple[int, int]
    cut: float
    low: tuple[float, float]
    high: tuple[float, float]
    cuts: tuple[float, float] = (math.inf, math.inf)
    middle: tuple[float, float] = (0.0, 0.0)
    sharpness: float = 0.0

    @classmethod
    def square(
        cls,
        place: tuple[int, int, int, int],
        *,
        inner: float,
        outer: float,
        period: int,
        cut: float,
        near: float,
    ) -> Tile:
        """Return a window (row, col, rows, cols) that is the same along x and y; near: how far the scene is seen."""
        row, col, rows, cols = place
        return cls(
            row=row,
            col=col,
            rows=rows,
            cols=cols,
            inner=(inner, inner),
            outer=(outer, outer),
            periods=(period, period),
            cut=cut,
            low=(-near, -near),
            high=(cols - 1 + near, rows - 1 + near),
        )

    @property
    def part(self) -> tuple[EllipsisType, slice, slice]:
        """Where it is in an image."""
        return ..., slice(self.row, self.row + self.rows), slice(self.col, self.col + self.cols)

    @property
    def spans(self) -> tuple[Span, Span]:
        """From where to where along x and along y the pattern is taken."""
        (x, y), (across, down) = self.middle, self.outer
        return (x - across, x + across), (y - down, y + down)

    @property
    def centre(self) -> tuple[int, int]:
        """The middle of what the scene is clamped to, whole pitches."""
        return round(0.5 * (self.low[0] + self.high[0])), round(0.5 * (self.low[1] + self.high[1]))

    @property
    def points(self) -> float:
        """Frequencies that are computed: half of those within the band, the others are their mirror images."""
        return 0.5 * self._area * self.periods[0] * self.periods[1]

    @property
    def ends(self) -> tuple[float, float]:
        """Where the band ends along x and along y."""
        return min(self.cut, self.cuts[0]), min(self.cut, self.cuts[1])

    @property
    def _area(self) -> float:
        """Of the band: a disc's, or what a rectangle leaves of it, a quarter under y = min(b, √(r² − x²))."""
        (a, b), r = self.ends, self.cut
        if a == b == r:
            return math.pi * r**2
        corner = math.sqrt(r * r - b * b)
        if corner >= a:
            return 4.0 * a * b

        def under(x: float) -> float:
            return 0.5 * (x * math.sqrt(r * r - x * x) + r * r * math.asin(x / r))

        return 4.0 * (corner * b + under(a) - under(corner))

    @property
    def sums(self) -> tuple[int, int]:
        """Rows and columns of the photosites' own grid of frequencies, the half plane i ≥ 0 of it.

        Where the band has fewer, as of what is smooth, there are no aliases, and only its own are kept.
        """
        (px, py), few = self.periods, self._few
        return few if few[0] <= py and few[1] <= px // 2 else (py, px // 2 + 1)

    @property
    def one_by_one(self) -> bool:
        """Whether frequencies are so few, and so are photosites, that they are added up and not transformed back."""
        return self.sums == self._few and self.singly

    @property
    def singly(self) -> bool:
        """Whether photosites are so few, beside frequencies, that each is a sum."""
        px, py = self.periods
        return self.row_by_row <= CHEAPER * px * py

    @property
    def row_by_row(self) -> float:
        """Products that the photosites take as sums."""
        rows, cols = self.coarse
        return rows * (self.points + self.ends[0] * self.periods[0] * cols) + self.rows * self.cols

    @property
    def coarse_step(self) -> int:
        """Photosites from one to the next where what is smooth is added up; it is interpolated between them."""
        return max(1, math.floor(COARSE / self.cut))

    @property
    def coarse(self) -> tuple[int, int]:
        """Rows and columns of such photosites, some beyond the tile; its own where all of them are."""
        step = self.coarse_step
        if step == 1:
            return self.rows, self.cols
        return (self.rows - 1) // step + COARSE_POINTS + 1, (self.cols - 1) // step + COARSE_POINTS + 1

    @property
    def _few(self) -> tuple[int, int]:
        return 2 * math.floor(self.ends[1] * self.periods[1]) + 1, math.floor(self.ends[0] * self.periods[0]) + 1
