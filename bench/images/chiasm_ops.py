"""The bundles of the list, opened with the native backend."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import NamedTuple

import numpy as np

import chiasm.runtime

from ..machine import bundle_path
from ..wheel import room
from .data import inputs
from .ops import OPS, Op


class Native(NamedTuple):
    """An op with its inputs at one size, and a call into `outputs`."""

    folder: Path
    inputs: dict[str, np.ndarray]
    outputs: list[np.ndarray]
    call: Callable[[], object]


def measured(names: Collection[str] = ()) -> list[Op]:
    """The ops of the list, or only `names`, whose bundles have native code without libtorch."""
    return [op for op in OPS if (not names or op.bundle in names) and _has_native(op)]


def _has_native(op: Op) -> bool:
    artifacts = chiasm.runtime.open(bundle_path(op.bundle)).info["methods"]["forward"]["artifacts"]
    return any(a["backend"] == "native" for a in artifacts)


def native(op: Op, size: tuple[int, int, int]) -> Native:
    folder = bundle_path(op.bundle)
    opened = chiasm.runtime.open(folder)
    method = opened.method("forward", backend="native")
    given = inputs(op, opened.info["methods"]["forward"], size)
    arguments = list(given.values())
    outputs = room(method, arguments)
    method.run_into(arguments, outputs)
    return Native(folder, given, outputs, lambda: method.run_into(arguments, outputs))
