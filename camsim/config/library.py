"""Find sensors, scenes and lenses: shipped ones by name, the user's by path."""

from __future__ import annotations

import difflib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

import camsim
from camsim.config.pictured import is_picture, way_out_of
from camsim.errors import CamsimError, ConfigError, Fault, UnknownNameError

Kind: TypeAlias = Literal["sensor", "scene", "lens"]
FOLDERS: dict[Kind, str] = {"sensor": "sensors", "scene": "scenes", "lens": "lenses"}

YAML_SUFFIXES = (".yaml", ".yml")

_ALIKE = 0.75
"""Similarity above which a name is a typo or an older version of another."""


@dataclass(frozen=True, slots=True)
class Located:
    """A file to read, and its name in messages: as given by the user, or ``scenes/NAME.yaml`` for a shipped one."""

    path: Path
    displayed: str


def shipped(kind: Kind) -> Mapping[str, Path]:
    """Return the shipped files of a kind by name, in alphabetical order."""
    return {path.stem: path for path in sorted(_folder(kind).glob("*.yaml"))}


def locate(kind: Kind, name: str) -> Located:
    """Find what the user named on the command line or in Python: a path from here, or a shipped name."""
    if (found := locate_path(kind, name)) is not None:
        return found
    known = shipped(kind)
    if name not in known:
        here = next((f"{name}{suffix}" for suffix in YAML_SUFFIXES if os.path.isfile(f"{name}{suffix}")), "")
        way_out = (
            f"for the file that lies here write {here}"
            if here
            else "a file of your own needs its path, such as ./my.yaml"
        )
        raise UnknownNameError(kind, name, known, hint=f"; {way_out}")
    return Located(known[name], f"{FOLDERS[kind]}/{name}.yaml")


def locate_path(kind: Kind, name: str) -> Located | None:
    """Find a file by its path from here; None for a bare name, raises ConfigError when there is no such file."""
    if os.path.isfile(name):
        refuse_pictures(Path(name), name)
        return Located(Path(name), name)
    if os.path.isdir(name) and name not in shipped(kind):
        raise ConfigError([Fault(name, 0, 0, "", way_out_of(Path(name)))])
    if not looks_like_path(name):
        return None
    if not os.path.exists(name):
        raise ConfigError([Fault(name, 0, 0, "", f"no such file{_near_file(kind, Path(name))}")])
    return Located(Path(name), name)


def refuse_pictures(path: Path, displayed: str) -> None:
    """Raise ConfigError if a picture is given in place of a YAML file; the message holds a scene that shows it."""
    if way_out := way_out_of(path):
        raise ConfigError([Fault(displayed, 0, 0, "", way_out)])


def in_folder(folder: Path, name: str, *, way_out: str = "put it there", also: Path | None = None) -> Path:
    """Return the path of a file that a file in ``folder`` names: under that folder, or directly in ``also``.

    Raises CamsimError about any other, so that a file from elsewhere reads nothing of the disk.
    """
    path = folder / name
    real = path.resolve()
    if not real.is_relative_to(folder.resolve()) and (also is None or real.parent != also.resolve()):
        raise CamsimError(f"{name!r} lies outside this file's folder; {way_out}")
    if not path.is_file():
        raise CamsimError(f"no such file: {str(path)!r}")
    return path


def _near_file(kind: Kind, path: Path) -> str:
    if path.stem in shipped(kind):
        return f"; for the shipped {kind} write {path.stem!r}"
    there = os.listdir(path.parent) if os.path.isdir(path.parent) else []
    if there and "*" in path.name:
        return f"; {path.parent} {way_out_of(path.parent)}"
    # Without their suffixes, which are alike whatever the files hold.
    names = {Path(name).stem: name for name in sorted(there) if name.endswith(YAML_SUFFIXES)}
    near = difflib.get_close_matches(path.stem, names, n=1, cutoff=_ALIKE)
    return f"; did you mean {str(path.parent / names[near[0]])!r}?" if near else ""


def looks_like_path(name: str) -> bool:
    """Whether a word is a path rather than a bare name."""
    known = name.endswith(YAML_SUFFIXES) or ("." in name and is_picture(Path(name)))
    return known or "/" in name or "\\" in name or name in (os.curdir, os.pardir)


def _folder(kind: Kind) -> Path:
    """Return the folder of shipped files: inside an installed wheel, or next to the package in a checkout."""
    package = Path(camsim.__path__[0])
    installed = package / "data" / FOLDERS[kind]
    return installed if installed.is_dir() else package.parent / FOLDERS[kind]
