"""What can go wrong, and whose mistake it was.

Every class here means *the user can mend this*: one clear sentence that names the place, the value, what is
allowed and the way out. The command line prints the sentence and exits with 2. Anything else that is raised
is a bug of ours (traceback, exit code 1) or the system's word (``OSError``). One exception: an accuracy that
``strict`` asked for and that was not reached is no mistake of the user's, and exits with 1.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass


class CamsimError(Exception):
    """A mistake of the user; the message says how to correct it.

    message : the value, what is allowed and the way out
    key     : the parameter that it is about, as its stage calls it; empty where it is about no single one
    stage   : whose parameter it is: a class, a file, a part of a description; empty where that goes without saying

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
    """A name that is not in its list; the message offers the nearest ones.

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
        """The known names that are meant, perhaps, the likeliest first."""
        return nearest(self.name, self.known)


class InvalidValueError(CamsimError):
    """A number or shape outside what physics or the method allows."""


class WrongCallError(InvalidValueError, TypeError):
    """A parameter of a public function or class that is misspelt, missing, or not given by its name."""


class UnsupportedError(CamsimError):
    """Each part is right, but this combination cannot be computed; the message names one that can."""


class AccuracyError(CamsimError):
    """A rendering is less accurate than ``strict`` asked for; the message says where, and the exit code is 1."""


class OutputError(CamsimError):
    """A result cannot be written where or as the user asked."""


class InputError(CamsimError):
    """A file cannot be read: it is none of ours, cut short or damaged."""


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
    """Return the beginning of another program's message as one line of letters that a terminal can show.

    >>> in_brief("damaged\\n\\x1b[31m at byte 3")
    'damaged [31m at byte 3'
    """
    words = "".join(letter if letter.isprintable() else " " for letter in str(error)[: 4 * most]).split()
    displayed = " ".join(words)
    return displayed if len(displayed) <= most else f"{displayed[: most - 1]}…"


def did_you_mean(name: str, known: Iterable[str], displayed: int = 12) -> str:
    """Return the tail of a message about an unknown name: the likely one, and the list when it is short.

    Names may be a stranger's, as members of an archive are: of any length and with any letters.

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


# Other people's words for names that camsim has fixed.
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
    """Return up to three names that are meant, perhaps, the likeliest first: by other words, beginnings or letters.

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
    """Order names by their letters and, among equals that differ in a number only, by how near the number is.

    >>> min(["d75", "d65", "d60", "d55"], key=lambda known: _unlikeness("d56", known))
    'd55'
    """
    letters = -difflib.SequenceMatcher(a=known, b=name).ratio()
    one, other = ("".join(filter(str.isdigit, word)) for word in (name, known))
    return letters, abs(int(one) - int(other)) if one and other else 0.0
