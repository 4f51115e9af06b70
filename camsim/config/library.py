"""Find sensors and scenes: shipped ones by name, the user's own by path."""

from __future__ import annotations

import difflib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

import camsim
from camsim.errors import CamsimError, ConfigError, Fault, UnknownNameError

Kind: TypeAlias = Literal["sensor", "scene"]
KINDS: tuple[Kind, ...] = ("sensor", "scene")

_SUFFIXES = (".yaml", ".yml")


@dataclass(frozen=True, slots=True)
class Located:
    """A file to read, and what to call it: as the user gave it, or ``scenes/NAME.yaml`` for a shipped one."""

    path: Path
    shown: str


def shipped(kind: Kind) -> Mapping[str, Path]:
    """Return the shipped files of a kind by name, in alphabetical order."""
    return {path.stem: path for path in sorted(_folder(kind).glob("*.yaml"))}


def locate(kind: Kind, name: str) -> Located:
    """Find what the user named on the command line or in Python: a path from here, or a shipped name."""
    if os.path.isfile(name):
        return Located(Path(name), name)
    if not _looks_like_path(name):
        return _shipped(kind, name)
    if not os.path.exists(name):
        raise ConfigError([Fault(name, 0, 0, "", f"no such file{_near_file(kind, Path(name))}")])
    return Located(Path(name), name)


def locate_any(name: str) -> tuple[Kind, Located]:
    """Find a path or a shipped name of either kind; a path counts as a sensor until it has been read."""
    if _looks_like_path(name) or os.path.isfile(name):
        return "sensor", locate("sensor", name)
    for kind in KINDS:
        if name in shipped(kind):
            return kind, locate(kind, name)
    raise UnknownNameError("sensor or scene", name, [name for kind in KINDS for name in shipped(kind)])


def beside(name: str, folder: Path) -> Path:
    """Return the path of what a file in ``folder`` names; it lies in that folder or below."""
    path = folder / name
    if not path.resolve().is_relative_to(folder.resolve()):
        raise CamsimError(f"{name!r} lies outside this file's folder; put it there")
    if not path.is_file():
        raise CamsimError(f"no such file: {str(path)!r}")
    return path


def locate_beside(kind: Kind, name: str, folder: Path) -> Located:
    """Find what a file in ``folder`` names: a file under that folder, or a shipped name."""
    if not _looks_like_path(name):
        return _shipped(kind, name)
    path = folder / name
    if not path.resolve().is_relative_to(folder.resolve()):
        raise CamsimError(f"{name!r} lies outside this file's folder; put it there or name it with --{kind}")
    if not path.is_file():
        raise CamsimError(f"no such file: {str(path)!r}")
    return Located(path, str(path))


def _near_file(kind: Kind, path: Path) -> str:
    if path.stem in shipped(kind):
        return f"; for the shipped {kind} write {path.stem!r}"
    there = os.listdir(path.parent) if os.path.isdir(path.parent) else []
    near = difflib.get_close_matches(path.name, [name for name in there if name.endswith(_SUFFIXES)], n=1)
    return f"; did you mean {str(path.parent / near[0])!r}?" if near else ""


def _looks_like_path(name: str) -> bool:
    return name.endswith(_SUFFIXES) or "/" in name or "\\" in name


def _shipped(kind: Kind, name: str) -> Located:
    known = shipped(kind)
    if name not in known:
        raise UnknownNameError(kind, name, known, hint="; a file of your own needs its path, such as ./my.yaml")
    return Located(known[name], f"{kind}s/{name}.yaml")


def _folder(kind: Kind) -> Path:
    """Return where the shipped files lie: inside an installed wheel, or beside the package in a checkout."""
    package = Path(camsim.__path__[0])
    installed = package / "data" / f"{kind}s"
    return installed if installed.is_dir() else package.parent / f"{kind}s"
