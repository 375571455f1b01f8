"""`chiasm triton`: a model repository from the command line."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from ..export.command import OutputPath
from ..export.text import one_line


@click.command("triton")
@click.argument("repository", type=OutputPath())
@click.argument("parts", nargs=-1, required=True, metavar="[NAME=]BUNDLE...")
@click.option(
    "--ensemble",
    metavar="NAME",
    help="Write a model NAME too that runs all parts in their order, each on the outputs of the one before.",
)
def triton(repository: Path, parts: tuple[str, ...], ensemble: str | None) -> None:
    """Write bundles into a model repository of Triton Inference Server.

    Each bundle becomes a model of its own name, or of NAME. A part that is a *.onnx file is a network, which
    ONNX Runtime runs in Triton's Python backend. A model that is there already is never changed.
    docs/triton.md shows how the server is started.

    \b
    Examples:
      chiasm triton models edges=bundles/pipelines.edges.chiasm
      chiasm triton models --ensemble classify prepare=bundles/pipelines.preprocess.chiasm network.onnx
    """
    from . import Part, write

    for folder in write(repository, [Part.parse(part) for part in parts], ensemble):
        click.echo(f"wrote {one_line(folder)}")
    click.echo(
        f"Next: tritonserver --model-repository={one_line(shlex.quote(str(repository)))}"
        " --backend-directory=FOLDER, the one that has chiasm/libtriton_chiasm.so (docs/triton.md)"
    )
