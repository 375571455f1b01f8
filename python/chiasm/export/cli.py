"""The command `chiasm`."""

from __future__ import annotations

import json
from collections.abc import Collection
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.table import Column, Table

from .. import __version__
from ..data.command import map_command
from ..doctor import report
from ..packs import SUFFIX, listing
from ..triton.command import triton
from .command import BundlePath, Group, OutputPath, jobs_option, pairs, password
from .console import console
from .isas import ISAS
from .manifest import FORMATS, METHODS, BundleError, read_manifest
from .text import first_sentence, one_line
from .workers import export_names

if TYPE_CHECKING:
    from .catalog import Entry


@click.group(cls=Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, message="chiasm %(version)s")
def main() -> None:
    """Export computer-vision ops to bundles; inspect, verify and run them.

    \b
    A first round:
      chiasm list
      chiasm export filters.sobel -o bundles
      chiasm info bundles/filters.sobel.chiasm
      chiasm verify bundles/filters.sobel.chiasm
      chiasm run bundles/filters.sobel.chiasm photo.jpg edges.png
      chiasm map bundles/pipelines.edges.chiasm photos edges
    A bundle is a folder, or the name of an installed one (`chiasm list --installed`).
    `chiasm doctor` says what this machine can run. For C and C++, an installed chiasm also has
    `--cmakedir`, `--includedir` and `--libdir`.
    """


@main.command("list")
@click.argument("patterns", nargs=-1)
@click.option("--installed", is_flag=True, help="List the bundles that Python packages have brought.")
def list_ops(patterns: tuple[str, ...], installed: bool) -> None:
    """List the ops that can be exported.

    PATTERNS are names, or shell patterns; without one, everything is listed.

    \b
    Examples:
      chiasm list 'filters.*' color.rgb_to_hsv
      chiasm list --installed
    """
    if installed:
        named = [(line.partition("  ")[0], line) for line in listing()]
        wanted = _matching(patterns, [n for n, _ in named], "installed bundle", "chiasm list --installed")
        for name, line in named:
            if name in wanted:
                click.echo(line)
        return
    table = Table(Column("op", no_wrap=True), "inputs", "what it does", box=None, header_style="dim")
    for name, entry in _select(patterns, everything=True).items():
        inputs = ", ".join(f"{t.name} ({', '.join(map(str, t.shape))})" for t in entry.spec.inputs)
        table.add_row(f"[bold]{name}[/]", inputs, escape(first_sentence(entry.function().__doc__)))
    console.print(table)


@main.command()
@click.argument("patterns", nargs=-1)
@click.option("-a", "--all", "everything", is_flag=True, help="Export the whole catalog.")
@click.option(
    "-o",
    "--output",
    type=OutputPath(),
    default=Path("bundles"),
    show_default=True,
    help="Folder that gets the bundles.",
)
@click.option(
    "-f",
    "--format",
    "formats",
    multiple=True,
    type=click.Choice(FORMATS),
    help="Make only this format (may be given again). [default: all]",
)
@click.option(
    "--isa",
    "isas",
    multiple=True,
    type=click.Choice(list(ISAS)),
    default=("x86-64-v3",),
    show_default=True,
    help="CPU level of the native code, or compute capability of a GPU (may be given again: the runtime takes"
    " the best that its machine has; armv8.2-a needs a cross-compiler here).",
)
@click.option(
    "--method",
    "methods",
    multiple=True,
    type=click.Choice(METHODS),
    default=METHODS,
    help="`--method forward` leaves the gradients out, which take most of the time. [default: both]",
)
@jobs_option("Ops to export at once.")
def export(
    patterns: tuple[str, ...],
    everything: bool,
    output: Path,
    formats: tuple[str, ...],
    isas: tuple[str, ...],
    methods: tuple[str, ...],
    jobs: int,
) -> None:
    """Export ops of the catalog to bundles. (Your own: `chiasm.export.export` in Python.)

    PATTERNS are names, or shell patterns. Native code is compiled with g++ while the next graph is traced;
    compilations are kept in $CHIASM_CACHE (~/.cache/chiasm) and fetched from there when nothing has changed.

    \b
    Examples:
      chiasm export filters.sobel 'color.*' -o bundles
      chiasm export filters.canny -f onnx --method forward
    """
    chosen = _select(patterns, everything)
    if not chosen:
        raise click.UsageError("name the ops to export, or --all (`chiasm list` shows them)")
    if "forward" not in methods:
        raise click.UsageError("--method vjp: every bundle has its forward method, so name that too")
    export_names(list(chosen), output, formats or FORMATS, isas, methods, jobs)


@main.command()
@click.argument("bundle", type=BundlePath())
@click.option("--json", "as_json", is_flag=True, help="Print the manifest itself.")
def info(bundle: Path, as_json: bool) -> None:
    """Show a bundle's signature, sizes and artifacts.

    No engine is loaded.

    \b
    Examples:
      chiasm info bundles/filters.sobel.chiasm
      chiasm info --json bundles/filters.sobel.chiasm
    """
    manifest = read_manifest(bundle)
    if as_json:
        click.echo(json.dumps(manifest, indent=1))
        return
    console.print(
        f"[bold]{manifest['name']}[/] {manifest['version']}  {_shown(manifest['summary'])}", highlight=False
    )
    if manifest["config"]:
        console.print(
            _shown("config: " + ", ".join(f"{k}={v!r}" for k, v in manifest["config"].items())),
            highlight=False,
        )
    limits = ", ".join(f"{s} {d['min']}..{d['max']}" for s, d in manifest["symbols"].items())
    console.print(f"sizes: {limits}", highlight=False)
    for name, method in manifest["methods"].items():
        table = Table(
            "",
            "name",
            "dtype",
            "shape",
            "description",
            title=_shown(f"method {name}"),
            title_justify="left",
            box=None,
            header_style="dim",
        )
        for kind in ("inputs", "outputs"):
            for t in method[kind]:
                dtype = "|".join(manifest["dtypes"]) if t["dtype"] == "T" else t["dtype"]
                about = ", ".join(x for x in (t["description"], t["layout"], t["color"]) if x)
                table.add_row(
                    kind[:-1], t["name"], dtype, "(" + ", ".join(map(str, t["shape"])) + ")", _shown(about)
                )
        console.print(table)
        for a in method["artifacts"]:
            gpu = f"sm_{a['sm']} " if "sm" in a else ""
            extra = (
                gpu
                + " ".join(str(a[k]) for k in ("isa", "opset", "function") if k in a)
                + (f" needs {a.get('why') or ', '.join(a['needs'])}" if a.get("needs") else "")
            )
            console.print(
                f"  {a['backend']:7} {a['file']:36} {a['size'] / 1024:8.1f} KiB  {_shown(extra)}",
                highlight=False,
                soft_wrap=True,
            )


@main.command()
def doctor() -> None:
    """Show what this machine can run.

    Reports its CPU, backends and packages; and for what is missing, why, and how to get it.

    \b
    Example:
      chiasm doctor
    """
    click.echo("\n".join(report()))


@main.command()
@click.argument("name")
@click.argument(
    "bundles", nargs=-1, required=True, type=click.Path(path_type=Path, exists=True, file_okay=False)
)
@click.option(
    "-o",
    "--output",
    type=OutputPath(),
    default=Path("dist"),
    show_default=True,
    help="Folder that gets the wheel.",
)
@click.option("--version", default=__version__, show_default=True, help="The wheel's version.")
def pack(name: str, bundles: tuple[Path, ...], output: Path, version: str) -> None:
    """Write bundles as a Python wheel, chiasm-bundles-NAME.

    Where it is installed, `chiasm.runtime.open` takes an op's name. The same bundles give the same bytes; a
    wheel that is there and holds them is left as it is. $SOURCE_DATE_EPOCH is the time of its files.

    \b
    Example:
      chiasm pack filters bundles/filters.*.chiasm -o dist
    """
    from .pack import pack as write

    wheel, written = write(name, bundles, output, version)
    click.echo(
        f"{'wrote' if written else 'unchanged'} {one_line(wheel)}: {len(bundles)} bundles,"
        f" {wheel.stat().st_size / 1e6:.1f} MB"
    )


@main.command()
@click.argument("key", type=click.Path(path_type=Path, exists=True, dir_okay=False))
@click.argument(
    "bundles", nargs=-1, required=True, type=click.Path(path_type=Path, exists=True, file_okay=False)
)
@click.option(
    "--password-file",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    help="Its first line is the key's password. [default: ask; without a terminal, read a line]",
)
def sign(key: Path, bundles: tuple[Path, ...], password_file: Path | None) -> None:
    """Sign bundles with a minisign secret key.

    KEY is the key's file (`minisign -G` makes one). Each bundle gets a manifest.json.minisig, which covers
    every file of the bundle. `chiasm verify --key` checks it, and so do the runtime and `minisign -V`.

    \b
    Examples:
      chiasm sign my.key bundles/*.chiasm
      chiasm sign my.key bundles/*.chiasm --password-file <(pass show my-key)
    """
    from . import signing

    secret = signing.read_secret_key(key, lambda: password(key, password_file))
    for bundle in bundles:
        signed = one_line(signing.sign(bundle, secret))
        console.print(f"signed {signed}", highlight=False, markup=False, soft_wrap=True)


@main.command()
@click.argument("bundles", nargs=-1, required=True, type=BundlePath())
@click.option(
    "--key",
    help="Check first that this minisign public key (56 characters, or a file) has signed every bundle.",
)
def verify(bundles: tuple[Path, ...], key: str | None) -> None:
    """Replay bundles' golden vectors on every backend.

    Exit status 1 where a value is wrong, a file damaged or a signature missing or wrong. A backend that this
    machine lacks is reported, and is no failure; but if nothing could be run at all, the status is 1 too.

    \b
    Examples:
      chiasm verify bundles/*.chiasm
      chiasm verify --key minisign.pub bundles/filters.sobel.chiasm
    """
    if key is not None:
        from . import signing

        for bundle in bundles:
            comment = "".join(c if c.isprintable() else " " for c in signing.check_signature(bundle, key))
            console.print(
                f"{one_line(bundle)}: signed by the key; {comment}",
                highlight=False,
                markup=False,
                soft_wrap=True,
            )
        # So that only signed code runs below, even if the files change meanwhile
        signing.trust_only(key)
    from .verify import verify as verify_bundle

    table = Table("bundle", "method", "dtype", "backend", "largest error", "", box=None, header_style="bold")
    ran = failed = 0
    said: list[str] = []  # printed as lines of their own: a table's last column is too narrow
    damaged: list[str] = []
    with Progress(
        TextColumn("{task.description:48}"),
        BarColumn(),
        MofNCompleteColumn(),
        console=console,
        transient=True,
    ) as progress:
        for bundle in progress.track(bundles, description="verifying"):
            name = escape(one_line(bundle.resolve().name.removesuffix(SUFFIX)))
            try:
                rows = verify_bundle(bundle)
            except BundleError as error:  # the other bundles are verified all the same
                ran, failed = ran + 1, failed + 1
                damaged.append(one_line(error))
                table.add_row(name, "", "", "", "", "[red]FAIL[/]")
                continue
            for row in rows:
                ran += row.passed is not None
                failed += row.passed is False
                verdict = {True: "[green]pass[/]", False: "[red]FAIL[/]", None: "[yellow]not run[/]"}[
                    row.passed
                ]
                if not row.passed:
                    what = "FAIL" if row.passed is False else "not run"
                    said.append(
                        f"{what}: {one_line(bundle)}: {row.method} {row.dtype} on {row.backend}:"
                        f" {one_line(row.message)}"
                    )
                table.add_row(
                    name,
                    row.method,
                    row.dtype,
                    row.backend,
                    f"{row.error:.2e}" if row.passed is not None else "",
                    verdict,
                )
    console.print(table)
    for line in dict.fromkeys(said):
        click.echo(line)
    for line in damaged:
        click.echo(f"Error: {line}", err=True)
    console.print(f"verify: {ran} checks, {failed} failed", highlight=False)
    if failed or not ran:
        raise SystemExit(1)


@main.command()
@click.argument("bundle", type=BundlePath())
@click.argument("source", type=click.Path(path_type=Path, exists=True, dir_okay=False))
@click.argument("target", type=OutputPath(file_okay=True))
@click.option(
    "-b",
    "--backend",
    metavar="NAME",
    default="auto",
    show_default=True,
    help="Run it on this backend: native, torch, onnx, or another that is installed (see `chiasm doctor`).",
)
@click.option(
    "-s",
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help=(
        "Another input of the op, as JSON: --set 'sigma=[[1.5, 1.5]]'. For an input that only gives a size:"
        " --set like=480x640."
    ),
)
def run(bundle: Path, source: Path, target: Path, backend: str, settings: tuple[str, ...]) -> None:
    """Run a bundle on an image file.

    SOURCE is the file to read, TARGET the image file that gets the result. Files are read as cv2.imread reads
    them: turned as their EXIF entry says, without transparency, 16-bit values as their upper eight bits; an
    op on numbers gets them from 0 to 1, one on 16 bits from 0 to 65535, and both get grey ones with all 16
    bits. Results outside 0 to 1 are stretched to it.

    \b
    Examples:
      chiasm run bundles/filters.sobel.chiasm photo.jpg edges.png
      chiasm run bundles/filters.gaussian_blur2d.chiasm photo.jpg soft.png -s 'sigma=[[1.5, 1.5]]'
      chiasm run bundles/geometry.transform.resize.bilinear.chiasm photo.jpg small.png -s like=480x640
    """
    from .images import run_on_image

    click.echo(one_line(run_on_image(bundle, source, target, backend, pairs("--set", settings))))


main.add_command(map_command)
main.add_command(triton)


def _shown(text: str) -> str:
    """Untrusted text from a bundle, made safe for a line of the terminal."""
    return escape(one_line(text))


def _select(patterns: tuple[str, ...], everything: bool) -> dict[str, Entry]:
    from .catalog import catalog

    entries = catalog()
    if not patterns and not everything:
        return {}
    return {name: entries[name] for name in _matching(patterns, entries, "op", "chiasm list")}


def _matching(patterns: tuple[str, ...], names: Collection[str], what: str, command: str) -> list[str]:
    """The names that match one of the patterns, all without a pattern; each pattern must match one."""
    for pattern in patterns:
        if not any(fnmatch(name, pattern) for name in names):
            raise click.UsageError(f"no {what} matches {pattern!r} (`{command}` shows them)")
    return [name for name in names if not patterns or any(fnmatch(name, p) for p in patterns)]
