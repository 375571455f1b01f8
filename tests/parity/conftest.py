"""Fixtures that tests of the runtime share: see scale_bundle.py."""

import pytest
from scale_bundle import BACKENDS, write_scale

import chiasm.runtime as runtime


@pytest.fixture(scope="module")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> runtime.Bundle:
    return runtime.open(write_scale(tmp_path_factory.mktemp("bundles")))


@pytest.fixture(params=BACKENDS)
def method(request: pytest.FixtureRequest, bundle: runtime.Bundle) -> runtime.Method:
    return bundle.method(backend=request.param)
