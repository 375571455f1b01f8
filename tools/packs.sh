#!/usr/bin/env bash
# Write the exported bundles in FOLDER as wheels, one a family: chiasm-bundles-filters and so on. A wheel that is there and holds
# the same is left as it is, so that a run that was ended goes on.
# usage: [DIST=FOLDER] tools/packs.sh FOLDER
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$1
export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || echo 1750000000)}
for family in $(find "$folder" -maxdepth 1 -name '*.chiasm' -printf '%f\n' | cut -d. -f1 | sort -u); do
  PYTHONPATH=python .venv/bin/python -m chiasm.export pack "$family" "$folder/$family".*.chiasm -o "${DIST:-dist}"
done
