"""Text: the outlines of a font's letters, set in lines."""

from __future__ import annotations

import functools
import io
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from annotated_types import Ge, Le

from camsim.core.typed import Number, Place, Point, Positive, refusal, validate
from camsim.scene.curves import Curves, Pen
from camsim.scene.primitives import MOST_PIECES, Primitive, Shape, turned
from camsim.scene.regions import separated
from camsim.spectra.curve import NumberOrCurve, Reflectance

Weight = Literal[
    "Light", "LightItalic", "Regular", "Italic", "SemiBold", "SemiBoldItalic", "Bold", "BoldItalic", "ExtraBold",
    "ExtraBoldItalic",
]  # fmt: skip
Spacing = Annotated[float, Ge(0), Le(100)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Text(Shape):
    """Text in Open Sans (Apache 2.0), which the package ttf-opensans ships; lines end at a line feed.

    size_um  : size of the font (its em): capitals are 0.714 of it high
    at_um    : where the first line begins, ends or has its middle, by ``align``; by ``vertical`` on its baseline, or
               halfway between the top of the first line's capitals and the last baseline
    weight   : weight of the font, Light to ExtraBold
    line     : distance from one baseline to the next, in sizes
    rotate_deg : rotation about ``at_um``, clockwise as displayed

    Letters stand as far apart as the font says; there is no kerning and there are no ligatures. What the font has not,
    and signs that stand upon others, are refused.

    >>> Text(text="Abc", size_um=50.0, align="centre", reflectance=0.05).text
    'Abc'
    """

    depth: ClassVar[int] = 0

    text: str
    size_um: Positive
    at_um: Point = (0.0, 0.0)
    align: Literal["left", "centre", "right"] = "left"
    vertical: Literal["baseline", "middle"] = "baseline"
    weight: Weight = "Regular"
    line: Spacing = 1.36
    rotate_deg: float = 0.0
    reflectance: Reflectance
    pieces: int = field(init=False, repr=False, compare=False)

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            text: str,
            size_um: Number,
            at_um: Place = (0.0, 0.0),
            align: Literal["left", "centre", "right"] = "left",
            vertical: Literal["baseline", "middle"] = "baseline",
            weight: Weight = "Regular",
            line: Number = 1.36,
            rotate_deg: Number = 0.0,
            reflectance: NumberOrCurve,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        font = font_of(self.weight)
        pieces = 0
        for letter in self.text:
            if letter != "\n" and letter not in font:
                raise refusal(self, "text", _missing(letter))
            pieces += 0 if letter == "\n" else len(font.glyph(letter).kind)
        if pieces > MOST_PIECES:
            raise refusal(self, "text", f"makes {pieces} sides and curves; the most is {MOST_PIECES}")
        object.__setattr__(self, "pieces", pieces)

    def primitives(self) -> Iterator[Primitive]:
        """Return the primitives letter by letter, disjoint parts (i and its dot) separately."""
        font, lines = font_of(self.weight), self.text.split("\n")
        turn = self.size_um * turned(np.eye(2), self.rotate_deg).T
        matrix = np.column_stack([turn, np.zeros(2)])
        set_once: dict[str, list[Primitive]] = {}  # each letter scaled and rotated once, then translated
        top = 0.5 * (font.capital - self.line * (len(lines) - 1)) if self.vertical == "middle" else 0.0
        for number, line in enumerate(lines):
            widths = [font.advance(letter) for letter in line]
            left = -{"left": 0.0, "centre": 0.5, "right": 1.0}[self.align] * sum(widths)
            for letter, width in zip(line, widths, strict=True):
                if letter not in set_once:
                    parts = [Primitive(((fill,),), self.reflectance) for fill in font.parts(letter)]
                    set_once[letter] = [part.moved(matrix) for part in parts]
                by_um = np.array(self.at_um) + turn[:, 0] * left + turn[:, 1] * (top + number * self.line)
                yield from (part.shifted(by_um) for part in set_once[letter])
                left += width


class Font:
    """A TrueType font: outlines in units of the size, y down, relative to the baseline origin."""

    def __init__(self, path: Any) -> None:
        from fontTools.ttLib import TTFont

        self._font = TTFont(io.BytesIO(path.read_bytes()), lazy=True)  # no file stays open
        self._names = self._font.getBestCmap()
        self._glyphs = self._font.getGlyphSet()
        self._em = float(self._font["head"].unitsPerEm)
        self.glyph = functools.cache(self._drawn)  # a letter's outlines
        self.parts = functools.cache(lambda letter: separated(self.glyph(letter), "nonzero"))  # sorted into fills
        self.capital = float(self._font["OS/2"].sCapHeight) / self._em

    def __contains__(self, letter: str) -> bool:
        """Whether it has a letter that is not a combining mark."""
        return ord(letter) in self._names and unicodedata.combining(letter) == 0

    def advance(self, letter: str) -> float:
        """Return the advance width, in units of the size."""
        return float(self._glyphs[self._names[ord(letter)]].width) / self._em

    def _drawn(self, letter: str) -> Curves:
        from fontTools.pens.basePen import decomposeQuadraticSegment
        from fontTools.pens.recordingPen import DecomposingRecordingPen

        recorded, pen, em = DecomposingRecordingPen(self._glyphs), Pen(), self._em
        self._glyphs[self._names[ord(letter)]].draw(recorded)
        for word, points in recorded.value:
            places = [(x / em, -y / em) for x, y in points]
            for one_off, on in decomposeQuadraticSegment(places) if word == "qCurveTo" else ():
                pen.quadratic(*one_off, *on)
            if word in ("moveTo", "lineTo"):
                getattr(pen, word.removesuffix("To"))(*places[0])
        return pen.curves()


@functools.cache
def font_of(weight: str) -> Font:
    """Return Open Sans in one of its weights."""
    import ttf_opensans

    return Font(next(font.path for font in ttf_opensans.FONTS if font.name == f"OpenSans-{weight}"))


def _missing(letter: str) -> str:
    name = unicodedata.name(letter, "a character without a name").lower()
    what = f"Open Sans has no {letter!a} (U+{ord(letter):04X}, {name})"
    return f"{what}; it has Latin, Greek and Cyrillic letters: draw others as paths"
