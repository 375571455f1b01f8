# PyTorch's context is private, and has no types.
# pyright: reportPrivateUsage=false, reportUnknownVariableType=false
"""Recurrent layers of sequences whose length is a symbol."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from typing import Any

import torch
from torch import Tensor
from torch.export._patches import _register_rnn_while_loop_decomposition

aten = torch.ops.aten


@contextmanager
def layers_of_any_length() -> Generator[None]:
    """torch.export keeps LSTM and GRU layers in its graph as operators, but finds their results' shapes by
    taking as many steps as the example has. Here the shapes follow from the arguments'."""
    try:
        with (
            _register_rnn_while_loop_decomposition(aten.lstm.input, _lstm),
            _register_rnn_while_loop_decomposition(aten.gru.input, _gru),
        ):
            _forget()
            yield
    finally:
        _forget()


def _forget() -> None:
    """Torch keeps the forms of operators that it has looked up. Later traces would get the tensors without
    values, as layers' results."""
    for layer in (aten.lstm.input, aten.gru.input):
        layer._dispatch_cache.clear()


def _lstm(input: Tensor, hx: list[Tensor], *settings: Any) -> tuple[Tensor, Tensor, Tensor]:
    """Tensors like the results, without values."""
    return *_gru(input, hx[0], *settings), torch.empty_like(hx[1])


def _gru(input: Tensor, hx: Tensor, *settings: Any) -> tuple[Tensor, Tensor]:
    bidirectional = settings[-2]
    units = hx.shape[2] * (2 if bidirectional else 1)
    return input.new_empty(*input.shape[:2], units), torch.empty_like(hx)
