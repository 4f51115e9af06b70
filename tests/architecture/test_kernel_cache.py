"""Compiled kernels never outlive the sources they were compiled from."""

import os

from camsim.rendering.kernels import forget_stale


def test_an_index_older_than_any_source_goes(tmp_path):
    cache = tmp_path / "__pycache__"
    cache.mkdir()
    for name, age in (
        ("a.py", 50),
        ("b.py", 10),
        ("__pycache__/a.f-1.py311.nbi", 30),
        ("__pycache__/b.g-1.py311.nbi", 5),
    ):
        path = tmp_path / name
        path.write_bytes(b"")
        os.utime(path, (1e9 - age, 1e9 - age))
    forget_stale(tmp_path, cache)
    # a.py itself has not changed since, but it may have taken in what b.py was then.
    assert [index.name for index in cache.iterdir()] == ["b.g-1.py311.nbi"]
