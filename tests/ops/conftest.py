"""Make the working tree importable, and keep torch to one thread: the images are small.

If a test and its subject have not changed since the base, only every fifth such test runs; `make test-all`
runs all. A test that is generated for each entry of the catalog counts as changed if the source of the
entry's op has changed. `make test-quick` runs fewer tests of both kinds.
"""

import os
import sys
from pathlib import Path

import pytest
import torch

from tests.changes import ROOT, changed_files, has_changed, is_drawn, leave_out, source_of

for folder in (Path(__file__).parents[2] / "python", Path(__file__).parent):
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))

from chiasm.export.catalog import Entry  # noqa: E402

torch.set_num_threads(1)

QUICK = "CHIASM_QUICK" in os.environ
#: One of so many unchanged tests runs.
DRAWN = 20 if QUICK else 5
#: Of more changed tests than this, a part runs: a primitive's change is one of thousands of them.
MOST_CHANGED = 2500 if QUICK else sys.maxsize


def _has_changed(item: pytest.Item) -> bool:
    entry = item.callspec.params.get("entry") if hasattr(item, "callspec") else None
    if not isinstance(entry, Entry):
        return has_changed(item.path)
    return not changed_files().isdisjoint((str(item.path.relative_to(ROOT)), source_of(entry.function())))


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    folder = Path(__file__).parent
    changed = {item for item in items if folder in item.path.parents and _has_changed(item)}
    part = -(-len(changed) // MOST_CHANGED)
    leave_out(
        config,
        items,
        folder,
        lambda item: is_drawn(item.nodeid, item.path, part if item in changed else DRAWN),
    )
