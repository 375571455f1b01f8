"""The gallery's pages, in the HTML that GitHub renders inside Markdown."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from pathlib import Path

COLUMNS, LONGEST = 3, 100
ABOUT = """Written by `make gallery`; do not edit. Exported bundles computed the pictures: a C++ program ran
each on a photograph (from scikit-image) or on points and matrices, natively if the bundle has native code.
Inputs are at the left, with blue labels; outputs at the right, with orange labels."""


def families(names: Iterable[str]) -> dict[str, list[str]]:
    """Names, grouped by the part before the first dot, or before the second dot if that is too many for a
    page."""
    found: dict[str, list[str]] = {}
    for name in sorted(names):
        found.setdefault(name.partition(".")[0], []).append(name)
    made: dict[str, list[str]] = {}
    for family, members in found.items():
        for name in members:
            made.setdefault(".".join(name.split(".")[:2]) if len(members) > LONGEST else family, []).append(
                name
            )
    return made


def write_pages(captions: dict[str, str], summaries: dict[str, str], folder: Path) -> None:
    """Write a page per family, and an index page."""
    index = ["# Gallery", "", ABOUT, "", "| family | ops |", "|---|---|"]
    for family, names in families(captions).items():
        listed = ", ".join(f"`{n.removeprefix(family)[1:]}`" for n in names)
        index.append(f"| [{family}]({family}.md) | {listed} |")
        (folder / f"{family}.md").write_text(page(family, names, captions, summaries))
    (folder / "README.md").write_text("\n".join(index) + "\n")


def page(family: str, names: list[str], captions: dict[str, str], summaries: dict[str, str]) -> str:
    lines = [f"# {family}", "", f"{len(names)} ops. [About these pictures](README.md).", "", "<table>"]
    for start in range(0, len(names), COLUMNS):
        cells = [cell(n, captions[n], summaries[n]) for n in names[start : start + COLUMNS]]
        lines += ["<tr>", *cells, "</tr>"]
    return "\n".join([*lines, "</table>"]) + "\n"


def cell(name: str, caption: str, summary: str) -> str:
    text = f"<br><sub>{escape(caption, quote=False)}</sub>" if caption else ""
    return (
        f'<td width="33%" valign="top"><img src="{name}.jpg" width="480"'
        f' alt="{name}"><br><b>{name}</b><br><sub>{escape(summary, quote=False)}</sub>{text}</td>'
    )
