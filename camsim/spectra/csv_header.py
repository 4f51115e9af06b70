"""Interpretation of a table's header: the column of wavelengths, and units."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

_BEGIN, _END = r"(?<![^\W\d_])", r"(?![^\W\d_])"  # no letter before, none behind
_INVERSE = r"\s*(?:\^|\*\*)?(?:[-−]\s*1(?!\d)|⁻¹)"
_LENGTH = r"(?:[nuµμ]m|å|nanomet\w*|micron\w*|micromet\w*|angstr\w*)"
_WAVE = r"(?:wave[\s_-]?lengths?|wave|lambda|λ|wl|wellenl\w+)"
_BARE_ANGSTROM = r"[\[(/]\s*aa?\s*(?:[\])]|$)"

# By decreasing certainty: named wavelength or a unit alone, mentions waves, has a unit of length.
_CALLED = re.compile(rf"[\W_]*(?:{_WAVE}(?:[\W_]*(?:{_LENGTH}|aa?|m))?|{_LENGTH})[\W_]*")
_OF_WAVES = re.compile(rf"wave(?![\W_]*num)|lambda|λ|wellenl|{_BEGIN}wl{_END}")
_OF_LENGTH = re.compile(rf"{_BEGIN}{_LENGTH}(?!{_INVERSE})(?![\w²³^])")
# W/m²/nm, W/(m² nm), photons/nm: densities, not lengths.
_PER_LENGTH = re.compile(
    rf"(?:[\d²]\s*[/·*]?|(?:\)|{_BEGIN}(?:m?w|j|photons?|electrons?|counts?))\s*/)\s*{_LENGTH}{_END}"
)
# "wavelengths in µm", also among other words.
_STATED = re.compile(rf"{_WAVE}[\W_]*(?:(?:are|is|given|in)[\W_]+)*{_LENGTH}{_END}")

# After a number, a unit belongs to a condition, not to the column: "QE at 25 µm pitch".
_PER_CENT = r"(?<![\w.,])\d+(?:[.,]\d+)?\s*[%‰]"
_QUANTITY = re.compile(rf"{_PER_CENT}|(?<![\w.,])\d+(?:[.,]\d+)?[\s-]*(?:{_LENGTH}|cm{_INVERSE}|m?ev){_END}")
_MAY_BE_PER_CENT = re.compile(rf"{_PER_CENT}\s*[)\]]?\s*$|(?<![\w.,])100\s*%")

_WAVENUMBERS = rf"wave[\W_]*num\w*|wellenzahl\w*|1\s*/\s*(?:[cmnuµμ]?m|λ|lambda|wave\w*){_END}|[cmnuµμ]m{_INVERSE}"
_NM = (
    (_WAVENUMBERS, None),
    (rf"{_BEGIN}[uµμ]m{_END}|micron|micromet", 1000.0),
    (rf"{_BEGIN}nm{_END}|nanomet", 1.0),
    (rf"{_BEGIN}å{_END}|angstr|{_BARE_ANGSTROM}", 0.1),
    (r"[\[(]\s*m\s*[\])]", 1e9),
)
_NO_WAVELENGTH = rf"frequen|frequenz|{_BEGIN}energ|{_BEGIN}[kmgtp]?(?:hz|ev){_END}"
_FRACTIONS = (
    (rf"%(?!\d)|{_BEGIN}per[\s_]?cent(?:age)?{_END}|prozent|{_BEGIN}pct{_END}", 0.01),
    (rf"‰|{_BEGIN}per[\s_]?mil(?:le)?{_END}|promille", 0.001),
    (rf"^[\W_]*(?:absorban|optical[\W_]dens|od[\W_]*$)|[\[(/]\s*db{_END}", None),
)


def wavelengths_at(names: Sequence[str]) -> int | None:
    """Return the column of the wavelengths: the one named so, before one whose name mentions a unit of length.

    >>> wavelengths_at(["QE at 25 µm pitch", "W/m²/nm", "wavelength"])
    2
    """
    called = columns_called(names)
    if called:
        return called[0]
    for pattern in (_OF_WAVES, _OF_LENGTH):
        for place, name in enumerate(names):
            if pattern.search(_PER_LENGTH.sub(" ", _bare(name))):
                return place
    return None


def columns_called(names: Sequence[str]) -> list[int]:
    """Return the columns named wavelength, or by a unit of length alone."""
    return [place for place, name in enumerate(names) if _CALLED.fullmatch(name.lower())]


def is_header(names: Sequence[str]) -> bool:
    """Whether cells of a remark are column names: one is named wavelength, or the first one mentions wavelengths."""
    return bool(columns_called(names)) or wavelengths_at(names) == 0


def scales_nm(name: str) -> set[float | None]:
    """Return the factors from a column's units to nm: empty without a unit, None if a unit is no length."""
    text = _bare(name)
    return _found(_NM, text) | ({None} if re.search(_NO_WAVELENGTH, text) else set())


def scales_of(name: str) -> set[float | None]:
    """Return the factors by which a column's units scale its values: empty without a unit, None for logarithms."""
    return _found(_FRACTIONS, _bare(name))


def may_be_per_cent(name: str) -> bool:
    """Whether a name may or may not mean values in per cent, such as "Filter 2 %" or "T (0-100 %)"."""
    return bool(_MAY_BE_PER_CENT.search(name))


def stated_nm(remarks: str) -> set[float | None]:
    """Return the units that remarks give for wavelengths, next to that word."""
    return {scale for found in _STATED.findall(_bare(remarks)) for scale in scales_nm(found)}


def wavenumbers(remark: str) -> str:
    """Return the word in a remark that declares wavenumbers; "" if none."""
    found = re.search(_WAVENUMBERS, _bare(remark))
    return found[0] if found else ""


def unclear(remark: str) -> str:
    """Return an ambiguous unit in a remark that would silently rescale the numbers; "" if none.

    µm and m would not: read as nm they are outside the range of light.
    """
    text = _STATED.sub(" ", _bare(remark))
    found = re.search("|".join(pattern for pattern, scale in (*_NM, *_FRACTIONS) if scale and scale < 1.0), text)
    return found[0] if found else ""


def _bare(text: str) -> str:
    return _QUANTITY.sub(" ", text.lower())


def _found(units: Iterable[tuple[str, float | None]], text: str) -> set[float | None]:
    return {scale for pattern, scale in units if re.search(pattern, text)}
