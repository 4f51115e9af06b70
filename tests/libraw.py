"""LibRaw's picture of a raw file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import rawpy


def developed(path: Path, space: str = "XYZ", **how: Any) -> np.ndarray:
    """Return a linear picture, (rows, cols, 3) in 0..1: bilinear, camera white balance, not scaled by content."""
    with rawpy.imread(str(path)) as raw:
        picture = raw.postprocess(
            **{"demosaic_algorithm": rawpy.DemosaicAlgorithm.LINEAR, "use_camera_wb": True} | how,
            output_color=rawpy.ColorSpace[space],
            output_bps=16,
            gamma=(1, 1),
            no_auto_bright=True,
            adjust_maximum_thr=0,
        )
    return np.asarray(picture / 65535)
