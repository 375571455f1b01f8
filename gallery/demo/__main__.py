"""make demo: part of the catalog on real photographs, from C++, on every backend.

The inputs and eager Python's results are written to build/demo; the C++ program demo_runner runs each bundle
in one process per backend, and reports the largest difference from eager Python, the times of loading and
running, and the memory. OpenCV does the same work for comparison. Then tables are printed and pictures
written.
"""

from __future__ import annotations

import json
import shutil
import sys
import warnings
from fnmatch import fnmatch
from pathlib import Path

import click
import numpy as np
import torch
from PIL import Image
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column, Table

from chiasm.export.catalog import Entry, catalog
from chiasm.export.manifest import SUFFIX
from chiasm.export.spec import Spec
from gallery.cases import BUILD, ROOT, Scene, read_results, run, write_cases
from gallery.inputs import inputs
from gallery.layout import compose, contact_sheet, titled
from gallery.panels import Shown, caption, panels
from gallery.photographs import photograph

DEMO = BUILD / "demo"
BACKENDS = ("native", "torch", "onnx")
PICTURE = 480
#: Names, or shell patterns, of the ops that the demo shows.
SHOWN = (
    "pipelines.edges",
    "pipelines.preprocess",
    "geometry.calibration.undistort_image",
    "geometry.conversions.axis_angle_to_rotation_matrix",
    "geometry.homography.find_homography_dlt",
    "geometry.transform.elastic_transform2d",
    "geometry.transform.pyrdown.by_2",
    "geometry.transform.resize.bicubic_antialias",
    "geometry.transform.resize.bilinear",
    "geometry.transform.rotate.frames",
    "geometry.transform.warp_affine.bilinear_zeros",
    "geometry.transform.warp_perspective.bicubic_border",
    "geometry.transform.warp_polar.linear",
    "feature.gftt_response",
    "feature.harris_*",
    "losses.ssim_loss",
    "color.apply_colormap",
    "color.rgb_to_grayscale",
    "color.rgb_to_hsv.frames",
    "color.sepia",
    "contrib.distance_transform_edt",
    "enhance.adjust_saturation",
    "enhance.equalize",
    "enhance.equalize_clahe",
    "enhance.normalize",
    "enhance.posterize.frames",
    "filters.bilateral_blur",
    "filters.canny.frames",
    "filters.gaussian_blur2d.frames",
    "filters.median_blur",
    "filters.motion_blur",
    "filters.sobel",
    "filters.unsharp_mask.frames",
    "image.draw_rectangle",
    "morphology.dilation",
    "morphology.gradient",
    "morphology.skeletonize",
)


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--list",
    "listing",
    is_flag=True,
    help="Print the names of the ops that the demo shows, and do nothing else.",
)
def main(listing: bool) -> None:
    """Run the demo on the bundles in build/demo/bundles."""
    if listing:
        click.echo(" ".join(shown_ops()))
        return
    warnings.simplefilter("ignore")
    entries = shown_ops()
    missing = [name for name in entries if not (bundle_of(name) / "manifest.json").is_file()]
    if missing:
        raise click.ClickException(
            f"{DEMO / 'bundles'} has no bundle of {', '.join(missing)}: `make demo` makes them"
        )
    console = Console(width=None if sys.stdout.isatty() else 170)
    for stale in ("cases", "pictures"):
        shutil.rmtree(DEMO / stale, ignore_errors=True)
    (DEMO / "pictures").mkdir(parents=True)
    reports: dict[str, dict] = {}
    pictures: list[Image.Image] = []
    columns = TextColumn("{task.description:56}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console) as progress:
        for name in progress.track(entries, description="running every bundle from C++"):
            spec, folder = entries[name].spec, DEMO / "cases" / name
            made = scenes(spec)
            outputs = write_cases(entries[name], bundle_of(name), made, folder)[0]["outputs"]
            reports[name] = {b: run(folder / "cases.json", b) for b in (*BACKENDS, "opencv")}
            ran = next((b for b in BACKENDS if reports[name][b]["cases"]), None)
            if ran:
                pictures.append(draw(spec, made[0][1], outputs, read_results(folder, outputs, ran)))
                pictures[-1].save(DEMO / "pictures" / f"{name}.png")
            if not sys.stdout.isatty():
                console.print(f"ran {name}", highlight=False)
    (DEMO / "report.json").write_text(json.dumps(reports, indent=1))
    contact_sheet(pictures, DEMO / "pictures.png")
    checks, failed = print_parity(console, reports)
    print_cost(console, reports)
    console.print(
        f"{len(pictures)} pictures in {(DEMO / 'pictures').relative_to(ROOT)}/, all on one page:"
        f" {(DEMO / 'pictures.png').relative_to(ROOT)}",
        highlight=False,
    )
    print(f"demo: {checks} checks from C++, {failed} failed")
    if failed:
        raise SystemExit(1)


def bundle_of(name: str) -> Path:
    return DEMO / "bundles" / f"{name}{SUFFIX}"


def shown_ops() -> dict[str, Entry]:
    """The part of the catalog that the demo shows."""
    return {
        name: entry for name, entry in catalog().items() if any(fnmatch(name, pattern) for pattern in SHOWN)
    }


def scenes(spec: Spec) -> list[Scene]:
    """(label, inputs) of the runs of one op; the pictures show the first run."""
    astronaut, cat, coffee = photograph("astronaut.png"), photograph("chelsea.png"), photograph("coffee.png")
    pairs = np.stack([coffee[60:315, 100:451], coffee[80:335, 140:491]])  # a batch of two, both sides odd
    photos = {"astronaut 512x512": astronaut[None], "cat 300x451": cat[None], "coffee 2 of 255x351": pairs}
    made = {label: inputs(spec, images) for label, images in photos.items()}
    if any(t.layout for t in spec.inputs):
        return list(made.items())
    return [("x".join(map(str, next(iter(given.values())).shape)), given) for given in made.values()]


def draw(
    spec: Spec, given: dict[str, torch.Tensor], outputs: list[dict], results: list[torch.Tensor]
) -> Image.Image:
    """The picture of one op."""
    shown = Shown(
        spec,
        photograph("astronaut.png"),
        given,
        outputs,
        {o["name"]: r for o, r in zip(outputs, results, strict=True)},
    )
    made = panels(shown)
    return titled(compose(made, PICTURE), spec.name, caption(shown, made))


def print_parity(console: Console, reports: dict[str, dict]) -> tuple[int, int]:
    table = Table(
        "op",
        "input",
        *BACKENDS,
        title="Parity: C++ against eager Python, largest difference",
        box=None,
        header_style="bold",
    )
    checks = failed = 0
    for name, report in reports.items():
        labels = [c["shape"] for b in BACKENDS for c in report[b]["cases"]] or [""]  # "": no backend ran it
        for row, label in enumerate(dict.fromkeys(labels) if len(set(labels)) > 1 else labels[:1]):
            cells = []
            for backend in BACKENDS:
                case = next(iter(report[backend]["cases"][row : row + 1]), None)
                bad = case is None or case["wrong"] > 0
                checks, failed = checks + 1, failed + bad
                text = (
                    report[backend].get("problem", "not run")
                    if case is None
                    else f"{case['error']:.1e} {'FAIL' if bad else 'pass'}"
                )
                cells.append(f"[{'red' if bad else 'green'}]{text}[/]")
            table.add_row(name if row == 0 else "", label, *cells)
    console.print(table)
    return checks, failed


def print_cost(console: Console, reports: dict[str, dict]) -> None:
    """Print load time, memory and time per run on the first input, with OpenCV's for comparison."""
    title = "Cost: load ms / memory MB / run ms, one process each; OpenCV (Debian's) on the same threads"
    table = Table(
        Column("op", no_wrap=True),
        *BACKENDS,
        "OpenCV run ms",
        "native vs OpenCV",
        title=title,
        box=None,
        header_style="bold",
    )
    for name, report in reports.items():
        cells = []
        for backend in BACKENDS:
            r = report[backend]
            cells.append(
                f"{r['load_ms']:6.1f} /{r['memory_mb']:6.1f} /{r['cases'][0]['ms']:8.3f}"
                if r["cases"]
                else "-"
            )
        peer = report["opencv"]["cases"][0]["ms"] if report["opencv"]["cases"] else None
        native = report["native"]["cases"][0]["ms"] if report["native"]["cases"] else None
        ratio = f"{peer / native:.2f}x" if peer and native else ""
        table.add_row(name, *cells, f"{peer:.3f}" if peer else "-", ratio)
    console.print(table)


if __name__ == "__main__":
    main()
