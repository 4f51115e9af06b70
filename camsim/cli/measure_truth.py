"""``camsim measure truth``: the truth of a scene or of a camsim file, in another space."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from camsim.cli.tables import print_table
from camsim.errors import InputError, UnknownNameError
from camsim.files.planes import check_planes_file, write_planes

if TYPE_CHECKING:
    from camsim.camera.capture import Capture

_YAML = (".yaml", ".yml", "")


@dataclass(frozen=True, slots=True, kw_only=True)
class TruthRequest:
    """The options of the command, as the user gave them."""

    source: str
    space: str
    output: str
    sensor: str | None
    sensors: Sequence[str]
    changes: Sequence[str]
    as_json: bool
    force: bool


def measure(request: TruthRequest) -> None:
    """Compute, write and print the truth; raises CamsimError with one sentence."""
    from camsim.measure.truth import SPACES, truth_in

    check_planes_file(request.output, force=request.force)
    space = next((name for name in SPACES if name == request.space), None)
    if space is None:
        raise UnknownNameError("space", request.space, SPACES, key="--space")
    truth = truth_in(_capture(request), space)
    stated: dict[str, Any] = {
        "file": request.output,
        "space": truth.space,
        "unit": truth.unit,
        "rows": truth.image.shape[0],
        "cols": truth.image.shape[1],
        "error_estimate": truth.error_estimate,
        "channels": [
            {
                "name": name,
                "diffuser": truth.diffuser[k],
                "mean": float(truth.image[..., k].mean(dtype=np.float64)),
                "least": float(truth.image[..., k].min()),
                "largest": float(truth.image[..., k].max()),
            }
            for k, name in enumerate(truth.channels)
        ],
    }
    write_planes(request.output, truth.image, truth.channels, {"camsim:space": truth.space, "camsim:units": truth.unit})
    if request.as_json:
        print(json.dumps(stated, indent=2, ensure_ascii=False))
        return
    rows = [
        [c["name"], *(f"{c[key]:.6g}" for key in ("diffuser", "mean", "least", "largest"))] for c in stated["channels"]
    ]
    title = f"{request.output}: {stated['rows']} × {stated['cols']}, {truth.unit}; error {truth.error_estimate:.2g}"
    print_table(title, ("channel", "perfect diffuser", "mean", "least", "largest"), rows)


def _capture(request: TruthRequest) -> Capture:
    """Return the capture of a scene's name or file, or that of a camsim file."""
    if Path(request.source).suffix.lower() in _YAML:
        from camsim.api import load

        return load(
            request.source,
            sensor=request.sensor,
            overrides=request.changes,
            sensors=request.sensors,
            products=("truth",),
        )
    from camsim.config.from_record import capture_from_record
    from camsim.files.reading import read_file

    held = read_file(request.source)
    try:
        held.record.check_size(held.rows, held.cols)
        return capture_from_record(held.description)
    except InputError as error:
        raise InputError(f"cannot take {request.source!r} again: {error}") from None
