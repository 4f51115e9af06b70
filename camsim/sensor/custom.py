"""Custom electronic stages: checks of their declarations and of their results."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from annotated_types import MinLen

from camsim.core.annotations import Called
from camsim.core.arrays import F64
from camsim.core.custom import check_described, is_custom, refused
from camsim.core.typed import Index, NonNegative, check
from camsim.core.words import displayed
from camsim.errors import InvalidValueError
from camsim.sensor.stage import CUSTOM_STREAMS, Context, ElectronicStage, Phase, streams_of

KEY = "extra_stages"

_FACTS: dict[str, Any] = {
    "name": Annotated[str, MinLen(1), Called("a text", 'such as name: ClassVar = "ripple"')],
    "phases": Annotated[
        tuple[Annotated[Phase, Called("a camsim.Phase", "such as camsim.Phase.READ")], ...],
        MinLen(1),
        Called("a tuple of camsim.Phase", "such as (camsim.Phase.READ,)"),
    ],
    "stream": Annotated[int | tuple[int, ...] | None, Called("a whole number, a tuple of them or None")],
    "temporal": bool,
    "without_noise": bool,
    "margin": Index,
    "whole_window": bool,
}
"""Declarations of a stage, as listed by ``ElectronicStage``."""


def check_custom(stages: Sequence[ElectronicStage]) -> None:
    """Raise for stages that files cannot describe, with invalid declarations, or with shared random streams."""
    drawing: dict[int, str] = {}
    for stage in stages:
        _check(stage)
        name = type(stage).__name__
        for stream in streams_of(stage):
            if stream in drawing:
                free = max(*drawing, stream) + 1
                both = f"{drawing[stream]} and {name} both draw from stream {stream}"
                raise refused(KEY, f"{both}; each stage needs a different one, {free} is free")
            drawing[stream] = name


def _check(stage: ElectronicStage) -> None:
    name = type(stage).__name__
    if not isinstance(stage, ElectronicStage):
        raise refused(KEY, f"{name}; must be a dataclass that inherits from camsim.ElectronicStage")
    check_described(stage, KEY)
    for fact, kind in _FACTS.items():
        _statement(name, fact, getattr(stage, fact, None), kind)
    if taken := [stream for stream in streams_of(stage) if stream < CUSTOM_STREAMS]:
        raise refused(KEY, f"{name}: stream {taken[0]}; those below {CUSTOM_STREAMS} are camsim's")
    if stage.margin:
        raise refused(KEY, f"{name}: margin {stage.margin}; only crosstalk sees beyond the window")
    if stage.temporal and Phase.LIGHT in stage.phases:
        raise refused(KEY, f"{name}: in phase LIGHT only patterns of the sensor act; take CHARGE")
    _statement(name, "dark_noise_e(1.0)", stage.dark_noise_e(1.0), NonNegative)


def _statement(name: str, fact: str, value: Any, kind: Any) -> None:
    try:
        check(value, kind, fact)
    except InvalidValueError as error:
        raise refused(KEY, f"{name}.{fact}: {error.message}") from None


def drawn(stage: ElectronicStage, shape: tuple[int, int], context: Context) -> int:
    """Return the number of random numbers that a stage declares to draw for a window in a phase."""
    count = stage.draws(shape, context)
    if is_custom(stage):
        _statement(type(stage).__name__, "draws", count, Index)
    return int(count)


def acted(stage: ElectronicStage, electrons: F64, context: Context) -> F64:
    """Return the result of a stage; for a custom one, checks its shape, finite values and unmodified input."""
    if not is_custom(stage):
        return stage.apply(electrons, context)
    name = f"{type(stage).__name__}.apply"
    given = electrons.view()
    given.flags.writeable = False
    context = dataclasses.replace(context, shape=(electrons.shape[0], electrons.shape[1]), begun=set())
    try:
        after: Any = stage.apply(given, context)
    except ValueError as error:
        if "read-only" not in str(error):
            raise
        message = f"{name} writes into the electrons that came in; return others, such as electrons + …"
        raise refused(KEY, message) from error
    if after is None:
        raise refused(KEY, f"{name} gave None; return the electrons")
    if type(after) is not np.ndarray:
        raise refused(KEY, f"{name} gave {displayed(after)}; return an array of numpy")
    if after.shape != electrons.shape:
        raise refused(KEY, f"{name} gave {after.shape} for {electrons.shape}; return as many electrons as came in")
    if after.dtype.kind not in "fiu":
        raise refused(KEY, f"{name} gave numbers of type {after.dtype}; electrons are real numbers")
    if not (finite := np.isfinite(after)).all():
        row, col = np.argwhere(~finite)[0].tolist()
        value, first = after[row, col], context.first
        place = f"at row {first[0] + row}, column {first[1] + col} of the frame"
        raise refused(KEY, f"{name} gave {value} {place}, for {electrons[row, col]:.6g} e⁻; electrons are finite")
    numbers: F64 = after.astype(np.float64, copy=False)
    return numbers
