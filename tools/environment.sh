#!/usr/bin/env bash
# Make a separate environment, with packages that are pinned by hash.
# usage: [ABOUT=TEXT] tools/environment.sh NAME LOCKED        makes .deps/NAME; ABOUT is shown meanwhile
# Safe to run again, quick when nothing has changed.
set -euo pipefail
cd "$(dirname "$0")/.."
PYTHON=${PYTHON:-.venv/bin/python}

folder=.deps/$1 locked=$2
want=$(sha256sum "$locked" | cut -d' ' -f1)
[ "$(cat "$folder/.requirements" 2>/dev/null)" = "$want" ] && exit 0
echo "making $folder${ABOUT:+ ($ABOUT)}"
rm -rf "$folder"
"$PYTHON" -m venv "$folder"
.venv/bin/uv pip install --quiet --compile-bytecode --python "$folder/bin/python" --require-hashes \
  -r "$locked"
echo "$want" > "$folder/.requirements"
