"""The gallery's pages, in the HTML that GitHub renders inside Markdown."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from pathlib import Path

COLUMNS, LONGEST = 3, 100
ABOUT = """Written by `make gallery`; do not edit. Every picture is the work of an exported bundle that a C++
program ran on a photograph (from scikit-image) or on points and matrices, natively where the bundle has
native code. Inputs are at the left, with blue labels; outputs at the right, with orange ones."""


def families(names: Iterable[str]) -> dict[str, list[str]]:
    """Names by what is before the first dot, or before the second where that would be too many for a page."""
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
    """A page a family and one that leads to them."""
    index = ["# Gallery", "", ABOUT, "", "| family | ops |", "|---|---|"]
    for family, names in families(captions).items():
        listed = ", ".join(f"`{n.removeprefix(family)[1:]}`" for n in names)
        index.append(f"| [{family}]({family}.md) | {listed} |")
        (folder / f"{family}.md").write_text(page(family, names, captions, summaries))
    (folder / "README.md").write_text("\n".join(index) + "\n")


def page(family: str, names: list[str], captions: dict[str, str], summaries: dict[str, str]) -> str:
    lines = [f"# {family}", "", f"{len(names)} ops. [What is seen here](README.md).", "", "<table>"]
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
