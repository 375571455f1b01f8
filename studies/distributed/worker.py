"""One of the processes, which torchrun starts on this machine or on several:

    torchrun --standalone --nproc-per-node 2 -m studies.distributed.worker FOLDER

The first reads FOLDER/settings.json, sends settings, op and photographs to all, and writes the results to
FOLDER/result.pt.
"""

from __future__ import annotations

import io
import json
import socket
import time
from pathlib import Path
from typing import Any

import click
import torch
import torch.distributed as dist
from rich.progress import Progress
from torch import Tensor, nn
from torch.nn.parallel import DistributedDataParallel

from chiasm.geometry.registration import Homography

from .settings import Settings
from .work import batch, learn, pipeline


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
def main(folder: Path) -> None:
    """Work as one of the processes of torchrun."""
    dist.init_process_group("gloo")
    try:
        first = dist.get_rank() == 0
        settings = Settings(**sent(json.loads((folder / "settings.json").read_text()) if first else None))
        results = [None] * dist.get_world_size() if first else None
        dist.gather_object(work(settings), results)
        if first:
            torch.save(results, folder / "result.pt")
    finally:
        dist.destroy_process_group()


def work(settings: Settings) -> dict[str, Any]:
    """The results of a process: the edges of its photographs, the learned homography, the host and the
    times."""
    op = loaded(sent(scripted(pipeline()) if dist.get_rank() == 0 else None))
    photographs, total = shard(batch(settings) if dist.get_rank() == 0 else None)
    started = time.monotonic()
    with torch.no_grad():
        edges = op(photographs)
    sharded = time.monotonic()
    model = DistributedDataParallel(Homography().double())
    with Progress(disable=dist.get_rank() > 0) as progress:
        task = progress.add_task("learning by all processes", total=settings.levels * settings.steps)
        learn(
            model,
            photographs.double(),
            dist.get_world_size() * len(photographs) / total,
            settings,
            lambda: progress.advance(task),
        )
    learnt = time.monotonic()
    return {
        "host": socket.gethostname(),
        "edges": edges,
        "homography": model.module().detach(),
        "pipeline_seconds": sharded - started,
        "learning_seconds": learnt - sharded,
    }


def scripted(op: nn.Module) -> bytes:
    """The op as TorchScript: the receiver does not need its source."""
    file = io.BytesIO()
    torch.jit.save(torch.jit.script(op), file)
    return file.getvalue()


def loaded(op: bytes) -> nn.Module:
    return torch.jit.load(io.BytesIO(op))


def sent(thing: Any) -> Any:
    """The first process's object, in all processes."""
    box = [thing]
    dist.broadcast_object_list(box, 0)
    return box[0]


def shard(photographs: Tensor | None) -> tuple[Tensor, int]:
    """This process's part of the first process's batch, and the number of photographs in the batch."""
    parts: list[Tensor] | None = None
    if photographs is not None:
        if len(photographs) < dist.get_world_size():
            raise ValueError(
                f"{len(photographs)} photographs cannot be shared by {dist.get_world_size()} processes: each"
                " takes at least one"
            )
        parts = list(photographs.tensor_split(dist.get_world_size()))
    mine: list[Tensor | None] = [None]
    dist.scatter_object_list(mine, parts, 0)
    return mine[0], sent(len(photographs) if photographs is not None else None)


if __name__ == "__main__":
    main()
