#!/usr/bin/env bash
# Make the environments that tests/parity/other_runtimes.py runs bundles in: .deps/ort-1.17 and .deps/openvino.
# They are apart from .venv because the old ONNX Runtime needs NumPy 1, and hold no torch and no chiasm: what a product has.
# usage: tools/other_runtimes.sh        Safe to run again, quick when nothing has changed.
set -euo pipefail
cd "$(dirname "$0")/.."

for name in ort-1.17 openvino; do
  tools/environment.sh $name tools/other_runtimes/$name.txt
done
