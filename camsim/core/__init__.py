"""The ground: errors, arrays, declared types, caches, threads and compiled kernels."""
