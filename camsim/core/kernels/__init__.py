"""Infrastructure of compiled kernels: compilation, the cache on disk, and distribution among threads."""

from camsim.core.kernels.dispatch import compiling, is_cached, kernel
from camsim.core.kernels.threads import ahead, shared, use_one_thread

__all__ = ["ahead", "compiling", "is_cached", "kernel", "shared", "use_one_thread"]
