"""Deferred imports from higher layers, for convenience methods of classes.

Modules import only from lower layers. ``Camera.from_yaml`` reads YAML and ``Frame.save`` writes files, which depend on
cameras and frames; the classes import them by name when they are called. The permitted targets are listed in
``tests/architecture/test_layers.py``.
"""

from __future__ import annotations

import importlib
from typing import Any


def above(place: str) -> Any:
    """Return an object of a higher layer by name, such as ``api.load``; its module is loaded at the first call."""
    module, _, name = place.rpartition(".")
    return getattr(importlib.import_module(f"camsim.{module}"), name)
