#!/bin/sh
# Fuzz each reader for a while: tests/fuzz/run.sh [SECONDS each, default 20]. Fails on the first crash.
set -eu
seconds="${1:-20}"
root="$(cd "$(dirname "$0")/../.." && pwd)"
cd "$root"
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz -j 2 >/dev/null
for name in manifest safetensors expression; do
  found="build/fuzz/corpus/$name"  # what earlier runs found is kept there
  mkdir -p "$found"
  build/fuzz/bin/fuzz_$name -max_total_time="$seconds" -max_len=16384 -timeout=5 -rss_limit_mb=1024 -print_final_stats=1 \
    -verbosity=0 -artifact_prefix="build/fuzz/crash-$name-" "$found" "tests/fuzz/corpus/$name"
done
