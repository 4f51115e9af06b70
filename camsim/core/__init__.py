"""The lowest layer: errors, arrays, declared types, caches, threads and compiled kernels."""
