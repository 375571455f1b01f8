#!/usr/bin/env bash
# Make the environments in which tests/parity/other_runtimes.py runs bundles: .deps/ort-1.17 and
# .deps/openvino. They are separate from .venv because the old ONNX Runtime needs NumPy 1. Like a product,
# they have no torch and no chiasm.
# usage: tools/other_runtimes.sh        Safe to run again, quick when nothing has changed.
set -euo pipefail
cd "$(dirname "$0")/.."

for name in ort-1.17 openvino; do
  tools/environment.sh $name tools/other_runtimes/$name.txt
done
