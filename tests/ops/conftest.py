"""Make the working tree importable, and keep torch to one thread: the images are small.

Of tests of what has not changed since the base every third is run; `make test-all` runs all.
"""

import os
import sys
from pathlib import Path

import pytest
import torch

from tests.changes import has_changed, is_drawn

for folder in (Path(__file__).parents[2] / "python", Path(__file__).parent):
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))

torch.set_num_threads(1)

#: Of so many tests of what has not changed one is run.
DRAWN = 3


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    asked_for = any("::" in argument for argument in config.args) or config.option.keyword
    if os.environ.get("CHIASM_ALL_TESTS") or asked_for:
        return
    left_out = [i for i in items if not has_changed(i.path) and not is_drawn(i.nodeid, i.path, DRAWN)]
    if left_out:
        items[:] = [item for item in items if item not in set(left_out)]
        config.hook.pytest_deselected(items=left_out)
