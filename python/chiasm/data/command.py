# pyarrow and Ray are optional, and not in .venv:
# pyright: reportMissingImports=false
"""The command `chiasm map`."""

from __future__ import annotations

import os
import time
from pathlib import Path

import click

from ..export.command import BundlePath, OutputPath, jobs_option, pairs
from ..export.console import console
from ..export.text import one_line


@click.command("map")
@click.argument("bundle", type=BundlePath())
@click.argument("source", metavar="INPUT", type=click.Path(path_type=Path, exists=True))
@click.argument("output", type=OutputPath())
@click.option(
    "-c",
    "--column",
    "columns",
    multiple=True,
    metavar="NAME=COLUMN",
    help="Parquet: the column that an input of the op is read from. [default: of the same name]",
)
@click.option(
    "-s",
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="An input that is the same for all rows, as JSON (--set 'sigma=[[1.5, 1.5]]'); for one that only"
    " gives a size: --set like=480x640.",
)
@click.option(
    "--rows", type=click.IntRange(1), default=500, show_default=True, help="Images that go into one shard."
)
@jobs_option("Processes, or CPUs of `--ray local`.")
@click.option(
    "--ray",
    "address",
    metavar="ADDRESS",
    help="Run on Ray: `auto` or HOST:PORT of a cluster whose nodes all have INPUT and OUTPUT; `local` starts"
    " one here.",
)
def map_command(
    bundle: Path,
    source: Path,
    output: Path,
    columns: tuple[str, ...],
    settings: tuple[str, ...],
    rows: int,
    jobs: int,
    address: str | None,
) -> None:
    """Run a bundle over a data set.

    INPUT is a folder of images, WebDataset tars (a .tar, or a folder of them) or parquet (a .parquet, or a
    folder of them). The folders in it count too, also linked ones, but not hidden ones (.NAME).

    The folder OUTPUT gets a parquet file for each shard: some hundred images, a tar, a row group. Its rows
    have `id` (the image's path) or the other columns of the parquet; the op's outputs, as tensors, or as
    structs of `data` and `shape` where shapes differ; and `error`: null, or why the op could not take this
    image, whose outputs are then zeros, or null in structs.

    A shard's file appears when it is complete. After any interruption, run the same command again: it
    continues, and its files have the same bytes as those of one uninterrupted run. (If ONNX Runtime or
    libtorch runs the op, or on Ray, that holds for CPUs of one kind.)

    \b
    Examples:
      chiasm map bundles/pipelines.preprocess.chiasm photos inputs
      chiasm map bundles/pipelines.edges.chiasm train-000.tar edges --ray auto
      chiasm map bundles/filters.gaussian_blur2d.chiasm photos soft -s 'sigma=[[1.5, 1.5]]'
      chiasm map bundles/filters.sobel.chiasm table.parquet edges -c input=image
    """
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from .driver import fingerprint, in_processes, on_ray, output_folder
    from .errors import DataError
    from .shards import Shard, map_no_rows, plan

    try:
        import pyarrow  # noqa: F401
    except ImportError:
        raise DataError(
            'pyarrow is not installed, which reads and writes parquet: pip install "chiasm[data]"'
        ) from None
    shards, files = plan(source, rows)
    folder = Path(os.path.realpath(output))  # not resolve(), which raises an error of its own for a loop
    if folder.is_relative_to(source.resolve()) and source.is_dir():
        raise DataError(f"OUTPUT {output}: it is inside INPUT {source}: choose a folder beside it")
    mapping = _mapping(bundle, pairs("--column", columns), pairs("--set", settings), shards[0].kind)
    map_no_rows(shards[0], mapping)  # an error comes before the folder is made
    started = time.monotonic()
    with output_folder(folder, fingerprint(mapping, files, rows)):
        todo = [shard for shard in shards if not (folder / shard.file).exists()]
        done, bad, failures = 0, 0, list[str]()
        text = TextColumn("{task.description:44}")
        with Progress(
            text, BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), console=console
        ) as progress:
            task = progress.add_task("mapping", total=len(shards), completed=len(shards) - len(todo))

            def report(shard: Shard | None, failure: str | None, more: int, wrong: int) -> None:
                nonlocal done, bad
                done, bad = done + more, bad + wrong
                if failure is not None:
                    failures.append(failure)
                    console.print(
                        f"failed: {failure}", style="red", markup=False, highlight=False, soft_wrap=True
                    )
                rate = done / (time.monotonic() - started)
                progress.update(
                    task,
                    advance=shard is not None,
                    description=f"{done} rows, {bad} of them bad, {rate:.0f} a second",
                )

            if todo and address is not None:
                on_ray(todo, mapping, folder, address, jobs, report)
            elif todo:
                in_processes(todo, mapping, folder, jobs, report)
    if failures:
        raise DataError(f"{len(failures)} of {len(shards)} shards failed, the first: {failures[0]}")
    before = f", {len(shards) - len(todo)} of them by an earlier run" if len(todo) < len(shards) else ""
    click.echo(
        f"{len(shards)} shards in {one_line(output)}/{before}; {done} rows in this run, in"
        f" {time.monotonic() - started:.0f} s, {bad} of them bad (column `error` says why)"
    )


def _mapping(bundle: Path, columns: dict[str, str], settings: dict[str, str], kind: str):
    """The Map of the command's options: for image files its only column is the op's image."""
    from chiasm.export.images import is_image, setting
    from chiasm.export.manifest import read_manifest

    from .errors import DataError
    from .mapping import Map
    from .running import LAYOUTS
    from .shards import ID

    manifest = read_manifest(bundle)
    if "forward" not in manifest["methods"]:
        raise DataError(f"{bundle}: it has no method 'forward'")
    inputs = manifest["methods"]["forward"]["inputs"]
    for option, given in (("--set", settings), ("--column", columns)):
        if unknown := sorted(given.keys() - {t["name"] for t in inputs}):
            raise DataError(
                f"{option}: {manifest['name']} has no input {unknown[0]!r}: it has"
                f" {', '.join(t['name'] for t in inputs)}"
            )
    if twice := sorted(settings.keys() & columns.keys()):
        raise DataError(f"--set and --column: {twice[0]!r} is given by both")
    constants = {t["name"]: setting(t, settings, manifest["dtypes"]) for t in inputs if t["name"] in settings}
    if kind == "parquet":
        return Map(bundle, {**columns, **constants}, errors="column")
    if columns:
        raise DataError("--column: image files have no columns: leave it out")
    images = [t for t in inputs if t["name"] not in constants and is_image(t, LAYOUTS)]
    others = [t["name"] for t in inputs if t["name"] not in constants and t not in images[:1]]
    if not images or others:
        missing = f"needs {others[0]!r} too: --set {others[0]}=VALUE" if images else "takes no image"
        if not images and (given := [t["name"] for t in inputs if is_image(t, LAYOUTS)]):
            missing = f"takes no image beside {given[0]!r}: leave out --set {given[0]}"
        raise DataError(f"{manifest['name']} {missing}")
    outputs = {t["name"]: t["name"] for t in manifest["methods"]["forward"]["outputs"]}
    if ID in outputs.values():
        raise DataError(f"{manifest['name']} has an output {ID!r}, which is the column of the images' paths")
    return Map(bundle, constants, errors="column")
