"""Errors that users can correct.

The message of every class here is one clear sentence that names the place, the value, what is allowed and the
remedy. The command line prints it and exits with 2. Any other exception is a bug of camsim (traceback, exit
code 1) or comes from the system (``OSError``). One exception: an accuracy that ``strict`` requires and that is
not reached is not a mistake of the user, and exits with 1.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass


class CamsimError(Exception):
    """A mistake of the user; the message says how to correct it.

    message : the value, what is allowed and the remedy
    key     : name of the parameter concerned; empty if it is not about a single one
    stage   : owner of the parameter: a class, a file, a part of a description; empty if that is obvious

    >>> print(CamsimError("must be a whole number from 1 to 16, not 17", key="bit_depth", stage="Adc"))
    Adc.bit_depth: must be a whole number from 1 to 16, not 17
    """

    def __init__(self, message: str, *, key: str = "", stage: str = "") -> None:
        self.message, self.key, self.stage = message, key, stage
        super().__init__(message)

    def __str__(self) -> str:
        place = ".".join(part for part in (self.stage, self.key) if part)
        return f"{place}: {self.message}" if place else self.message


class UnknownNameError(CamsimError):
    """A name that is not in its list; the message suggests the nearest ones.

    >>> print(UnknownNameError("sensor", "d40like", ["d40-like", "mono-345"]))
    unknown sensor 'd40like'; did you mean 'd40-like'? (known: d40-like, mono-345)
    """

    def __init__(
        self, kind: str, name: str, known: Iterable[str], hint: str = "", *, key: str = "", stage: str = ""
    ) -> None:
        self.kind, self.name, self.known = kind, name, sorted(known)
        message = f"unknown {kind} {name!r}{did_you_mean(name, self.known)}{hint}"
        super().__init__(message, key=key, stage=stage)

    @property
    def near(self) -> tuple[str, ...]:
        """The known names that may be meant, the likeliest first."""
        return nearest(self.name, self.known)


class InvalidValueError(CamsimError):
    """A number or shape outside the range that physics or the method allows."""


class WrongCallError(InvalidValueError, TypeError):
    """A parameter of a public function or class that is misspelt, missing, or not given by its name."""


class UnsupportedError(CamsimError):
    """A combination of valid parts that cannot be computed; the message names one that can."""


class AccuracyError(CamsimError):
    """A rendering is less accurate than ``strict`` requires; the message says where, and the exit code is 1."""


class OutputError(CamsimError):
    """A result cannot be written at the place or in the format requested."""


class InputError(CamsimError):
    """A file cannot be read: it is not one of camsim's, truncated or damaged."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One mistake in a YAML file: where, which key, what is wrong and what is allowed."""

    file: str
    line: int
    column: int
    key: str
    message: str

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        return f"{place}: {self.key}: {self.message}" if self.key else f"{place}: {self.message}"


class ConfigError(CamsimError):
    """All the faults found in the configuration, one line each."""

    def __init__(self, faults: Iterable[Fault]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))


def in_brief(error: BaseException | str, most: int = 120) -> str:
    """Return the beginning of another program's message as one line of printable characters.

    >>> in_brief("damaged\\n\\x1b[31m at byte 3")
    'damaged [31m at byte 3'
    """
    words = "".join(letter if letter.isprintable() else " " for letter in str(error)[: 4 * most]).split()
    displayed = " ".join(words)
    return displayed if len(displayed) <= most else f"{displayed[: most - 1]}…"


def did_you_mean(name: str, known: Iterable[str], displayed: int = 12) -> str:
    """Return the tail of a message about an unknown name: the likely one, and the list if it is short.

    Names may come from elsewhere, such as an archive, with any length and any characters.

    >>> did_you_mean("mosaic.npy", ["record.json", "q\\n\\tr"])
    ' (known: record.json, q r)'
    """
    names = [in_brief(name) for name in known]
    near = nearest(name, names)
    text = f"; did you mean {' or '.join(repr(n) for n in near)}?" if near else ";" if names else ""
    if names and len(names) <= displayed:
        text += f" (known: {', '.join(names)})"
    elif not near:
        text = ""
    return text.replace("; (", " (")


# Common alternatives for camsim's names.
_OTHER_NAMES = {
    "auto": "automatic",
    "boundary": "edges exact analytic",
    "bayer": "rggb bggr grbg gbrg rgb",
    "circular": "circle disc disk round",
    "D65": "daylight",
    "A": "tungsten incandescent",
    "E": "equal-energy equal",
    "disc": "circle disk round dot",
    "energy": "energies radiant watts",
    "fourier": "fft dft",
    "four-spot": "4-spot quad",
    "gaussian": "gauss normal",
    "hold": "nearest edge extend constant clamp",
    "letters": "custom own",
    "mm": "millimeter millimeters millimetre millimetres",
    "mono": "monochrome monochromatic gray grey",
    "mosaic": "raw bayer",
    "photon": "photons quanta quantum",
    "pixel": "px pixels photosite photosites pitch",
    "polygon": "poly triangle",
    "preview": "jpg jpeg rgb srgb",
    "quad-bayer": "tetracell quadbayer",
    "rectangle": "rect square box",
    "rectangular": "rect rectangle box",
    "scene": "object",
    "sensor": "camera body image",
    "square": "quadratic",
    "truth": "groundtruth ground-truth gt reference",
    "two-spot": "2-spot double",
    "um": "µm μm micron microns micrometer micrometers micrometre micrometres",
    "x-trans": "xtrans fuji fujifilm",
    "zero": "none dark black",
}
_OTHER_WORDS = {"gray": "neutral", "grey": "neutral"}
_LEAST_BEGINNING = 2


def nearest(name: str, known: Iterable[str]) -> tuple[str, ...]:
    """Return up to three names that may be meant, the likeliest first: by synonyms, beginnings or spelling.

    >>> nearest("d40", ["d40-like", "mono-345"]), nearest("px", ["pixel", "um"]), nearest("Gray", ["neutral 5"])
    (('d40-like',), ('pixel',), ('neutral 5',))
    """
    lowered = {n.lower(): n for n in known}
    wanted = " ".join(_OTHER_WORDS.get(word, word) for word in name.lower().split())
    if other := [n for n in lowered.values() if wanted in _OTHER_NAMES.get(n, "").split()]:
        return tuple(other)
    begun = [low for low in lowered if len(wanted) >= _LEAST_BEGINNING and low.startswith(wanted)]
    alike = begun or difflib.get_close_matches(wanted, lowered, n=max(len(lowered), 1), cutoff=0.6)
    return tuple(lowered[m] for m in sorted(alike, key=lambda m: _unlikeness(wanted, m))[:3])


def _unlikeness(name: str, known: str) -> tuple[float, float]:
    """Return a sort key by similarity of spelling and, among equals, by the difference of a number in the name.

    >>> min(["d75", "d65", "d60", "d55"], key=lambda known: _unlikeness("d56", known))
    'd55'
    """
    letters = -difflib.SequenceMatcher(a=known, b=name).ratio()
    one, other = ("".join(filter(str.isdigit, word)) for word in (name, known))
    return letters, abs(int(one) - int(other)) if one and other else 0.0
