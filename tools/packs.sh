#!/usr/bin/env bash
# Write the exported bundles in FOLDER as wheels, one per family: chiasm-bundles-filters and so on. An
# existing wheel with the same content is kept, so that an interrupted run can be resumed.
# usage: [DIST=FOLDER] tools/packs.sh FOLDER
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$1
export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || echo 1750000000)}
families=$(find "$folder" -maxdepth 1 -name '*.chiasm' -printf '%f\n' | cut -d. -f1 | sort -u)
[ -n "$families" ] || { echo "packs.sh: $folder: expected a folder of bundles, found none in it" >&2 && exit 1; }
for family in $families; do
  PYTHONPATH=python .venv/bin/python -m chiasm.export pack "$family" "$folder/$family".*.chiasm -o "${DIST:-dist}"
done
