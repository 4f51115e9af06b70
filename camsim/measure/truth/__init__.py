"""Ground truth at every photosite, in the colour spaces used for comparison."""

from camsim.measure.truth.image import SPACES, Space, TruthImage
from camsim.measure.truth.spaces import balanced, truth_in

__all__ = ["SPACES", "Space", "TruthImage", "balanced", "truth_in"]
