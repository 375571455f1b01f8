"""make gallery: one picture per op, computed by its bundle in the C++ runtime -> build/gallery, and a sheet
per family -> docs/gallery."""

from __future__ import annotations

import inspect
import shutil
import sys
import warnings
from fnmatch import fnmatch
from pathlib import Path

import click
from PIL import Image
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from chiasm.export.catalog import Entry, catalog
from chiasm.export.manifest import SUFFIX, read_manifest
from chiasm.export.tracing.module import bind_spec
from gallery.cases import BUILD, ROOT, read_results, run, write_cases
from gallery.inputs import inputs, telling
from gallery.layout import compose, contact_sheet, titled
from gallery.panels import Shown, caption, panels

from .page import families, write_pages
from .sheets import write_sheets
from .views import scene

DOCS = ROOT / "docs" / "gallery"
WORK = BUILD / "gallery"
PICTURES = WORK / "pictures"
QUALITY = 80


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("patterns", nargs=-1)
@click.option(
    "-b",
    "--bundles",
    type=click.Path(path_type=Path, exists=True, file_okay=False),
    default=BUILD / "bundles",
    help="Folder of the bundles. [default: build/bundles]",
)
def main(patterns: tuple[str, ...], bundles: Path) -> None:
    """Draw the gallery.

    PATTERNS are names, or shell patterns such as 'filters.*': then only those are drawn, with sheets in
    build/gallery, and docs/gallery is left alone.
    """
    warnings.simplefilter("ignore")
    entries = {
        name: e for name, e in catalog().items() if not patterns or any(fnmatch(name, p) for p in patterns)
    }
    missing = [name for name in entries if not (bundles / f"{name}{SUFFIX}" / "manifest.json").is_file()]
    if missing or not entries:
        raise click.ClickException(
            f"{bundles} has no bundle of {', '.join(missing)}: `make bundles` makes them"
            if missing
            else f"no op matches {' '.join(patterns)}"
        )
    shutil.rmtree(WORK / "cases", ignore_errors=True)
    if not patterns:
        shutil.rmtree(PICTURES, ignore_errors=True)
    PICTURES.mkdir(parents=True, exist_ok=True)
    console = Console(width=None if sys.stdout.isatty() else 170)
    captions: dict[str, str] = {}
    problems: dict[str, str] = {}
    columns = TextColumn("{task.description:20}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console) as progress:
        for name in progress.track(entries, description="running from C++"):
            try:
                captions[name], problem = draw(entries[name], bundles / f"{name}{SUFFIX}")
            except RuntimeError as error:
                problem = str(error)
            if problem:
                problems[name] = problem
                console.print(f"{name}: {problem}", style="red", highlight=False, markup=False)
    for family, names in families(captions).items():
        contact_sheet(
            [titled(Image.open(PICTURES / f"{n}.jpg"), n, captions[n]) for n in names], WORK / f"{family}.png"
        )
    if not patterns:
        write_pages(
            captions,
            {n: (inspect.getdoc(entries[n].function()) or "").split("\n")[0] for n in captions},
            PICTURES,
        )
        write_sheets(PICTURES, DOCS)
    console.print(
        f"{len(captions)} pictures in {PICTURES.relative_to(ROOT)}, sheets in"
        f" {(WORK if patterns else DOCS).relative_to(ROOT)}, {len(problems)} problems",
        highlight=False,
    )
    if problems:
        raise SystemExit(1)


def draw(entry: Entry, bundle: Path) -> tuple[str, str]:
    """Write an op's picture; returns its caption, and a description of wrong values, if there are any."""
    spec, chosen, folder = entry.spec, scene(entry.spec.name), WORK / "cases" / entry.spec.name
    photos = chosen.images()
    given = telling(bind_spec(entry.function(), spec), inputs(spec, photos, chosen.target, points=24))
    outputs = write_cases(entry, bundle, [("scene", given)], folder)[0]["outputs"]
    artifacts = read_manifest(bundle)["methods"]["forward"]["artifacts"]
    backend = "native" if any(a["backend"] == "native" for a in artifacts) else "onnx"
    report = run(folder / "cases.json", backend)
    if "problem" in report:
        raise RuntimeError(f"{backend}: {report['problem']}")
    results = read_results(folder, outputs, backend)
    shown = Shown(
        spec, photos[0], given, outputs, {o["name"]: r for o, r in zip(outputs, results, strict=True)}
    )
    made = panels(shown)
    compose(made).save(PICTURES / f"{spec.name}.jpg", quality=QUALITY, optimize=True)
    case = report["cases"][0]
    return caption(shown, made), (
        f"{case['wrong']} values differ from eager Python's by up to {case['error']:.2g}"
        if case["wrong"]
        else ""
    )


if __name__ == "__main__":
    main()
