"""MeasuredMatrix: a camera's colour matrix measured from a photograph of a chart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, TypeAlias

import numpy as np
from annotated_types import MaxLen, MinLen

from camsim.core.annotations import Called
from camsim.core.arrays import F64
from camsim.core.typed import Several, refusal, validate
from camsim.core.words import brief

_LEAST_RANK = 1e-6

Triple: TypeAlias = Annotated[Several[float], MinLen(3), MaxLen(3), Called("three numbers")]
Rows: TypeAlias = Annotated[Several[Triple], MinLen(3), MaxLen(3), Called("three rows of three numbers")]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredMatrix:
    """From red, green and blue to CIE XYZ under one light, as measured; files carry it in place of a fitted one.

    light         : name of the light;  white_xyz: the XYZ of a perfect diffuser in it, Y = 1
    camera_to_xyz : rows X, Y, Z of red, green and blue above black, on any scale. The values that it maps to
                    ``white_xyz`` are the camera's white balance

    >>> matrix = MeasuredMatrix(
    ...     light="D50",
    ...     white_xyz=(0.9642, 1.0, 0.8249),
    ...     camera_to_xyz=((1.2, 0.1, 0.1), (0.5, 0.9, -0.2), (0.0, -0.1, 1.5)),
    ... )
    >>> matrix.neutral.round(3).tolist()
    [0.681, 0.868, 0.608]
    """

    light: Annotated[str, MinLen(1)]
    white_xyz: Triple
    camera_to_xyz: Rows

    if TYPE_CHECKING:

        def __init__(self, *, light: str, white_xyz: Triple, camera_to_xyz: Rows) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        if not min(self.white_xyz) > 0.0:
            raise refusal(self, "white_xyz", f"{self.white_xyz}; a white has X, Y and Z above 0")
        spread = np.linalg.svd(self.matrix, compute_uv=False)
        if not spread[-1] > _LEAST_RANK * spread[0]:
            raise refusal(self, "camera_to_xyz", "its rows are not independent: they determine no colour")
        if not min(self.neutral) > 0.0:
            stated = ", ".join(f"{value:.4g}" for value in self.neutral)
            raise refusal(self, "camera_to_xyz", f"its white has red, green and blue of {stated}; all are above 0")

    @property
    def matrix(self) -> F64:
        """(3, 3) ``camera_to_xyz`` as an array."""
        return np.array(self.camera_to_xyz, np.float64)

    @property
    def neutral(self) -> F64:
        """(3,) red, green and blue of a perfect diffuser, on the matrix's scale."""
        return np.asarray(np.linalg.solve(self.matrix, np.array(self.white_xyz)), np.float64)
