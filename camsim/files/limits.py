"""Limits of the memory that a file may require, checked before allocation."""

from __future__ import annotations

from camsim.errors import InputError

MOST_UNPACKED_BYTES = 256 << 20
"""Unpacked size allowed for a file of any size: 128 megapixels of 16 bits."""

MOST_RATIO = 16
"""Largest compression ratio of larger images. Pictures with noise compress to no less than a third."""


def refuse_bomb(needed_bytes: int, size: int) -> None:
    """Raise InputError if an image of ``needed_bytes`` exceeds the limit for a file of ``size`` bytes."""
    if needed_bytes > max(MOST_UNPACKED_BYTES, MOST_RATIO * size):
        raise InputError(
            f"its image takes {needed_bytes / 1e6:.0f} MB unpacked, from {size} bytes: more than "
            f"{MOST_UNPACKED_BYTES >> 20} MiB and {MOST_RATIO} times the file are refused; store it uncompressed"
        )


MOST_NUMBERS = 400_000_000
"""Most values of a picture or cube."""


def refuse_many(numbers: int) -> None:
    """Raise InputError if a picture has more values than the limit."""
    if numbers > MOST_NUMBERS:
        raise InputError(
            f"it holds {numbers / 1e6:.0f} million numbers, and {MOST_NUMBERS / 1e6:.0f} are the most "
            "that are read; cut it, or average samples or bands"
        )
