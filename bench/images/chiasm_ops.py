"""Bundles of the list, opened natively."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

import chiasm.runtime

from ..machine import bundle_path
from ..wheel import room
from .data import inputs
from .ops import Op


class Native(NamedTuple):
    """An op with its inputs at one size, and a call into `outputs`."""

    folder: Path
    inputs: dict[str, np.ndarray]
    outputs: list[np.ndarray]
    call: Callable[[], object]


def native(op: Op, size: tuple[int, int, int]) -> Native:
    folder = bundle_path(op.bundle)
    opened = chiasm.runtime.open(folder)
    method = opened.method("forward", backend="native")
    given = inputs(op, opened.info["methods"]["forward"], size)
    arguments = list(given.values())
    outputs = room(method, arguments)
    method.run_into(arguments, outputs)
    return Native(folder, given, outputs, lambda: method.run_into(arguments, outputs))
