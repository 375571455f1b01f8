"""Kornia and kornia-rs as contenders, from .deps/kornia (tools/kornia.sh puts them there)."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from bench.images.ops import Agreement
from bench.machine import ROOT

from .ways import Images, Ready, Setup, Way


def module(name: str) -> Any:
    """kornia or kornia_rs, or a module of theirs; ImportError if it is not installed."""
    folder = str(ROOT / ".deps" / "kornia")
    if folder not in sys.path:
        sys.path.append(folder)
    return importlib.import_module(name)


def ways(
    function: Callable[[Any, Setup, Any], Any],
    inputs: Callable[[Images], np.ndarray],
    planes: Callable[[np.ndarray], np.ndarray],
    agrees: Agreement,
) -> dict[str, Way]:
    """`function(kornia, setup, images)` on a batch as a tensor, eager and compiled."""

    @cache
    def compiled(setup: Setup) -> Callable:
        import torch

        kornia = module("kornia")
        # Compiled once for batches of all sizes
        return torch.compile(lambda x: function(kornia, setup, x), dynamic=True)

    def way(compile: bool) -> Way:
        def make(images: Images, setup: Setup) -> Ready:
            import torch

            torch.set_num_threads(setup.threads)
            kornia, tensor = module("kornia"), torch.from_numpy(inputs(images))
            chosen = compiled(setup) if compile else lambda x: function(kornia, setup, x)

            def call() -> torch.Tensor:
                with torch.inference_mode():
                    return chosen(tensor)

            return Ready(call, lambda result: planes(result.numpy()))

        return Way(make, agrees)

    return {"Kornia": way(compile=False), "Kornia, torch.compile": way(compile=True)}
