"""How Sphinx makes the site; tools/site.sh lays out its sources."""

project = "chiasm"
author = copyright = "the authors of chiasm"
extensions = ["myst_parser"]
root_doc = "index"
include_patterns = ["index.md", "*.md", "docs/**.md", "examples/**.md", "reference/**.md"]
# Notes are parts of the benchmarks' pages, which their generators put in
exclude_patterns = ["docs/*_notes.md"]
html_theme = "furo"
html_title = "chiasm"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
myst_heading_anchors = 4
# Diagrams stand as their text; Pygments does not know their language, nor how Triton writes protobuf
suppress_warnings = ["misc.highlighting_failure"]
