"""Shared parts of the use cases (`make study WHAT=NAME`): their folders, and the page docs/use_cases.md that
their runs write."""

from __future__ import annotations

from dataclasses import fields
from datetime import date
from pathlib import Path

from bench.machine import cores, cpu
from gallery.cases import BUILD, ROOT
from tools.columns import wrapped

PAGE = ROOT / "docs" / "use_cases.md"
#: the folder of all pictures, next to the page: NAME.png or NAME_WHAT.png
PICTURES = ROOT / "docs" / "use_cases"
#: the sections' titles by example, in the page's order
TITLES = {
    "batch": "Batches of images",
    "registration": "Registration by gradient descent",
    "depth": "Depth of several views by gradient descent",
    "attack": "A targeted attack on the matching of two views",
    "distributed": "Several processes",
    "training": "Training with augmentation",
}
_HEAD = """# Use cases

The four use cases of the Kornia paper (E. Riba et al., Kornia: an Open Source Differentiable Computer Vision
Library for PyTorch, WACV 2020, section 4), distribution, and training with augmentation. The run of its
command writes each section, with all its numbers.
"""


def folder(name: str) -> Path:
    """The folder of an example's bundles and intermediate files."""
    made = BUILD / "studies" / name
    made.mkdir(parents=True, exist_ok=True)
    return made


def settings_table(settings: object) -> list[str]:
    """The fields of a dataclass as lines of Markdown."""
    rows = [f"| `{f.name}` | {getattr(settings, f.name)} |" for f in fields(settings)]
    return ["| setting | value |", "|---|---|", *rows, ""]


def publish(name: str, lines: list[str], page: Path = PAGE) -> None:
    """Write an example's section; the other sections stay unchanged."""
    sections = _sections(page)
    made = f"Written by `make study WHAT={name}` on {date.today()}: {cpu()}, {cores()} cores."
    sections[TITLES[name]] = "\n".join([made, "", *lines]).strip()
    body = [f"## {title}\n\n{sections[title]}\n" for title in TITLES.values() if title in sections]
    page.write_text(wrapped("\n".join([_HEAD, *body])))


def _sections(page: Path) -> dict[str, str]:
    if not page.exists():
        return {}
    parts = page.read_text().split("\n## ")[1:]
    return {title: text.strip() for title, _, text in (part.partition("\n") for part in parts)}
