"""What the stages of the sensor refuse, in the words that they share."""

from __future__ import annotations

import math

from camsim.errors import InvalidValueError

ABSOLUTE_ZERO_C = -273.15


def check_number(stage: str, key: str, value: float, largest: float = math.inf) -> None:
    """Refuse a number below 0, above ``largest`` or not finite; up to 1 it is a fraction, and the message says so."""
    if not (math.isfinite(value) and 0.0 <= value <= largest):
        if largest == math.inf:
            allowed = "0 or more"
        elif largest == 1.0:
            allowed = "a fraction in 0..1 (0.01 means 1 %)"
        else:
            allowed = f"0..{largest:g}"
        raise InvalidValueError(f"{value}; must be {allowed}, and finite", key=key, stage=stage)


def check_positive(stage: str, key: str, value: float) -> None:
    """Refuse a number that is 0, below 0 or not finite."""
    check_number(stage, key, value)
    if value == 0.0:
        raise InvalidValueError("0; must be above 0", key=key, stage=stage)


def check_temperature(stage: str, key: str, temperature_c: float) -> None:
    """Refuse a temperature that does not exist, or that no silicon survives."""
    if temperature_c < ABSOLUTE_ZERO_C:
        raise InvalidValueError(
            f"{temperature_c}; is below absolute zero, {ABSOLUTE_ZERO_C} °C (this is not in kelvin)",
            key=key,
            stage=stage,
        )
    if not temperature_c <= 1000.0:
        raise InvalidValueError(f"{temperature_c}; must be {ABSOLUTE_ZERO_C}..1000 °C", key=key, stage=stage)
