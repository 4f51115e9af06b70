"""The optical image on the photosites, which light level and exposure time only scale."""

from __future__ import annotations

import dataclasses
import hashlib
import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np

from camsim.core.arrays import read_only
from camsim.errors import InvalidValueError
from camsim.rendering import Rendering
from camsim.rendering.auto import Choice
from camsim.scene import Scene


@dataclass(frozen=True, slots=True, kw_only=True)
class OpticalImage:
    """Electrons per J/m² of radiant exposure in every photosite, with their rendering and the key of its inputs."""

    choice: Choice
    rendering: Rendering
    key: str

    def __post_init__(self) -> None:
        read_only(self.rendering.image, self.rendering.planes)

    def refuse_for(self, key: str, *, every_channel: bool) -> None:
        """Raise InvalidValueError if the key differs, or if every channel is needed and not present."""
        if self.key != key:
            message = (
                "belongs to a capture of another optical key (scene, optics, light, window and tolerance make it, and "
                "the exposure where points of light have electrons); render this one's own"
            )
            raise InvalidValueError(message, key="optical_image")
        if every_channel and self.rendering.planes is None:
            message = 'was rendered without every channel; ask for it with products=("truth",)'
            raise InvalidValueError(message, key="optical_image")


_LAST: list[tuple[Any, str]] = [(None, "")]
"""The last scene and its key: captures of a study that share a scene are keyed one after another."""


def key_of(scene: Scene, *made_of: Any) -> str:
    """Return a key of everything that determines an optical image: equal for equal inputs."""
    known, name = _LAST[0]
    if known is not scene:
        name = _named(scene)
        _LAST[0] = scene, name
    return _named(name, *made_of)


def _named(*made_of: Any) -> str:
    digest = hashlib.sha256()
    pickler = _Plain(_Into(digest.update))
    pickler.fast = True  # equal parts pickle alike whether or not they are one object
    pickler.dump(made_of)
    return digest.hexdigest()


@dataclass(frozen=True, slots=True)
class _Into:
    """A file object that passes written data to a function."""

    write: Any


class _Plain(pickle.Pickler):
    """Pickles dataclasses by init fields only, without cached results, and arrays that have a hash by that."""

    def reducer_override(self, obj: Any) -> Any:
        if not dataclasses.is_dataclass(obj) or isinstance(obj, type):
            return NotImplemented
        one = type(obj)
        fields = [(field.name, getattr(obj, field.name)) for field in dataclasses.fields(obj) if field.init]
        if known := getattr(obj, "sha256", ""):
            fields = [(name, value.shape if isinstance(value, np.ndarray) else value) for name, value in fields]
            fields.append(("sha256", known))
        return tuple, ((one.__module__, one.__qualname__, *fields),)
