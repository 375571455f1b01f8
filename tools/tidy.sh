#!/usr/bin/env bash
# clang-tidy (.clang-tidy) over the runtime's sources, with the compile commands of build/release.
# usage: tools/tidy.sh
# Sources that have changed since the base are checked, and every third of the others, of those of artifacts
# every tenth; all with CHIASM_ALL_TESTS. build/tidy records clean sources: a source is checked again when it,
# its flags, a header, the checks or clang-tidy have changed.
set -euo pipefail
cd "$(dirname "$0")/.."
mkdir -p build/tidy
headers=$(find .clang-tidy runtime include \( -name .clang-tidy -o -name '*.h' -o -name '*.hpp' \) -print0 | sort -z | xargs -0 sha256sum | sha256sum | cut -d' ' -f1)
version=$(clang-tidy --version | grep -i version)
# One command for each source: those of artifacts have one for each instruction set, the default's first.
.venv/bin/python - >build/tidy/sources <<'END'
import json
from pathlib import Path

made = json.loads(Path("build/release/compile_commands.json").read_text())
runtime = f"{Path.cwd()}/runtime/"
commands = {c["file"]: c for c in reversed(made) if c["file"].startswith(runtime)}
Path("build/tidy/compile_commands.json").write_text(json.dumps(list(commands.values())))
# For the keys: without this tree's path
lines = [f"{file} {made['command']}".replace(f"{Path.cwd()}/", "") for file, made in commands.items()]
Path("build/tidy/commands").write_text("\n".join([*lines, ""]))
print("\n".join(sorted(file.replace(runtime, "runtime/") for file in commands)))
END
# g++'s omp.h, which clang reads without the arguments of an attribute
ln -sf "$(g++ -print-file-name=include/omp.h)" build/tidy/omp.h
chosen() { .venv/bin/python tests/changes.py "$1"; }
# Not by a process substitution, whose failure would leave nothing to check.
{ grep -v ^runtime/artifact/ build/tidy/sources | chosen 3; grep ^runtime/artifact/ build/tidy/sources | chosen 10; } >build/tidy/chosen
pending=()
while IFS= read -r source; do
  command=$(awk -v source="$source" '$1 == source' build/tidy/commands)
  key=build/tidy/$(sha256sum <<<"$command $version $headers $(sha256sum <"$source")" | cut -d' ' -f1)
  [ -e "$key" ] || pending+=("$source" "$key")
done <build/tidy/chosen
[ ${#pending[@]} -gt 0 ] || exit 0
printf '%s\n' "${pending[@]}" | xargs -P "$(nproc)" -n 2 bash -c '
  openmp=(--extra-arg=-isystem"$PWD/build/tidy" "--extra-arg=-D__malloc__(...)=")
  output=$(clang-tidy -p build/tidy --quiet "${openmp[@]}" "$0" 2>&1) && touch "$1" && exit 0
  grep -v "warnings\? generated\|^Suppressed\|^Use -" <<<"$output"
  exit 1'
