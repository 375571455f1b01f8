"""The site's contents (tools/site/index.md); `make site` rejects a page that is in no list."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_every_page_is_in_a_list_of_contents() -> None:
    entries = (ROOT / "tools/site/index.md").read_text().split()
    listed = {page for entry in entries if entry.startswith("docs/") for page in ROOT.glob(f"{entry}.md")}
    pages = {*(ROOT / "docs").glob("*.md"), *(ROOT / "docs/howto").glob("*.md")}
    assert {page.name for page in pages - listed if not page.stem.endswith("_notes")} == set()
