"""How Sphinx builds the documentation: `make docs`. Nothing is fetched, the pages work without a network."""

import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

import bearing_twin  # noqa: E402

project = "bearing_twin"
author = "bearing_twin developers"
version = release = bearing_twin.__version__
copyright = "2026, bearing_twin developers, Apache-2.0"

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
exclude_patterns = ["*.csv"]
myst_heading_anchors = 4
myst_links_external_new_tab = False
suppress_warnings = ["myst.xref_missing"]  # links to files of the checkout; tests/test_readme.py looks at all links
add_module_names = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True

html_theme = "furo"
html_title = f"bearing_twin {version}"
html_static_path = ["_static"]
html_css_files = ["wide.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}


def filled_in(app, name: str, source: list[str]) -> None:
    """What follows from the tree: in api.md a directive a public name, in index.md the pages named nowhere else."""
    if name == "api":
        homes = bearing_twin._HOMES.items()
        kinds = {public: "autoexception" if home.endswith(".errors") else "autofunction" for public, home in homes}
        source[0] = source[0].replace(
            "PUBLIC_NAMES", "\n".join(f".. {kinds[one]}:: {home}.{one}\n" for one, home in homes)
        )
    if name == "index":
        named = {line.strip() for line in source[0].splitlines()} | {name}
        rest = sorted(page.stem for page in HERE.glob("*.md") if page.stem not in named)
        source[0] = source[0].replace("OTHER_PAGES", "\n".join(rest))


def as_restructured_text(app, what, name, obj, options, lines: list[str]) -> None:
    """Docstrings are plain text with code in backticks; what reStructuredText would take for marks is escaped."""
    parts = "\n".join(lines).split("`")
    for index, part in enumerate(parts):
        code = index % 2 and index < len(parts) - 1
        parts[index] = f"``{' '.join(part.split())}``" if code else re.sub(r"([*|_\\])", r"\\\1", part)
    lines[:] = "".join(parts).split("\n")


def setup(app) -> None:
    """Connects the two; the index is read again at every build, for pages that are new."""
    app.connect("env-get-outdated", lambda *_: ["index"])
    app.connect("source-read", filled_in)
    app.connect("autodoc-process-docstring", as_restructured_text)
