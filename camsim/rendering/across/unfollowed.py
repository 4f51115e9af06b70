"""The refusal of a lens of revolution that the edges' way does not follow."""

from __future__ import annotations

from camsim.errors import UnsupportedError


def unfollowed(what: str) -> UnsupportedError:
    """Return the error that says what was not enough."""
    return UnsupportedError(
        f"its wavefronts turn too often for {what}: weaker aberrations, or method: fourier", key="lens"
    )
