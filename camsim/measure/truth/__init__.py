"""What a perfect camera would have given at every photosite, in the spaces that people compare in."""

from camsim.measure.truth.image import SPACES, Space, TruthImage
from camsim.measure.truth.spaces import balanced, truth_in

__all__ = ["SPACES", "Space", "TruthImage", "balanced", "truth_in"]
