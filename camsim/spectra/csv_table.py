"""Curves from CSV files: common separators, decimal commas, comments, units in a header."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import NoReturn, TypeAlias

from camsim.errors import InputError, InvalidValueError, did_you_mean
from camsim.spectra import csv_header

Column: TypeAlias = str | int

MAX_BYTES = 16 * 2**20
LEAST_NM, MOST_NM = 50.0, 20_000.0
"""Range of wavelengths of cameras: numbers outside have another unit."""

_NUMBER = re.compile(r"[-+]?(\d+([.,]\d*)?|[.,]\d+)([eE][-+]?\d+)?")
_BEGINS = re.compile(r"\s*\"?[-+]?[.,]?\d")
_UNIT = re.compile(r"\s*[\[(/].*$")
_BETWEEN = re.compile(r"[\W_]+")
_COMMENT = re.compile(r"\s*(#|//)\s*")
_THOUSANDS = re.compile(r"[1-9],\d{3}")
_APART = (";", "\t", ",", r"\s{2,}", r"(?<![/\s])\s+(?![\[(/\s])")
"""Separators of names; last, spaces not followed by a unit."""


@dataclass(frozen=True, slots=True)
class _Row:
    line: int
    cells: Sequence[str]


def read_points(
    path: str | os.PathLike[str], column: Column | None = None, displayed: str = ""
) -> tuple[list[float], list[float]]:
    """Return wavelengths (nm, increasing) and values of one column of a CSV file.

    column : name in the header, or number from 1 on; None: the other one of two columns
    displayed : name of the file in messages

    Cells are separated by semicolons, tabs, commas or spaces; a decimal comma is read where commas separate nothing,
    lines that begin with # or // are left out, empty cells are no points, and the order of the rows is free. The header
    may name nm (what is meant without a unit), µm, Å or m, and % for values of a hundred times the fraction; a comment
    is one where it names the wavelengths, directly above the numbers. Raises InputError or InvalidValueError (about the
    column) with one sentence.
    """
    return _Table(os.fspath(path), displayed or os.fspath(path)).points(column)


def columns(path: str | os.PathLike[str], displayed: str = "") -> list[tuple[int, str]]:
    """Return number and name of each column except the wavelengths'; unnamed ones have their number as name."""
    return _Table(os.fspath(path), displayed or os.fspath(path)).columns()


class _Table:
    """The cells of a file: rows of numbers, and the header above them."""

    def __init__(self, path: str, displayed: str) -> None:
        self.displayed = repr(displayed)
        lines = _text(path, self.displayed).splitlines()
        first = next((k for k, line in enumerate(lines) if _BEGINS.match(line)), None)
        if first is None:
            raise InputError(f"{self.displayed}: no line begins with a number; give a row for each wavelength")
        self.separator = _separator(lines[first])
        self.rows = [
            _Row(first + k + 1, self._cells(line))
            for k, line in enumerate(lines[first:])
            if line.strip(" \t\r,;") and not _COMMENT.match(line)
        ]
        self.header, self.remarks = self._above(lines[:first])
        self._mark = ""

    def _above(self, lines: Sequence[str]) -> tuple[list[_Row], Sequence[str]]:
        """Return the rows of the header, and the lines above the numbers if no header has units.

        A comment directly above the numbers is a header where it names the wavelengths; other words that are as many as
        the columns are names only.
        """
        widest = max(len(row.cells) for row in self.rows)
        above = [_Row(k + 1, self._names(line, widest)) for k, line in enumerate(lines) if re.search(r"\w|%", line)]
        plain = [row for row in above if not _COMMENT.match(lines[row.line - 1])]
        header = _header(plain, len(self.rows[0].cells) if self.separator == " " else None)
        below = above[above.index(plain[-1]) + 1 :] if header else above
        named = [row for row in below[-1:] if len(row.cells) == widest and csv_header.is_header(row.cells)]
        if named:
            named += takewhile(lambda row: csv_header.columns_called(row.cells), below[-2::-1])
        if header or named:
            return [*header, *named[::-1]], ()
        return [row for row in above[-1:] if len(row.cells) == widest > 1], lines

    def _names(self, line: str, width: int) -> Sequence[str]:
        """Return the cells of a line above the numbers, whose separator may differ."""
        bare = _COMMENT.sub("", line, count=1)
        one = self._cells(bare)
        if len(one) == width and self.separator != " ":
            return one
        for mark in _APART if self.separator == " " else _APART[:-1]:
            cells = [cell.strip() for cell in re.split(mark, bare.strip())]
            if len(cells) == width > 1 and csv_header.is_header(cells):
                return cells
        return one

    def columns(self) -> list[tuple[int, str]]:
        """Return number and name of each column except the wavelengths'."""
        others = self._others(self._place())
        return [(k + 1, self.header[0].cells[k] if self.header else str(k + 1)) for k in others]

    def points(self, column: Column | None) -> tuple[list[float], list[float]]:
        """Return wavelengths and values of a column."""
        place = self._place()
        chosen = self._chosen(column, place)
        points: dict[float, tuple[float, int]] = {}
        to_nm, to_value = self._scale_nm(place), self._scale_of(chosen)
        if to_value is None:
            self._validate_signs(chosen)
        for row in self.rows:
            if self.header and len(row.cells) > len(self.header[0].cells):
                self._refuse(
                    row,
                    f"{len(row.cells)} cells, and the header has {len(self.header[0].cells)}; of numbers with decimal "
                    "commas separate the cells by semicolons",
                )
            value = self._number(row, chosen, "%")
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
            scale = 0.01 if row.cells[chosen].endswith("%") else to_value or 1.0
            points[wavelength_nm] = _rounded(value * scale), row.line
        self._validate_thousands(chosen)
        self._validate(sorted(points), chosen)
        return sorted(points), [points[nm][0] for nm in sorted(points)]

    def _place(self) -> int:
        """Return the column of the wavelengths."""
        if self.remarks:
            return 0
        called = csv_header.columns_called(self._texts())
        if len(called) > 1:
            names = " and ".join(f"{self._name(k)} ({k + 1})" for k in called[:2])
            raise InputError(
                f"{self.displayed}: {names} are columns of wavelengths; keep one, and the columns it is of"
            )
        return csv_header.wavelengths_at(self._texts()) or 0

    def _validate_signs(self, chosen: int) -> None:
        """Raise for a column with % in some cells only: the others are ambiguous."""
        rows = [row for row in self.rows if chosen < len(row.cells) and row.cells[chosen].strip("0., ")]
        signed = [row.cells[chosen].endswith("%") for row in rows]
        if any(signed) and not all(signed):
            row = rows[signed.index(False)]
            self._refuse(row, f"{row.cells[chosen][:40]!r} has no %, and other cells have; give all of them one")

    def _validate_thousands(self, chosen: int) -> None:
        """Raise for 900 next to 1,000: a thousands separator would change the ratio."""
        cells = [(row, row.cells[chosen]) for row in self.rows if chosen < len(row.cells)]
        marked = [(row, cell) for row, cell in cells if "," in cell]
        whole = any(cell.isdecimal() and int(cell) >= 100 for _, cell in cells)
        if whole and marked and all(_THOUSANDS.fullmatch(cell) for _, cell in marked):
            row, cell = marked[0]
            number = cell.replace(",", "")
            self._refuse(row, f"{cell!r} may be {number}; write no mark between thousands, and 100.0 for 100 otherwise")

    def _validate(self, wavelength_nm: Sequence[float], chosen: int) -> None:
        if len(wavelength_nm) < 2:
            raise InputError(f"{self.displayed}: column {self._name(chosen)} has fewer than 2 numbers; a curve needs 2")
        if wavelength_nm[0] < LEAST_NM:
            raise InputError(
                f"{self.displayed}: wavelengths from {wavelength_nm[0]:g} to {wavelength_nm[-1]:g} nm are no light; "
                "name "
                "their unit in the header, such as wavelength_um"
            )
        if wavelength_nm[0] > MOST_NM:
            raise InputError(
                f"{self.displayed}: wavelengths from {wavelength_nm[0]:g} to {wavelength_nm[-1]:g} nm are no light; "
                "give "
                "nm, or name their unit in the header"
            )

    def _cells(self, line: str) -> Sequence[str]:
        if self.separator == " ":
            return re.sub(r"(?<=\d)\s+%", "%", line).split()
        cells = next(csv.reader([line], delimiter=self.separator, skipinitialspace=True), [])
        while cells and not cells[-1].strip():
            cells.pop()
        return [cell.strip() for cell in cells]

    def _texts(self) -> list[str]:
        """Return the text above each column, over all rows of the header."""
        width = len(self.header[0].cells) if self.header else 0
        return [" ".join(row.cells[k] for row in self.header if k < len(row.cells)) for k in range(width)]

    def _name(self, place: int) -> str:
        return repr(self.header[0].cells[place]) if self.header else str(place + 1)

    def _others(self, wavelengths: int) -> list[int]:
        width = len(self.header[0].cells) if self.header else len(self.rows[0].cells)
        return [k for k in range(width) if k != wavelengths and not (self.header and not self.header[0].cells[k])]

    def _chosen(self, column: Column | None, wavelengths: int) -> int:
        others = self._others(wavelengths)
        there = ", ".join(map(self._name, others)) or "none but the wavelengths"
        if not others:
            raise InputError(f"{self.displayed}: one column only; a curve needs wavelengths and values")
        if column is None:
            if len(others) == 1:
                return others[0]
            raise InvalidValueError(
                f"{self.displayed} has the columns {there}; say which, as column: {self._name(others[0])}", key="column"
            )
        if isinstance(column, int):
            found = [k for k in others if k + 1 == column]
            names = [str(k + 1) for k in others]
        else:
            names = [self.header[0].cells[k] for k in others] if self.header else []
            found = self._named(column, others)
        if len(found) > 1:
            raise InvalidValueError(
                f"{self.displayed} has {len(found)} columns {column!r}; give its number", key="column"
            )
        if not found:
            message = f"{self.displayed} has no column {column!r}{did_you_mean(str(column), names)}"
            raise InvalidValueError(message, key="column")
        return found[0]

    def _named(self, column: str, others: Sequence[int]) -> list[int]:
        """Return the columns of a name in any header row: exact, case-insensitive, without unit, or as a word.

        So R is found as "R", "r", "R (%)", or "QE R [%]" if no other column has that word.
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
        """Return the scale factor of the wavelengths to nm."""
        text = "".join(self._texts()[place : place + 1])
        scales = csv_header.scales_nm(text)
        if self.remarks:
            text, scales = "wavelengths", csv_header.stated_nm(" ".join(self.remarks))
        for line, remark in enumerate(self.remarks, 1):
            if word := csv_header.wavenumbers(remark):
                raise InputError(f"{self.displayed}, line {line}: {word!r} is no wavelength; give nm or µm")
        if None in scales:
            raise InputError(f"{self.displayed}: {text.strip()!r} is no wavelength; give nm or µm")
        if len(scales) > 1:
            raise InputError(f"{self.displayed}: {text.strip()!r} in two units; name one, such as wavelength_um")
        return next((scale for scale in scales if scale), 1.0)

    def _scale_of(self, chosen: int) -> float | None:
        """Return the scale factor of the values; None if not stated."""
        for line, remark in enumerate(self.remarks, 1):
            if unit := csv_header.unclear(remark):
                raise InputError(
                    f"{self.displayed}, line {line}: {unit!r} stands in no header, and may be the numbers' or not; "
                    "give each column a name, as in '# wavelength_nm, T / %', or leave it out"
                )
        if self.remarks or not self.header:
            return None
        text = self._texts()[chosen]
        scales = csv_header.scales_of(text)
        if None in scales:
            raise InputError(f"{self.displayed}: {text!r} is a logarithm; give fractions or per cent")
        if len(scales) > 1:
            raise InputError(f"{self.displayed}: {text!r} in two units; name one, such as [%]")
        if not scales and any(
            csv_header.may_be_per_cent(r.cells[chosen]) for r in self.header if chosen < len(r.cells)
        ):
            raise InputError(
                f"{self.displayed}: {text!r} may be of per cent or not; write [%] where it is, else leave the % out, "
                "and "
                "begin remarks with #"
            )
        return next((scale for scale in scales if scale), None)

    def _number(self, row: _Row, place: int, sign: str = "") -> float | None:
        """Return the number of a cell without a trailing sign; None if empty."""
        text = row.cells[place] if place < len(row.cells) else ""
        if not text:
            return None
        bare = text.removesuffix(sign).rstrip()
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
        return float(bare.replace(",", "."))

    def _refuse(self, row: _Row, what: str) -> NoReturn:
        raise InputError(f"{self.displayed}, line {row.line}: {what}")


def _rounded(number: float) -> float:
    """Return a scaled number rounded as it would be written: 0.4001 µm are 400.1 nm."""
    return float(f"{number:.14g}")


def _text(path: str, displayed: str) -> str:
    """Return the text of a file: UTF-8, UTF-16 with BOM, or the Windows code page."""
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise InputError(f"{displayed}: not a file")
        with open(path, "rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = "no such file" if isinstance(error, FileNotFoundError) else getattr(error, "strerror", None) or error
        raise InputError(f"{displayed}: {str(reason).lower()}") from None
    if len(data) > MAX_BYTES:
        raise InputError(f"{displayed}: larger than {MAX_BYTES // 2**20} MB, the most that is read")
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", "replace")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    if "\0" in text:
        raise InputError(f"{displayed}: not a text; a table of numbers is wanted")
    return text


def _separator(line: str) -> str:
    for mark in ";\t":
        if mark in line:
            return mark
    spaced = line.split()
    # With decimal commas between spaces, no word ends in a comma.
    if "," in line and (len(spaced) == 1 or any(word.endswith(",") for word in spaced[:-1]) or '"' in line):
        return ","
    return " "


def _header(rows: Sequence[_Row], width: int | None) -> list[_Row]:
    """Return the rows of names: those with at least two, and as many as the last one.

    width : of the rows of numbers, as names with spaces would look like two
    """
    wide = [row for row in rows if sum(bool(cell) for cell in row.cells) > 1]
    return [row for row in wide if len(row.cells) == (width or len(wide[-1].cells))]
