"""The TorchScript exporter: by script, never by trace, so that every branch of the op is in the file."""

from __future__ import annotations

import io

import torch
from torch import nn

from .errors import explain


def to_torchscript(module: nn.Module, name: str) -> bytes:
    """The bytes of a `.pt`."""
    try:
        scripted = torch.jit.script(module)
    except Exception as error:
        raise explain(name, "TorchScript", error) from error
    buffer = io.BytesIO()
    torch.jit.save(scripted, buffer)
    return buffer.getvalue()
