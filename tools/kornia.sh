#!/usr/bin/env bash
# Install Kornia in .deps/kornia, for benchmarks and tests that compare with it: without dependencies, so that
# it uses the project's torch. They add the folder to their path.
# usage: tools/kornia.sh        Safe to run again, quick when nothing has changed.
set -euo pipefail
cd "$(dirname "$0")/.."

locked=tools/kornia.txt folder=.deps/kornia
want=$(sha256sum "$locked" | cut -d' ' -f1)
[ "$(cat "$folder/.requirements" 2>/dev/null)" = "$want" ] && exit 0
echo "making $folder"
rm -rf "$folder"
.venv/bin/uv pip install --quiet --python .venv/bin/python --no-deps --require-hashes --target "$folder" -r "$locked"
echo "$want" > "$folder/.requirements"
