"""Documentation site: `.ci/site` builds it with Sphinx."""

import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent

project = "Barnard"
author = "The Barnard developers"
copyright = "the Barnard developers, MIT or Apache-2.0"
release = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
extensions = ["myst_parser", "sphinx_design", "sphinx_copybutton"]
exclude_patterns = ["notebooks", "requirements.txt"]
nitpicky = True

# Headings have the anchors that GitHub gives them.
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence", "html_image"]

html_theme = "furo"
html_title = f"Barnard {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["live.js"]
html_theme_options = {"source_directory": "docs/", "top_of_page_buttons": []}
html_copy_source = False
html_show_sphinx = False
pygments_style = "friendly"
pygments_dark_style = "monokai"


def links_within_the_site(app, docname, source):
    """Links of GitHub to files outside of docs lead to their pages here."""
    source[0] = source[0].replace("(../ARCHITECTURE.md)", "(architecture.md)")


def setup(app):
    app.connect("source-read", links_within_the_site)
