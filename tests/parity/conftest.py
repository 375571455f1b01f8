"""Fixtures that tests of the runtime share: see scale_bundle.py.

If a file of tests and what it tests have not changed since the base, only every sixth such file runs; `make
test-all` runs all.
"""

from pathlib import Path

import pytest
from scale_bundle import BACKENDS, write_scale

import chiasm.runtime as runtime
from tests.changes import leave_out
from tests.stages import runs


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    leave_out(config, items, Path(__file__).parent, runs)


@pytest.fixture(scope="module")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> runtime.Bundle:
    return runtime.open(write_scale(tmp_path_factory.mktemp("bundles")))


@pytest.fixture(params=BACKENDS)
def method(request: pytest.FixtureRequest, bundle: runtime.Bundle) -> runtime.Method:
    return bundle.method(backend=request.param)
