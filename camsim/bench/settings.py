"""The settings that are compared: methods at tolerances, or with numbers of samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from camsim.core.typed import check, known_name
from camsim.errors import InvalidValueError

EXACT = ("boundary", "fourier")
ASKED = ("auto", *EXACT)
SAMPLED = ("area", "uniform-pixel", "uniform", "importance", "strips")
METHODS = (*ASKED, *SAMPLED)
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8)
SAMPLES = (121, 2025)
N = TypeVar("N", int, float)
SCENERY = 1e-6  # tolerance of polygons of round shapes, for methods without a tolerance


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """A method with its parameter: a tolerance, a number of samples (of ``importance``), or none."""

    method: str
    tolerance: float | None = None
    samples: int | None = None

    @property
    def asked(self) -> float:
        """The tolerance passed to the rendering."""
        return SCENERY if self.tolerance is None else self.tolerance

    @property
    def label(self) -> str:
        """The method and its parameter in words."""
        if self.tolerance is not None:
            return f"{self.method} {power(self.tolerance)}"
        return self.method if self.samples is None else f"{self.method}, {self.samples} samples"


def power(value: float) -> str:
    """Return a tolerance in words.

    >>> power(1e-2), power(1e-10), power(2.5e-7)
    ('1e-2', '1e-10', '2.5e-7')
    """
    mantissa, _, exponent = f"{value:.3e}".partition("e")
    return f"{float(mantissa):g}e{int(exponent)}"


def settings_of(methods: Sequence[str], tolerances: Sequence[float], samples: Sequence[int]) -> list[Setting]:
    """Return every setting, each once, in the order of the methods; raises CamsimError for invalid ones."""
    for method in check(methods, tuple[Any, ...], "methods"):
        known_name("method", method, METHODS)
    for tolerance in check(tolerances, tuple[float, ...], "tolerances"):
        if not 0.0 < tolerance < 1.0 or not math.isfinite(tolerance):
            raise InvalidValueError(f"{tolerance!r} is no error to keep below; give 1e-2 … 1e-11", key="tolerances")
    for count in check(samples, tuple[int, ...], "samples"):
        if count < 1:
            raise InvalidValueError(f"{count!r} are none; give 1 or more", key="samples")
    found: list[Setting] = []
    for method in methods:
        if method in ASKED:
            found += [Setting(method=method, tolerance=t) for t in sorted(tolerances, reverse=True)]
        elif method == "importance":
            found += [Setting(method=method, samples=n) for n in sorted(samples)]
        else:
            found.append(Setting(method=method))
    return list(dict.fromkeys(found))


def default_tolerances(one: float) -> tuple[float, ...]:
    """Return every second decade, and the scene's tolerance."""
    near = any(math.isclose(one, t, rel_tol=1e-9) for t in TOLERANCES)
    return TOLERANCES if near else (*TOLERANCES, one)


def numbers(text: str, option: str, example: str, kind: Callable[[str], N]) -> tuple[N, ...]:
    """Return the numbers of an option such as ``1e-3,1e-6``.

    >>> numbers("121, 2025", "--samples", "121,2025", int)
    (121, 2025)
    """
    try:
        return tuple(kind(part) for part in text.split(","))
    except ValueError:
        raise InvalidValueError(f"{text!r} is no list of numbers; give them as in {example}", key=option) from None


def parsed_methods(text: str | None) -> tuple[str, ...]:
    """Return the names of ``--methods``, checked later; all if left out."""
    return METHODS if text is None else tuple(part.strip() for part in text.split(","))
