"""A study given as a mapping, converted to values as in a file."""

from __future__ import annotations

import datetime
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from camsim.config.tree import KeyPath, dotted
from camsim.config.yaml_source import MAX_DEPTH
from camsim.core.words import displayed
from camsim.errors import ConfigError, Fault


def plain(value: Any, kind: str, path: KeyPath = ()) -> Any:
    """Return numbers of numpy as Python's, arrays and ranges as lists, paths and dates as text; ``kind``: of the study.

    Raises ConfigError for values that files cannot express.

    >>> plain({"vary": {"exposure.iso": np.linspace(200.0, 400.0, 2), "noise.seed": range(2)}}, "study")
    {'vary': {'exposure.iso': [200.0, 400.0], 'noise.seed': [0, 1]}}
    """
    if len(path) > MAX_DEPTH:
        raise _fault(kind, (), f"nested more than {MAX_DEPTH} deep")
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, Mapping):
        if (wrong := next((key for key in value if not isinstance(key, str)), None)) is not None:
            raise _fault(kind, path, f"its keys must be texts, not {displayed(wrong)}")
        return {str(key): plain(part, kind, (*path, str(key))) for key, part in value.items()}
    if isinstance(value, list | tuple | range):
        return [plain(part, kind, (*path, number)) for number, part in enumerate(value)]
    if value is None or isinstance(value, bool):
        return value
    for bare in (int, float, str):
        if isinstance(value, bare):
            return bare(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, datetime.date):
        return str(value)
    raise _fault(
        kind, path, f"must be what a file can say: a number, a text, a list or a table, not {displayed(value)}"
    )


def _fault(kind: str, path: KeyPath, message: str) -> ConfigError:
    return ConfigError([Fault(kind, 0, 0, dotted(path), message)])
