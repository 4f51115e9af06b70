"""Error against run time for any scene: every method at every tolerance, compared with the other exact engine."""

from camsim.bench.records import Bench, Finding, Head, LeftOut, Point, TruthLine
from camsim.bench.running import bench_scene

__all__ = ["Bench", "Finding", "Head", "LeftOut", "Point", "TruthLine", "bench_scene"]
