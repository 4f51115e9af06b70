"""What the lens throws on the photosites: the part of a picture that light, time and electronics only scale."""

from __future__ import annotations

import hashlib
import pickle
from dataclasses import dataclass
from typing import Any

from camsim.rendering import Rendering
from camsim.rendering.auto import Choice


@dataclass(frozen=True, slots=True, kw_only=True)
class OpticalImage:
    """Electrons per J/m² of radiant exposure in every photosite, and how they were found."""

    choice: Choice
    rendering: Rendering


def key_of(*made_of: Any) -> str:
    """Return a name of all that makes an optical image: equal for equal parts."""
    return hashlib.sha256(pickle.dumps(made_of)).hexdigest()
