#!/usr/bin/env bash
# clang-tidy (.clang-tidy) over the runtime's sources, with the compile commands of build/release.
# usage: tools/tidy.sh
# Sources that have changed since the base are checked, and every third of the others; all with
# CHIASM_ALL_TESTS. build/tidy records clean sources: a source is checked again when it, a header or the
# checks have changed.
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p build/tidy
headers=$(find .clang-tidy runtime include \( -name .clang-tidy -o -name '*.h' -o -name '*.hpp' \) -print0 | sort -z | xargs -0 sha256sum | sha256sum | cut -d' ' -f1)
folders=(runtime/{base,core,backends,ort,python})
# Not built without its headers
! grep -q /runtime/triton/ build/release/compile_commands.json || folders+=(runtime/triton)
pending=()
while IFS= read -r source; do
  key=build/tidy/$(sha256sum <<<"$source $headers $(sha256sum <"$source")" | cut -d' ' -f1)
  [ -e "$key" ] || pending+=("$source" "$key")
done < <(find "${folders[@]}" -name '*.cpp' | .venv/bin/python tests/changes.py 3)
[ ${#pending[@]} -gt 0 ] || exit 0
printf '%s\n' "${pending[@]}" | xargs -P "$(nproc)" -n 2 bash -c '
  output=$(clang-tidy -p build/release --quiet "$0" 2>&1) && touch "$1" && exit 0
  grep -v "warnings\? generated\|^Suppressed\|^Use -" <<<"$output"
  exit 1'
