"""Wording of messages about values and allowed ranges, shared by files and constructors."""

from __future__ import annotations

import dataclasses
import difflib
import re
import types
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from annotated_types import Ge, Gt, Le, Lt

from camsim.errors import nearest


def either(words: Sequence[str]) -> str:
    """Join alternatives.

    >>> either(["pixel", "um", "mm"])
    'pixel, um or mm'
    """
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def both(words: Sequence[str]) -> str:
    """Join items with commas and "and".

    >>> both(["Ripple", "Telegraph", "Haze"])
    'Ripple, Telegraph and Haze'
    """
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def in_range(limits: Iterable[Any]) -> str:
    """Return the limits of a number as a text to append.

    >>> in_range((Gt(0),)), in_range((Ge(0), Le(1))), in_range(())
    (' above 0', ' from 0 to 1', '')
    """
    limits = tuple(limits)
    above = next((f"{limit.gt:g}" for limit in limits if isinstance(limit, Gt)), None)
    least: Any = next((limit.ge for limit in limits if isinstance(limit, Ge)), None)
    below = next((f"{limit.lt:g}" for limit in limits if isinstance(limit, Lt)), None)
    most: Any = next((limit.le for limit in limits if isinstance(limit, Le)), None)
    if least is not None and most is not None:
        lowest = "−2^63" if least == -(2**63) else format(least, "g")
        return f" from {lowest} to {'2^63 − 1' if most == 2**63 - 1 else format(most, 'g')}"
    lower = f"above {above}" if above is not None else f"of {least:g} or more" if least is not None else ""
    upper = f"below {below}" if below is not None else f"at most {most:g}" if most is not None else ""
    return "".join(f" {part}" for part in (" and ".join(p for p in (lower, upper) if p),) if part)


def percent_hint(value: Any) -> str:
    """Return a hint for a percentage given in place of a fraction.

    >>> percent_hint(90)
    '; a fraction: 90 % is 0.9'
    """
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return f"; a fraction: {value:g} % is {value / 100:g}" if number and 1 < value <= 100 else ""


LIGHT_NM = (100.0, 20_000.0)
"""Range of wavelengths of light, nm: values outside it suggest another unit."""

_UNITS_NM = {"µm": 1e3, "m": 1e9, "Å": 0.1}


def wavelength_hint(value: Any, low_nm: float = LIGHT_NM[0], high_nm: float = LIGHT_NM[1]) -> str:
    """Return a hint for a wavelength given in another unit than nm.

    low_nm, high_nm : range of plausible wavelengths

    >>> wavelength_hint(0.55), wavelength_hint(5.5e-7), wavelength_hint(-1)
    ('; are µm meant? 0.55 µm are 550 nm', '; are m meant? 5.5e-07 m are 550 nm', '')
    >>> wavelength_hint(5500.0, 360.0, 830.0)
    '; are Å meant? 5500 Å are 550 nm'
    """
    if isinstance(value, int | float) and not low_nm <= value <= high_nm:
        for unit, in_nm in _UNITS_NM.items():
            if low_nm <= value * in_nm <= high_nm:
                return f"; are {unit} meant? {value:g} {unit} are {value * in_nm:g} nm"
    return ""


DECIMAL_POINT = "; a decimal number has a point, such as 1.5"
"""Hint for a list that is twice as long as it should be."""

_THOUSANDS = re.compile(r"([-+]?[1-9]\d{0,2})(([,' _]\d{3})+)(\.\d*)?|([-+]?[1-9]\d{0,2})((\.\d{3})+)(,\d+)")
_DECIMAL_COMMA = re.compile(r"([-+]?\d*),(\d+)")
_PERCENT = re.compile(r"([-+]?\d+(?:[.,]\d*)?)\s*%")
_PART = re.compile(r"(\d+(?:\.\d*)?)\s*/\s*(\d+(?:\.\d*)?)")
_STOP = re.compile(r"f\s*/?\s*(\d+(?:\.\d*)?)", re.IGNORECASE)
_WITH_UNIT = re.compile(r"([-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?)\s*[a-zµμ°²/]+", re.IGNORECASE)


def percent(fraction: float) -> str:
    """Return a fraction as a rounded percentage.

    >>> percent(1.0), percent(0.9972), percent(0.0394), percent(1e-7), percent(0.0)
    ('100 %', '99.7 %', '3.9 %', 'under 0.01 %', '0 %')
    """
    value = 100.0 * fraction
    if 0.0 < value < 0.01:
        return "under 0.01 %"
    return f"{value:.3g} %" if value >= 99.5 else f"{value:.2g} %"


def percent_range(low: float, high: float) -> str:
    """Return a range of fractions as percentages; a single one if both read the same.

    >>> percent_range(0.00388, 0.00391), percent_range(0.0039, 0.12)
    ('0.39 %', '0.39 to 12 %')
    """
    least, most = percent(low), percent(high)
    return most if least == most else f"{least.removesuffix(' %')} to {most}"


# Terms of other programs, of cameras and of data sheets for camsim's keys.
_OTHER_WORDS = {
    "base_iso": "iso native_iso",
    "background": "bg backdrop",
    "bit_depth": "bits bpp adc_bits depth",
    "black_level_dn": "black black_level offset pedestal bias",
    "blackbody_k": "cct kelvin temperature_k colour_temperature color_temperature",
    "centre": "center centre_um center_um position pos xy middle",
    "cfa": "bayer pattern color_filter filter mosaic",
    "cols": "columns width width_px nx",
    "csv": "file path table",
    "curves": "curve sensitivities response spectrum",
    "dark_current_e_per_s": "dark dark_current",
    "datetime": "date timestamp when",
    "dsnu_e": "dsnu fpn fixed_pattern",
    "electrons_per_dn": "gain system_gain conversion_gain e_per_dn k",
    "enabled": "on active disabled off",
    "f_number": "aperture fstop f_stop f n fno fnumber stop",
    "fill_factor": "fill ff",
    "full_well_e": "well capacity saturation full_well_capacity",
    "illuminance_lux": "lux lx illuminance brightness intensity level",
    "illuminant": "spectrum white_point temperature whitepoint",
    "height": "h height_um size_y",
    "iso": "sensitivity gain speed",
    "kind": "type shape form",
    "lens": "optics objective",
    "light": "illumination lighting source",
    "line_nm": "wavelength wavelength_nm laser laser_nm monochromatic",
    "origin": "offset start corner",
    "pattern": "phase order",
    "peak": "max qe maximum",
    "pitch_um": "pixel_size pixel_pitch pixel_size_um pitch_nm pitch_mm",
    "points": "vertices corners coordinates points_um polygon",
    "prnu": "gain_noise",
    "quantum_efficiency": "qe efficiency sensitivity",
    "radius": "r radius_um diameter diameter_um",
    "read_noise_e": "noise sigma read_noise_dn readnoise",
    "reflectance": "color colour albedo value fill grey gray neutral brightness",
    "region": "roi window crop",
    "rotate_deg": "angle rotation rotate angle_deg tilt rotate_rad",
    "rows": "lines height height_px ny",
    "seed": "random_state random_seed",
    "serial": "serial_number id",
    "shapes": "objects items polygons elements",
    "split_um": "separation shift width_um displacement distance_um",
    "time_s": "shutter shutter_s exposure exposure_time duration integration_time time_ms",
    "tolerance": "accuracy precision error eps",
    "unit": "units",
    "values": "value reflectances y",
    "width": "w width_um size size_x",
    "wavelength_nm": "wavelengths wavelengths_nm lambda nm x",
}


def meant(key: str, allowed: Sequence[str], *, alike: float = 0.6) -> str | None:
    """Return the allowed key that was probably meant; None if nothing is similar.

    alike : smallest similarity of two words, 0 … 1

    >>> meant("read_noise_dn", ["bit_depth", "read_noise_e"]), meant("angle", ["width", "rotate_deg"])
    ('read_noise_e', 'rotate_deg')
    >>> meant("r", ["radius_um", "reflectance"]), meant("lens", ["rows", "cols"])
    ('radius_um', None)
    """
    lowered = key.lower().replace("-", "_")
    if lowered in allowed:
        return lowered
    for known in allowed:
        words = _OTHER_WORDS.get(known) or _OTHER_WORDS.get(known.removesuffix("_um"), "")
        if lowered in words.split():
            return known
    near = difflib.get_close_matches(lowered, allowed, n=1, cutoff=alike)
    return near[0] if near else None


def word_hint(text: str, known: Sequence[str]) -> str:
    """Return a hint with the allowed words that were probably meant; empty if most words would fit.

    >>> word_hint("px", ["pixel", "um", "mm"]), word_hint("GGRB", ["RGGB", "BGGR", "GRBG", "GBRG"])
    ("; did you mean 'pixel'?", '')
    """
    near = nearest(text, known)
    return f"; did you mean {near[0]!r}?" if len(near) == 1 or 0 < 2 * len(near) <= len(known) else ""


def number_hint(text: str) -> str:
    """Return a hint for a text given in place of a number.

    >>> number_hint("2,8"), number_hint("5,000"), number_hint("1,000,000")
    ('; write 2.8, with a point', '; write 5000, or 5.000 with a point', '; write 1000000')
    >>> number_hint("18 %"), number_hint("1/100"), number_hint("f/8"), number_hint("10 ms")
    ('; a fraction: 18 % is 0.18', '; write 0.01', '; write 8', '; write the number alone, its unit is fixed')
    >>> number_hint("fast")
    ''
    """
    text = text.strip()
    if found := _DECIMAL_COMMA.fullmatch(text):
        whole, part = found.groups()
        point = f"{whole}.{part}"
        return (
            f"; write {whole}{part}, or {point} with a point"
            if _THOUSANDS.fullmatch(text)
            else f"; write {point}, with a point"
        )
    if found := _THOUSANDS.fullmatch(text):
        first, more, _, rest, first_too, more_too, _, rest_too = (part or "" for part in found.groups())
        digits = "".join(filter(str.isdigit, more + more_too))
        return f"; write {first}{first_too}{digits}{rest}{rest_too.replace(',', '.')}"
    if found := _PERCENT.fullmatch(text):
        percent = float(found[1].replace(",", "."))
        return f"; a fraction: {percent:g} % is {percent / 100.0:g}"
    if (found := _PART.fullmatch(text)) and float(found[2]):
        return f"; write {float(found[1]) / float(found[2]):.6g}"
    if found := _STOP.fullmatch(text):
        return f"; write {found[1]}"
    return "; write the number alone, its unit is fixed" if _WITH_UNIT.fullmatch(text) else ""


def displayed(value: Any) -> str:
    """Return a value as a short text of one line, for messages.

    >>> displayed(-1.0), displayed("eight"), displayed([1, 2]), displayed(None)
    ('-1.0', "'eight'", 'a list of 2', 'None')
    """
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    if isinstance(value, str | bool | float | types.NoneType):
        return ascii(value)[:40]
    if isinstance(value, int):
        return str(value) if abs(value) < 2**64 else "a number of many digits"
    return f"the class {value.__name__}" if isinstance(value, type) else called(type(value))


def called(kind: type) -> str:
    """Return the name of a class with its article.

    >>> called(int), called(object)
    ('an int', 'an object')
    """
    name = getattr(kind, "__name__", "something else")
    return f"{'an' if name[:1] in 'AEIOaeiou' else 'a'} {name}"


def kebab(kind: type) -> str:
    """Return the name of a class as in files, in kebab case.

    >>> class RegularPolygon: ...
    >>> kebab(RegularPolygon)
    'regular-polygon'
    """
    return "".join(f"-{letter.lower()}" if letter.isupper() else letter for letter in kind.__name__).removeprefix("-")


def brief(value: object) -> str:
    """Return the expression of a stage on one line, without default values, and with long lists abbreviated.

    >>> from camsim.spectra.curve import Curve
    >>> Curve(range(400, 701, 10), [0.5] * 31)
    Curve(wavelength_nm=(400.0, 410.0, …, 700.0: 31), values=(0.5, 0.5, …, 0.5: 31))
    """
    if (stated := getattr(value, "stated_briefly", None)) is not None:
        return str(stated)  # a stage with large tables
    if not dataclasses.is_dataclass(value):
        return _in_short(value) if isinstance(value, int | float | str) else f"{type(value).__name__}(…)"
    parts = ((field, getattr(value, field.name)) for field in dataclasses.fields(value) if field.repr)
    stated = [f"{field.name}={_in_short(part)}" for field, part in parts if not _as_usual(field, part)]
    return f"{type(value).__name__}({', '.join(stated)})"


def duration(seconds: float) -> str:
    """Return a duration as a readable text.

    >>> [duration(s) for s in (0.0123, 59.6, 1370.0, 7384.0)]
    ['0.0123 s', '59.6 s', '22 min 50 s', '2 h 3 min']
    """
    if seconds < 100.0:
        return f"{seconds:.3g} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


_MOST_LETTERS, _MOST_ITEMS = 100, 6


def _as_usual(field: dataclasses.Field[Any], value: object) -> bool:
    if field.default_factory is not dataclasses.MISSING:
        return bool(value == field.default_factory())
    return value is field.default or (type(value) is type(field.default) and bool(value == field.default))


def _in_short(value: object) -> str:
    if isinstance(value, list | tuple) and value:
        ends = value if len(value) <= _MOST_ITEMS else (*value[:2], "…", value[-1])
        items = ", ".join("…" if item == "…" else _in_short(item) for item in ends)
        whole = f"{items}: {len(value)}" if len(value) > _MOST_ITEMS else f"{items}," if len(value) == 1 else items
        return f"({whole})"
    if isinstance(value, np.ndarray):
        return displayed(value)
    text = brief(value) if dataclasses.is_dataclass(value) and not isinstance(value, type) else repr(value)
    if len(text) <= _MOST_LETTERS:
        return text
    return f"{text[:40]}…" if isinstance(value, str) else f"{type(value).__name__}(…)"
