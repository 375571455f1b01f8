"""The sheets of docs/gallery: one sheet per family, with small pictures of its ops.

python -m gallery.pages.sheets FOLDER    from the pictures OP.jpg in FOLDER, without running anything
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from tools.columns import wrapped

from .page import ABOUT, families

DOCS = Path(__file__).resolve().parents[2] / "docs" / "gallery"
COLUMNS, WIDTH, GAP, TEXT = 6, 232, 8, 13
#: The fewest ops of a sheet: families with fewer ops share one.
LEAST = 45
QUALITY = 55
#: The README's picture: ops on different inputs.
HERO = (
    "filters.canny",
    "filters.median_blur",
    "filters.otsu_threshold",
    "enhance.equalize_clahe",
    "geometry.transform.warp_perspective.bilinear_zeros",
    "color.apply_colormap",
    "contrib.connected_components",
    "feature.detect_keypoints.dog",
    "geometry.depth.depth_to_normals",
    "geometry.calibration.undistort_image",
    "morphology.skeletonize",
    "filters.adaptive_threshold",
)
HERO_COLUMNS = 4


def sheets(names: Sequence[str]) -> list[list[str]]:
    """The names on each sheet."""
    found: list[list[str]] = []
    few: list[str] = []
    by_top: dict[str, list[list[str]]] = {}
    for family, members in families(names).items():
        by_top.setdefault(family.partition(".")[0], []).append(members)
    for groups in by_top.values():
        if sum(map(len, groups)) < LEAST // 2:
            few += [name for group in groups for name in group]
            continue
        open_sheet: list[str] = []
        for group in groups:
            open_sheet = [*open_sheet, *group]
            if len(open_sheet) >= LEAST:
                found.append(open_sheet)
                open_sheet = []
        if open_sheet and len(groups) > 1:
            found[-1] += open_sheet
        elif open_sheet:
            found.append(open_sheet)
    return [*found, few] if few else found


def title(names: Sequence[str]) -> str:
    """A sheet's title: a family, a family with its parts ("geometry: bbox, camera"), or several."""
    tops = sorted({name.partition(".")[0] for name in names})
    has_parts = len(tops) == 1 and all(name.count(".") >= 2 for name in names)
    parts = sorted({name.split(".")[1] for name in names})
    return f"{tops[0]}: {', '.join(parts)}" if has_parts else ", ".join(tops)


def draw(pictures: Path, names: Sequence[str], columns: int = COLUMNS) -> Image.Image:
    font = ImageFont.load_default(TEXT)
    tiles = []
    for name in names:
        picture = Image.open(pictures / f"{name}.jpg").convert("RGB")
        tiles.append(
            picture.resize((WIDTH, max(1, picture.height * WIDTH // picture.width)), Image.Resampling.LANCZOS)
        )
    rows = [range(i, min(i + columns, len(tiles))) for i in range(0, len(tiles), columns)]
    heights = [max(tiles[i].height for i in row) + 2 * TEXT + GAP for row in rows]
    sheet = Image.new("RGB", (columns * (WIDTH + GAP) + GAP, sum(heights) + GAP), "white")
    pen, top = ImageDraw.Draw(sheet), GAP
    for row, height in zip(rows, heights, strict=True):
        for column, i in enumerate(row):
            left = GAP + column * (WIDTH + GAP)
            sheet.paste(tiles[i], (left, top))
            label = names[i].partition(".")[2]
            while pen.textlength(label, font=font) > WIDTH:
                label = label[:-2] + "\N{HORIZONTAL ELLIPSIS}"
            pen.text((left, top + tiles[i].height + 1), label, "black", font=font)
        top += height
    return sheet


def write_sheets(pictures: Path, folder: Path) -> None:
    """Write the sheets, the page that shows them, and the README's picture."""
    drawn = sorted(p.stem for p in pictures.glob("*.jpg"))
    # Those on frames show what those on planes show.
    names = [
        name for name in drawn if name.removesuffix(".frames") not in drawn or not name.endswith(".frames")
    ]
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.jpg"):
        old.unlink()
    page = [
        "# Gallery",
        "",
        ABOUT,
        "",
        (
            f"{len(names)} ops; forms for frames of bytes look as those for planes, and are left out."
            f" `make gallery` writes a large picture of all {len(drawn)}, with what it shows, to"
            " `build/gallery/pictures`."
        ),
        "",
    ]
    for number, members in enumerate(sheets(names), 1):
        file = f"{number:02}-{title(members).partition(':')[0].replace(', ', '-')}.jpg"
        draw(pictures, members).save(folder / file, quality=QUALITY, optimize=True)
        page += [f"## {title(members)}", "", f"![{title(members)}]({file})", ""]
    draw(pictures, HERO, HERO_COLUMNS).save(folder.parent / "hero.jpg", quality=QUALITY + 10, optimize=True)
    (folder / "README.md").write_text(wrapped("\n".join(page[:-1]) + "\n"))


if __name__ == "__main__":
    write_sheets(Path(sys.argv[1]), DOCS)
