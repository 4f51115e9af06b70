"""How much memory a file may ask for, judged before any is taken."""

from __future__ import annotations

from camsim.core.errors import InputError

MOST_UNPACKED_BYTES = 256 << 20
"""What any file may unpack to, however small it is: 128 megapixels of 16 bits."""

MOST_RATIO = 16
"""How much larger than the file an image beyond that may be. Pictures with noise pack to no less than a third."""


def refuse_bomb(needed_bytes: int, size: int) -> None:
    """Raise InputError when an image of ``needed_bytes`` is more than a file of ``size`` bytes is trusted with."""
    if needed_bytes > max(MOST_UNPACKED_BYTES, MOST_RATIO * size):
        raise InputError(
            f"its image takes {needed_bytes / 1e6:.0f} MB unpacked, from {size} bytes: more than "
            f"{MOST_UNPACKED_BYTES >> 20} MiB and {MOST_RATIO} times the file are not believed; store it uncompressed"
        )


MOST_NUMBERS = 400_000_000
"""Of a picture or cube, however large its file is."""


def refuse_many(numbers: int) -> None:
    """Raise InputError when a picture holds more numbers than are read."""
    if numbers > MOST_NUMBERS:
        raise InputError(
            f"it holds {numbers / 1e6:.0f} million numbers, and {MOST_NUMBERS / 1e6:.0f} are the most "
            "that are read; cut it, or average samples or bands"
        )
