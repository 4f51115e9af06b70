"""What people take: every capture of the use set can be loaded, and what a run found becomes the page's table."""

import pytest

import camsim
from bench import use
from bench.paper.pages import filled


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("use")
    use.files(folder)
    return folder


@pytest.mark.parametrize("name", use.CAPTURES)
def test_captures_load(name, folder):
    _, scene, keys = use.CAPTURES[name]
    capture = camsim.load(folder / scene if scene in use.TAKEN["files"] else scene, overrides=use.overrides(keys))
    if "region" in keys:
        assert [capture.grid.rows, capture.grid.cols] == keys["region"][:2]
    assert capture.tolerance == keys.get("tolerance", capture.tolerance)


def test_a_run_becomes_the_table_of_the_page(tmp_path):
    small = dict(use.CAPTURES["slanted-edge"][2], region=[16, 16], tolerance=1e-3)
    use.CAPTURES["small"] = ["sixteen photosites", "slanted-edge", small]
    try:
        found = {"name": "small"} | use.captured("small", tmp_path)
        quick, slow = found | {"cpu_s": use.SHORT_S / 2}, found | {"cpu_s": 1.25}
        page = filled(
            use.PAGE.read_text(encoding="utf-8"), {"use": use.table([quick, slow, {"name": "mtf", "failed": "no"}])}
        )
    finally:
        del use.CAPTURES["small"]
    assert found["of_tolerance"] <= 1.0
    assert page.count("sixteen photosites") == 1
    assert f"| sixteen photosites | 1.2 | {found['peak_mb']:.0f} |\n<!-- /bench use -->" in page
