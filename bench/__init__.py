"""Benchmarks and studies: the paper's tables, other programs, extremes, scaling. Nothing of camsim imports it."""
