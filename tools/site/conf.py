"""How Sphinx makes the site; tools/site.sh lays out its sources."""

from pathlib import Path

project = "chiasm"
author = copyright = "the authors of chiasm"
extensions = ["myst_parser", "breathe"]
breathe_projects = {"chiasm": str(Path(__file__).parents[2] / "build" / "site" / "doxygen" / "xml")}
breathe_default_project = "chiasm"
breathe_domain_by_file_pattern = {"*/chiasm.h": "c", "*/backend.h": "c"}
root_doc = "index"
include_patterns = ["index.md", "interface.md", "*.md", "docs/**.md", "examples/**.md", "reference/**.md"]
# Notes are included in the benchmarks' pages by their generators
exclude_patterns = ["docs/*_notes.md"]
html_theme = "furo"
html_title = "chiasm"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
myst_heading_anchors = 4
# First: diagrams are shown as text, and Pygments does not know their language, nor Triton's protobuf. Second:
# every header declares the namespace again.
suppress_warnings = ["misc.highlighting_failure", "duplicate_declaration.cpp"]
