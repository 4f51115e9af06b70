"""Plain scalars by the rules of YAML 1.2 (core schema), which PyYAML does not follow."""

from __future__ import annotations

import re

from camsim.config.tree import Scalar

_WORDS: dict[str, Scalar] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **{sign + word: float(sign + "inf") for sign in ("", "+", "-") for word in (".inf", ".Inf", ".INF")},
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
_INTEGER = re.compile(r"[-+]?[0-9]+")
_OCTAL = re.compile(r"0o[0-7]{1,20}")
_HEXADECIMAL = re.compile(r"0x[0-9a-fA-F]{1,16}")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
# Python refuses integers of thousands of digits; no quantity here has more than twenty.
_LONGEST_INTEGER = 40


def resolve(text: str) -> Scalar:
    """Return the value of a plain (unquoted) scalar: number, truth value, None or text.

    >>> [resolve(text) for text in ("1e-3", "010", "0o10", "0x1F", "no", "true", "~", "1_000", "12:30")]
    [0.001, 10, 8, 31, 'no', True, None, '1_000', '12:30']
    """
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text):
        return int(text) if len(text) <= _LONGEST_INTEGER else float(text)
    if _OCTAL.fullmatch(text):
        return int(text[2:], 8)
    if _HEXADECIMAL.fullmatch(text):
        return int(text[2:], 16)
    if _FLOAT.fullmatch(text):
        return float(text)
    return text
