"""What the lens throws on the photosites: the part of a picture that light, time and electronics only scale."""

from __future__ import annotations

import dataclasses
import hashlib
import pickle
from dataclasses import dataclass
from typing import Any

from camsim.core.arrays import read_only
from camsim.core.errors import InvalidValueError
from camsim.rendering import Rendering
from camsim.rendering.auto import Choice
from camsim.scene import Scene


@dataclass(frozen=True, slots=True, kw_only=True)
class OpticalImage:
    """Electrons per J/m² of radiant exposure in every photosite, how they were found, and a name of all they are of."""

    choice: Choice
    rendering: Rendering
    key: str

    def __post_init__(self) -> None:
        read_only(self.rendering.image, self.rendering.planes)

    def refuse_for(self, key: str, *, every_channel: bool) -> None:
        """Raise InvalidValueError where a capture with this key has another optical image, or asks for more."""
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
"""The scene that was named last: captures of a study that show one hold it once, and are named one after another."""


def key_of(scene: Scene, *made_of: Any) -> str:
    """Return a name of all that makes an optical image: the same for equal parts."""
    known, name = _LAST[0]
    if known is not scene:
        name = _named(scene)
        _LAST[0] = scene, name
    return _named(name, *made_of)


def _named(*made_of: Any) -> str:
    digest = hashlib.sha256()
    pickler = _Plain(_Into(digest.update))
    pickler.fast = True  # equal parts that are one object and such as are two read alike
    pickler.dump(made_of)
    return digest.hexdigest()


@dataclass(frozen=True, slots=True)
class _Into:
    """A file that gives what is written to a function."""

    write: Any


class _Plain(pickle.Pickler):
    """Writes of dataclasses what they were made with, and nothing that they have worked out since."""

    def reducer_override(self, obj: Any) -> Any:
        if not dataclasses.is_dataclass(obj) or isinstance(obj, type):
            return NotImplemented
        one = type(obj)
        fields = [(field.name, getattr(obj, field.name)) for field in dataclasses.fields(obj) if field.init]
        return tuple, ((one.__module__, one.__qualname__, *fields),)
