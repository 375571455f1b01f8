#!/usr/bin/env bash
# Builds Conan's package from this source tree, and a program that uses it.
# usage: tests/consumer/conan.sh [BUNDLE]
set -euo pipefail
bundle=${1:+$(realpath "$1")}
cd "$(dirname "$0")/../.."
tools/environment.sh conan tools/conan.txt
export CONAN_HOME=$PWD/build/conan/home CHIASM_CONSUMER_BUNDLE=$bundle
conan=.deps/conan/bin/conan
[ -e "$CONAN_HOME/profiles/default" ] || "$conan" profile detect >/dev/null 2>&1
# Without servers: the package has no dependencies.
"$conan" create packaging/conan --no-remote -s build_type=Release -s compiler.cppstd=17 >build/conan/log 2>&1 || { tail -n 40 build/conan/log && exit 1; }
grep -A 20 'Testing the package: Executing test' build/conan/log | grep -v '^$'
package=$("$conan" list 'chiasm/*:*' --format=json 2>/dev/null | .venv/bin/python -c '
import json, sys
[reference] = json.load(sys.stdin)["Local Cache"].items()
[revision] = reference[1]["revisions"].values()
[package] = revision["packages"]
print(f"{reference[0]}:{package}")')
tests/consumer/run_paths.sh "$PWD" "$("$conan" cache path "$package")"
echo "conan: passed"
