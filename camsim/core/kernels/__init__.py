"""What compiled kernels have in common: how they are compiled, kept for the next process, and shared among threads."""

from camsim.core.kernels.dispatch import compiling, is_cached, kernel
from camsim.core.kernels.threads import ahead, shared, use_one_thread

__all__ = ["ahead", "compiling", "is_cached", "kernel", "shared", "use_one_thread"]
