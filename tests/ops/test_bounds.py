"""The cost of an op is bounded for all values: images of 100 or -1e6 do not prolong a loop or enlarge a
tensor."""

import pytest
import torch
from test_catalog import SMALL, arguments, module
from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves

from chiasm.export.catalog import Entry, catalog

#: Limits on calls of PyTorch's operators and on the bytes of their results: the factor over a normal call,
#: and an allowance for small calls. A loop until nothing changes may take as many steps as an image has rows
#: and columns.
TIMES, MORE_CALLS, MORE_BYTES = 4, 4000, 16 << 20


class Budget(TorchDispatchMode):
    """Counts calls of operators and the bytes of their results, and raises if they exceed the limits: so an
    endless loop fails without a clock."""

    def __init__(self, calls: float = float("inf"), size: float = float("inf")) -> None:
        super().__init__()
        self.calls, self.size, self.limits = 0, 0, (calls, size)

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):
        result = func(*args, **(kwargs or {}))
        self.calls += 1
        self.size += sum(t.numel() * t.element_size() for t in tree_leaves(result) if isinstance(t, Tensor))
        if self.calls > self.limits[0] or self.size > self.limits[1]:
            raise AssertionError(f"{self.calls} calls, {self.size} bytes: more than {self.limits}")
        return result


def beyond(inputs: list[Tensor], kind: str) -> list[Tensor]:
    """The inputs with other floating-point values than their nominal ones."""
    generator = torch.Generator().manual_seed(1)
    far = []
    for t in inputs:
        noise = torch.randn(t.shape, generator=generator, dtype=torch.float64).to(t.dtype)
        if not t.is_floating_point():
            far.append(t)
        elif kind == "noise":
            far.append(noise)
        else:
            far.append(t * float(kind))
    return far


ENTRIES = catalog()


@pytest.mark.parametrize("kind", ["noise", "100", "-1e6"])
@pytest.mark.parametrize("entry", ENTRIES.values(), ids=ENTRIES)
def test_the_cost_of_values_far_outside(entry: Entry, kind: str) -> None:
    op, inputs = module(entry), arguments(entry, SMALL, "float32")
    with Budget() as normal:
        op(*inputs)
    far = beyond(inputs, kind)
    with Budget(TIMES * normal.calls + MORE_CALLS, TIMES * normal.size + MORE_BYTES):
        op(*far)


@pytest.mark.parametrize("vertices", [3, 300])
def test_the_memory_of_a_polygon_is_that_of_its_rows(vertices: int) -> None:
    from chiasm.image import draw_convex_polygon

    angle = torch.linspace(0.0, 6.28, vertices)
    polygon = torch.stack([torch.cos(angle), torch.sin(angle)], 1)[None] * 240.0 + 250.0
    with Budget(size=70.0 * 500 * (500 + 8 * vertices)):
        draw_convex_polygon(torch.zeros(1, 1, 500, 500), polygon, torch.ones(1))
