"""An external demosaicing program, run by a command template on a capture's mosaic."""

from __future__ import annotations

import shlex
import string
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from camsim.camera.frame import Frame
from camsim.core.arrays import F32
from camsim.core.typed import check
from camsim.errors import InvalidValueError, UnsupportedError, in_brief
from camsim.files import save
from camsim.measure.demosaic.subject import planes_of
from camsim.measure.given import check_given
from camsim.measure.reading import Gamma, read_picture

LONGEST_S = 600
RESULTS = (".tiff", ".tif", ".png", ".exr", ".npy")
_PLACES = {"in": "mosaic.dng", "tiff": "mosaic.tiff", "npy": "mosaic.npy"}


def check_command(template: str, suffix: str) -> None:
    """Raise, before any work, for a command template that cannot be run."""
    try:
        named = {name for _, name, _, _ in string.Formatter().parse(template) if name is not None}
        shlex.split(template)
    except ValueError as error:
        raise InvalidValueError(f"{template!r} cannot be read ({error})", key="--run") from None
    if unknown := sorted(named - {*_PLACES, "out"}):
        raise InvalidValueError(
            f"{{{unknown[0]}}} is not known; there are {{in}} (a DNG), {{tiff}}, {{npy}} (its codes) and {{out}}",
            key="--run",
        )
    if "out" not in named or not named & set(_PLACES):
        raise InvalidValueError(
            f"{template!r} lacks {{in}} or {{out}}; write such as 'mydemosaic {{in}} {{out}}'", key="--run"
        )
    if suffix not in RESULTS:
        raise InvalidValueError(f"{suffix!r}; a result is one of {', '.join(RESULTS)}", key="--result")


def run_program(template: str, frame: Frame, *, suffix: str = ".tiff", gamma: Gamma = None) -> F32:
    """Return a program's result for a frame's mosaic: (rows, cols, 3), on any scale.

    template : words of the command, with {in} (a DNG), {tiff} or {npy} (the codes alone) and {out} in place of files
    """
    check_command(check(template, str, "template"), suffix)
    check_given(frame=frame)
    with TemporaryDirectory() as folder:
        places = {name: str(Path(folder) / file) for name, file in _PLACES.items()}
        for name, file in places.items():
            if f"{{{name}}}" in template:
                save(frame, file, product="mosaic")
        out = Path(folder) / f"result{suffix}"
        words = [word.format(out=out, **places) for word in shlex.split(template)]
        try:
            done = subprocess.run(words, capture_output=True, check=False, timeout=LONGEST_S, stdin=subprocess.DEVNULL)
        except FileNotFoundError:
            raise UnsupportedError(f"there is no program {words[0]!r}", key="--run") from None
        except (OSError, subprocess.TimeoutExpired) as error:
            raise UnsupportedError(f"{words[0]!r} did not run: {in_brief(error)}", key="--run") from None
        if done.returncode or not out.is_file():
            said = in_brief((done.stderr or done.stdout).decode("utf-8", "replace")[-300:])
            how = f"ended with {done.returncode}" if done.returncode else "wrote no {out}"
            raise UnsupportedError(f"{words[0]!r} {how}" + (f" and said: {said}" if said else ""), key="--run")
        return planes_of(read_picture(out, gamma=gamma))
