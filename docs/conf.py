"""How `make docs` makes the site: these pages, docstrings, and what stands elsewhere."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / part) for part in ("shared", "host", "docs/site")]

from larics import __version__  # noqa: E402  (needs the path)

project = "LARICS camera"
author = "LARICS"
release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode", "docstrings", "pages_elsewhere"]
exclude_patterns = ["site"]
myst_heading_anchors = 3
myst_links_external_new_tab = False
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
html_theme = "furo"
html_title = "LARICS camera %s" % release
html_show_copyright = False
nitpicky = False
html_css_files = ["wide.css"]
html_static_path = ["site/static"]
pygments_style = "default"
