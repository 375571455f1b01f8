#!/usr/bin/env bash
# Make the environments that tests/parity/other_runtimes.py runs bundles in: .deps/ort-1.17 and .deps/openvino.
# They are apart from .venv because the old ONNX Runtime needs NumPy 1, and hold no torch and no chiasm: what a product has.
# usage: tools/other_runtimes.sh        Safe to run again, quick when nothing has changed.
set -euo pipefail
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-.venv/bin/python}

for name in ort-1.17 openvino; do
  locked=tools/other_runtimes/$name.txt folder=.deps/$name
  want=$(sha256sum "$locked" | cut -d' ' -f1)
  [ "$(cat "$folder/.requirements" 2>/dev/null)" = "$want" ] && continue
  echo "making $folder"
  rm -rf "$folder"
  "$PYTHON" -m venv "$folder"
  "$folder/bin/python" -m pip install --quiet --disable-pip-version-check --require-hashes -r "$locked"
  echo "$want" > "$folder/.requirements"
done
