"""The documentation site: ``make docs`` writes it into out/site, and judges it (docs/_ext/judge.py)."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent / "_ext"), str(Path(__file__).parents[1])]

from camsim import __version__  # noqa: E402

project = "camsim"
author = "The camsim developers"
copyright = "the camsim developers, BSD-3-Clause"
release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "docstrings", "outside"]
exclude_patterns = ["_ext"]
highlight_language = "none"
nitpicky = False

myst_heading_anchors = 4
myst_enable_extensions = ["html_image"]

autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_display_short_literal_types = True
python_maximum_signature_line_length = 88
add_module_names = False

html_theme = "pydata_sphinx_theme"
html_title = "camsim"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_sidebars = {"gallery": [], "accuracy": [], "limits": []}  # pages with nothing below them
html_theme_options = {
    "navigation_with_keys": False,
    "show_prev_next": True,
    "navbar_align": "left",
    "header_links_before_dropdown": 9,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
