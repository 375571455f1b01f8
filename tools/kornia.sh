#!/usr/bin/env bash
# Install Kornia for `make bench WHAT=images`, and for that alone, in .deps/kornia: without dependencies, so that it runs on the
# project's torch; `bench/images` puts the folder on its path.
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
