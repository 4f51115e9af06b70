"""Curves from CSV files as people have them: the usual separators, decimal commas, comments, units in a header."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn, TypeAlias

from camsim.errors import InputError, InvalidValueError, did_you_mean

Column: TypeAlias = str | int

MAX_BYTES = 16 * 2**20
LEAST_NM = 50.0
"""No light that a camera sees is shorter: a table of smaller numbers has another unit."""

_NUMBER = re.compile(r"[-+]?(\d+([.,]\d*)?|[.,]\d+)([eE][-+]?\d+)?")
_BEGINS = re.compile(r"\s*\"?[-+]?[.,]?\d")
_UNIT = re.compile(r"\s*[\[(/].*$")
_BETWEEN = re.compile(r"[\W_]+")
_COMMENT = re.compile(r"\s*(#|//)\s*")
_WAVELENGTH = re.compile(r"wave|lambda|λ|wl\b|(?<![a-z])[nuµμ]m(?![a-z])", re.IGNORECASE)
# Checked in this order: "cm-1" ends like a metre, "µm" too.
_UNITS = (
    (r"cm\s*(\^?-1|⁻¹)|1/cm|(?<![a-z])(thz|ev)(?![a-z])", None),
    (r"(?<![a-z])[uµμ]m(?![a-z])|micron|micromet", 1000.0),
    (r"(?<![a-z])nm(?![a-z])|nanomet", 1.0),
    (r"å|angstr", 0.1),
    (r"[\[(]\s*m\s*[\])]", 1e9),
)


@dataclass(frozen=True, slots=True)
class _Row:
    line: int
    cells: Sequence[str]


def read_points(
    path: str | os.PathLike[str], column: Column | None = None, shown: str = ""
) -> tuple[list[float], list[float]]:
    """Return wavelengths (nm, increasing) and values of one column of a CSV file.

    column : its name in the header, or its number, the file's first being 1; of two columns the other one when None
    shown  : what messages call the file

    Cells are separated by semicolons, tabs, commas or spaces; a decimal comma is read where commas separate nothing,
    lines that begin with # or // are left out, empty cells are no points, and the order of the rows is free. The header
    may name nm (what is meant without a unit), µm, Å or m, and % for values of a hundred times the fraction. Raises
    InputError or InvalidValueError (about the column) with one sentence.
    """
    return _Table(os.fspath(path), shown or os.fspath(path)).points(column)


class _Table:
    """The cells of a file: rows of numbers, and the header above them."""

    def __init__(self, path: str, shown: str) -> None:
        self.shown = repr(shown)
        lines = _text(path, self.shown).splitlines()
        first = next((k for k, line in enumerate(lines) if _BEGINS.match(line)), None)
        if first is None:
            raise InputError(f"{self.shown}: no line begins with a number; give a row for each wavelength")
        self.separator = _separator(lines[first])
        above = [_Row(k + 1, self._cells(_COMMENT.sub("", line))) for k, line in enumerate(lines[:first])]
        plain = [row for row in above if not _COMMENT.match(lines[row.line - 1])]
        width = len(self._cells(lines[first])) if self.separator == " " else None
        self.header = _header(plain, width) or _header(above[-1:], width)
        self.about = " ".join(lines[:first]) if not self.header else ""
        self.rows = [
            _Row(first + k + 1, self._cells(line))
            for k, line in enumerate(lines[first:])
            if line.strip(" \t\r,;") and not _COMMENT.match(line)
        ]
        self._mark = ""

    def points(self, column: Column | None) -> tuple[list[float], list[float]]:
        """Return wavelengths and values of a column."""
        place = next((k for k, text in enumerate(self._texts()) if _WAVELENGTH.search(text)), 0)
        chosen = self._chosen(column, place)
        points: dict[float, tuple[float, int]] = {}
        to_nm, to_value = self._scale_nm(place), 0.01 if "%" in self._text_of(chosen) else 1.0
        for row in self.rows:
            if self.header and len(row.cells) > len(self.header[0].cells):
                self._refuse(
                    row,
                    f"{len(row.cells)} cells, and the header has {len(self.header[0].cells)}; of numbers with decimal "
                    "commas separate the cells by semicolons",
                )
            value = self._number(row, chosen)
            wavelength_nm = self._number(row, place)
            if wavelength_nm is None:
                self._refuse(row, "no wavelength; begin remarks with #")
            if value is None:
                continue
            if value < 0.0:
                self._refuse(row, f"{row.cells[chosen].strip()} is below 0; a spectrum is not, write 0")
            wavelength_nm = _rounded(wavelength_nm * to_nm)
            if wavelength_nm in points:
                first = points[wavelength_nm][1]
                self._refuse(row, f"{wavelength_nm:g} nm is there twice, first on line {first}; keep one")
            points[wavelength_nm] = _rounded(value * to_value), row.line
        self._judge(sorted(points), chosen)
        return sorted(points), [points[nm][0] for nm in sorted(points)]

    def _judge(self, wavelength_nm: Sequence[float], chosen: int) -> None:
        if len(wavelength_nm) < 2:
            raise InputError(f"{self.shown}: column {self._name(chosen)} has fewer than 2 numbers; a curve needs 2")
        if wavelength_nm[0] < LEAST_NM:
            raise InputError(
                f"{self.shown}: wavelengths from {wavelength_nm[0]:g} to {wavelength_nm[-1]:g} nm are no light; name "
                "their unit in the header, such as wavelength_um"
            )

    def _cells(self, line: str) -> Sequence[str]:
        if self.separator == " ":
            return line.split()
        cells = next(csv.reader([line], delimiter=self.separator, skipinitialspace=True), [])
        while cells and not cells[-1].strip():
            cells.pop()
        return [cell.strip() for cell in cells]

    def _texts(self) -> list[str]:
        """Return what stands above each column, in all rows of the header."""
        width = len(self.header[0].cells) if self.header else 0
        return [" ".join(row.cells[k] for row in self.header if k < len(row.cells)) for k in range(width)]

    def _text_of(self, place: int) -> str:
        texts = self._texts()
        return texts[place] if place < len(texts) else self.about

    def _name(self, place: int) -> str:
        return repr(self.header[0].cells[place]) if self.header else str(place + 1)

    def _chosen(self, column: Column | None, wavelengths: int) -> int:
        width = len(self.header[0].cells) if self.header else len(self.rows[0].cells)
        others = [k for k in range(width) if k != wavelengths and not (self.header and not self.header[0].cells[k])]
        there = ", ".join(map(self._name, others)) or "none but the wavelengths"
        if not others:
            raise InputError(f"{self.shown}: one column only; a curve needs wavelengths and values")
        if column is None:
            if len(others) == 1:
                return others[0]
            raise InvalidValueError(
                f"{self.shown} has the columns {there}; say which, as column: {self._name(others[0])}", key="column"
            )
        if isinstance(column, int):
            found = [k for k in others if k + 1 == column]
            names = [str(k + 1) for k in others]
        else:
            names = [self.header[0].cells[k] for k in others] if self.header else []
            found = self._named(column, others)
        if len(found) > 1:
            raise InvalidValueError(f"{self.shown} has {len(found)} columns {column!r}; give its number", key="column")
        if not found:
            message = f"{self.shown} has no column {column!r}{did_you_mean(str(column), names)}"
            raise InvalidValueError(message, key="column")
        return found[0]

    def _named(self, column: str, others: Sequence[int]) -> list[int]:
        """Return the columns of a name in any row of the header: by its letters, without case, without unit, as a word.

        So R is found as "R", "r", "R (%)", or "QE R [%]" where no other column has that word.
        """
        wanted = column.strip().casefold()
        for names in (lambda text: (text,), lambda text: (_UNIT.sub("", text),), lambda text: _BETWEEN.split(text)):
            found = [
                k
                for k in others
                if any(k < len(row.cells) and wanted in names(row.cells[k].casefold()) for row in self.header)
            ]
            exact = [k for k in found if any(k < len(r.cells) and r.cells[k] == column.strip() for r in self.header)]
            if found:
                return exact or found
        return []

    def _scale_nm(self, place: int) -> float:
        """Return what the wavelengths are to be multiplied by."""
        text = self._text_of(place).lower()
        for pattern, scale in _UNITS:
            if re.search(pattern, text):
                if scale is None:
                    raise InputError(f"{self.shown}: {text.strip()!r} is no wavelength; give nm or µm")
                return scale
        return 1.0

    def _number(self, row: _Row, place: int) -> float | None:
        text = row.cells[place] if place < len(row.cells) else ""
        if not text:
            return None
        bare = text.removesuffix("%").rstrip()
        if not _NUMBER.fullmatch(bare):
            way_out = "leave a cell empty where nothing was measured, and begin remarks with #"
            if "," in bare and "." in bare:
                way_out = "write it with one decimal mark and nothing between thousands"
            self._refuse(row, f"{text[:40]!r} is no number; {way_out}")
        for mark in ",.":
            if mark in bare:
                if self._mark not in ("", mark):
                    self._refuse(row, f"{text!r}, where numbers above have a '{self._mark}'; use one decimal mark")
                self._mark = mark
        value = float(bare.replace(",", "."))
        return value / 100.0 if bare != text else value

    def _refuse(self, row: _Row, what: str) -> NoReturn:
        raise InputError(f"{self.shown}, line {row.line}: {what}")


def _rounded(number: float) -> float:
    """Return a number that was scaled as it would have been written: 0.4001 µm are 400.1 nm."""
    return float(f"{number:.14g}")


def _text(path: str, shown: str) -> str:
    """Return the text of a file: UTF-8, UTF-16 with its mark, or what Windows writes."""
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise InputError(f"{shown}: not a file")
        with open(path, "rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = "no such file" if isinstance(error, FileNotFoundError) else getattr(error, "strerror", None) or error
        raise InputError(f"{shown}: {str(reason).lower()}") from None
    if len(data) > MAX_BYTES:
        raise InputError(f"{shown}: larger than {MAX_BYTES // 2**20} MB, the most that is read")
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", "replace")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    if "\0" in text:
        raise InputError(f"{shown}: not a text; a table of numbers is wanted")
    return text


def _separator(line: str) -> str:
    for mark in ";\t":
        if mark in line:
            return mark
    spaced = line.split()
    # Of numbers with decimal commas between spaces no comma ends a word.
    if "," in line and (len(spaced) == 1 or any(word.endswith(",") for word in spaced[:-1]) or '"' in line):
        return ","
    return " "


def _header(rows: Sequence[_Row], width: int | None) -> list[_Row]:
    """Return the rows of names: those of at least two, as wide as the last of them.

    width : of the rows of numbers, where names that hold a space would seem to be two
    """
    wide = [row for row in rows if sum(bool(cell) for cell in row.cells) > 1]
    return [row for row in wide if len(row.cells) == (width or len(wide[-1].cells))]
