#!/usr/bin/env bash
# `pip install .` gives `import chiasm`, the runtime with its backends, and the command; nothing of the source tree is used.
set -euo pipefail
cd "$(dirname "$0")/../.."
root=$PWD
site=$root/build/pip-site
rm -rf "$site"
.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --target "$site" .
tests/consumer/run_paths.sh "$root" "$site"
cd / # so that nothing is imported from the current folder
export PYTHONPATH=$site
"$root/.venv/bin/python" - <<'PY'
import os, pathlib
import numpy as np
import chiasm, chiasm.export, chiasm.onnx, chiasm.runtime
site = pathlib.Path(os.environ["PYTHONPATH"])
for module in (chiasm, chiasm.export, chiasm.onnx, chiasm.runtime):
    assert pathlib.Path(module.__file__).is_relative_to(site), module.__file__
problems = {b.name: b.problem for b in chiasm.runtime.backends() if not b.available}
assert not problems, problems
assert chiasm.onnx.library().is_relative_to(site), chiasm.onnx.library()
PY
"$root/.venv/bin/python" "$site/bin/chiasm" export filters.sobel -o "$root/build/pip-bundles"
"$root/.venv/bin/python" "$site/bin/chiasm" verify "$root/build/pip-bundles/filters.sobel.chiasm"
"$root/.venv/bin/python" -W error -c "import chiasm.onnx; chiasm.onnx.session('$root/build/pip-bundles/filters.sobel.chiasm')"
echo "pip install: passed"
