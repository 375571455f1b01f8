#!/usr/bin/env bash
# Fuzz all inputs of the core: tests/fuzz/run.sh [SECONDS each, default 20]. Two fuzzers at a time. Each
# prints a line of progress every minute and at its end. Fails if one finds a problem, which is then in
# build/fuzz/crash-*.
set -euo pipefail
seconds="${1:-20}"
cd "$(dirname "$0")/../.."
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz -j 2 >build/fuzz/build.log || { cat build/fuzz/build.log; exit 1; }

dashboard() {  # NAME
  local last crashes
  last=$(grep -aE '^#[0-9]+.* cov: ' "build/fuzz/log/$1" | tail -n 1 || true)
  crashes=$(find build/fuzz -maxdepth 1 -name "crash-$1-*" ! -name "*-slow-unit-*" | wc -l)
  awk -v name="$1" -v crashes="$crashes" '{
    for (i = 1; i < NF; ++i) { if ($i == "cov:") cov = $(i + 1); if ($i == "corp:") corpus = $(i + 1) }
    printf "fuzz %-12s %10d executions  coverage %6s  corpus %12s  crashes %d\n", name, substr($1, 2), cov, corpus, crashes }' <<<"$last"
}

one() {  # NAME SECONDS
  local found="build/fuzz/corpus/$1"  # inputs of earlier runs are kept there
  mkdir -p "$found" build/fuzz/log
  # Small inputs give short programs of calls and short lists of changes, which are sufficient and run more
  # often.
  local longest=16384
  case "$1" in calls | bundle) longest=1024 ;; esac
  ASAN_OPTIONS=allocator_may_return_null=1:max_allocation_size_mb=512 "build/fuzz/bin/fuzz_$1" \
    -max_total_time="$2" -max_len="$longest" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
    -artifact_prefix="build/fuzz/crash-$1-" "$found" "tests/fuzz/corpus/$1" >"build/fuzz/log/$1" 2>&1 &
  local fuzzer=$! waited=0 status=0
  while kill -0 "$fuzzer" 2>/dev/null; do
    sleep 1
    waited=$((waited + 1))
    if ((waited % 60 == 0)); then dashboard "$1"; fi
  done
  wait "$fuzzer" || status=$?
  dashboard "$1"
  if [ "$status" != 0 ]; then tail -n 40 "build/fuzz/log/$1"; fi
  return "$status"
}
export -f dashboard one

printf '%s\n' manifest safetensors expression signature onnx archive bundle calls |
  xargs -P 2 -I '{}' bash -c "one '{}' $seconds"
