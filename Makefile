# chiasm: everything is reached from here. `make` alone lists the targets.
.DEFAULT_GOAL := help
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.ONESHELL:
MAKEFLAGS += --no-print-directory

JOBS ?= $(shell nproc)
PY := .venv/bin/python
BUNDLES := build/bundles
MUTANTS ?= 20000
FIRST ?= 0
MINUTES ?= 60
# The inputs of an export: the exporter and the ops, not what reads bundles.
SOURCES := $(shell find python/chiasm runtime/artifact \
  \( -path python/chiasm/artifact -o -path python/chiasm/data -o -path python/chiasm/onnx -o -path python/chiasm/runtime -o -path python/chiasm/triton -o -name __pycache__ -o -name verify.py -o -name comparison.py -o -name pack.py -o -name packs.py -o -name doctor.py -o -name extras.py -o -name __main__.py -o -name cli.py -o -name workers.py -o -name images.py \) -prune \
  -o \( -name '*.py' -o -name '*.cpp' -o -name '*.h' -o -name '*.json' -o -name regex \) -print)

# Of the past, and damaged on purpose, are not laid out.
CPP := $(shell find bench examples gallery include runtime studies tests \( -path tests/frozen -o -path tests/fuzz/corpus \) -prune \
  -o \( -name '*.c' -o -name '*.h' -o -name '*.cpp' -o -name '*.hpp' \) -print)

PROSE := $(shell find . \( -path ./.git -o -path ./.deps -o -path ./.venv -o -path ./build -o -path ./dist -o -path ./tests/frozen/version_1 \) \
  -prune -o -name '*.md' -print)

.PHONY: help setup build bundles test-bundles demo gallery study \
  test test-all test-quick test-ops test-export test-runtime test-kernels test-robustness build-x86-64-v4 build-aarch64 test-aarch64 test-parity test-browser test-serving test-data \
  test-studies test-sanitizers test-fuzz fuzz test-install fresh-root wheels dist sanitize-artifacts attack soak test-special-values special-values parity coverage docs site linalg-accuracy other-runtimes bench lint format stubs lock clean

help: ## list the targets
	@grep -hE '^[a-z0-9-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 24

setup: ## install the dependencies: Debian packages, .venv, ONNX Runtime's headers
	@tools/setup.sh

build: setup ## configure and build the C++ runtime, its Python module and its tests
	@cmake --preset release > /dev/null
	cmake --build --preset release -j $(JOBS)

bundles: $(BUNDLES)/.exported ## export the whole catalog to build/bundles

$(BUNDLES)/.exported: $(SOURCES) | build
	$(PY) -m chiasm.export export --all -o $(BUNDLES) -j $(JOBS)
	touch $@

# What tests run on: a part of the catalog, or all of `make bundles`, where it is there.
test-bundles: $(BUNDLES)/.tested

$(BUNDLES)/.tested: $(SOURCES) | build
	@whole=$(BUNDLES)/.exported
	if [ ! -e $$whole ] || [ -n "$$(find $(SOURCES) -newer $$whole -print -quit)" ]; then $(PY) tests/parity/selection.py $(BUNDLES); fi
	touch $@

demo: setup ## export a part of the catalog, run it in C++ on photographs, show pictures
	@cmake --preset release > /dev/null
	cmake --build --preset release -j $(JOBS) --target artifact chiasm chiasm_native chiasm_onnx chiasm_torch _runtime demo_runner
	$(PY) -m chiasm.export export $$($(PY) -m gallery.demo --list) --method forward -o build/demo/bundles -j $(JOBS)
	$(PY) -m gallery.demo

# WHAT=batch, registration, depth, attack, distributed or training
study: build ## WHAT=batch, registration, ...: a use case at full size -> docs/use_cases.md
	@case "$(WHAT)" in batch | training) tools/kornia.sh ;; esac
	$(PY) -m studies.$(or $(WHAT),$(error make study WHAT=batch|registration|depth|attack|distributed|training))

gallery: build bundles ## run every bundle from C++ on a photograph -> docs/gallery
	$(PY) -m gallery.pages

test: build ## all tests of changed parts, and a sample of the others (tests/stages.py)
	@targets=$$($(PY) tests/stages.py)
	export CHIASM_LEFT_OUT=$$PWD/build/left_out
	: > "$$CHIASM_LEFT_OUT"
	$(MAKE) $$targets
	echo "make test: all passed$$(sed 's/^/; /' "$$CHIASM_LEFT_OUT" | tr -d '\n')"

test-all: build bundles ## every test on the whole catalog (hours)
	@CHIASM_ALL_TESTS=1 $(MAKE) test special-values sanitize-artifacts

# Of the changed ops a part if they are many, a twentieth of the others, the core without guarded kernels.
test-quick: build ## what needs no bundles: changed ops, a part of the others, the core (90 s)
	@CHIASM_QUICK=1 OMP_NUM_THREADS=1 $(PY) -m pytest -q -x -n $(JOBS) tests/ops
	ctest --preset release -j $(JOBS) -L core -E guarded_kernels

test-ops: build ## values, gradients, scripting, docstrings of the ops
	@tools/kornia.sh
	OMP_NUM_THREADS=1 $(PY) -m pytest -q -n $(JOBS) tests/ops

test-export: build test-bundles ## the exporter, the command, the runtime in Python
	$(PY) -m pytest -q -n $(JOBS) --dist loadfile --durations=10 tests/export tests/parity

test-runtime: build test-bundles ## GoogleTest: the runtime, the kernels, the exported bundles
	ctest --preset release -j $(JOBS) -LE 'kernels|robustness'

test-kernels: build ## the kernels again: vectors of SSE4 and AVX-512, loops over values
	@cmake --build --preset release -j $(JOBS) --target kernel_tests
	ctest --preset release -j $(JOBS) -L kernels

test-robustness: build test-bundles ## forks, limits, failing allocations, many loads and threads, damage
	ctest --preset release -j $(JOBS) -L robustness

build-x86-64-v4: build ## the libraries that `chiasm export --isa x86-64-v4` links
	cmake --build --preset release -j $(JOBS) --target artifact_x86-64-v4

build-aarch64: build ## cross-compile the runtime and the libraries for `--isa armv8.2-a`
	@tools/aarch64.sh
	@cmake --preset aarch64 > /dev/null
	cmake --build --preset aarch64 -j $(JOBS)

test-aarch64: build-aarch64 ## kernels, core and bundles under qemu: results must equal this machine's
	CHIASM_RECORD_RESULTS=build/release/kernel_results build/release/bin/guarded_kernels_test --gtest_brief=1
	CHIASM_EXPECTED_RESULTS=$$PWD/build/release/kernel_results ctest --preset aarch64 -j $(JOBS)
	$(PY) tests/parity/aarch64.py
	tests/consumer/aarch64.sh

test-parity: build test-bundles ## compare every exported bundle, artifact, backend and shape with eager Python
	$(PY) tests/parity/matrix.py

parity: build bundles ## compare the whole catalog in every format with eager -> build/parity.json
	$(PY) tests/parity/matrix.py

test-special-values: build test-bundles ## NaN, infinities, extreme numbers in the ops that tests name, for a minute
	@$(PY) tests/parity/special_values.py --seconds 60 $$($(PY) tests/parity/selection.py 2> /dev/null | awk '/a test names it/ {print $$1}')

# -> build/special_values.json
special-values: build bundles ## NaN, infinities, extreme numbers in every op's inputs on every backend
	$(PY) tests/parity/special_values.py

coverage: ## write docs/coverage.md from the catalog and the last `make parity`
	$(PY) tests/parity/coverage.py

docs: ## write docs/kernels.md from the kernels' declarations
	@python3 -B runtime/artifact/generate.py docs docs/kernels.md

# Warnings and broken links are errors.
site: build ## pages and a reference of every op as HTML -> build/site/html
	tools/site.sh

linalg-accuracy: setup ## measure the linear algebra against NumPy -> docs/linalg.md
	$(PY) tests/ops/linalg_accuracy.py

other-runtimes: build test-bundles ## the ONNX artifacts in an old ONNX Runtime and in OpenVINO
	tools/other_runtimes.sh
	$(PY) tests/parity/other_runtimes.py

test-browser: build test-bundles ## in Chromium: the ONNX artifacts on golden vectors, the site's live page
	tools/browser.sh
	$(PY) tests/browser/replay.py
	PYTHONPATH=. $(PY) tools/site/live.py build/live
	$(PY) tests/browser/live.py

# Left out if cargo was not there to get Triton's headers.
test-serving: build test-bundles ## bundles in Triton Inference Server, called by its client
	@if [ ! -e build/release/lib/triton/chiasm/libtriton_chiasm.so ]; then
	  echo "test-serving: left out, because the Triton backend was not built (tools/triton.sh headers says why)" | tee -a "$${CHIASM_LEFT_OUT:-/dev/null}"
	  exit 0
	fi
	tools/triton.sh server
	if [ ! -e .deps/triton ]; then
	  echo "test-serving: left out, because there is no Triton server for this machine" | tee -a "$${CHIASM_LEFT_OUT:-/dev/null}"
	  exit 0
	fi
	$(PY) -m pytest -q --durations=10 tests/serving

test-data: build test-bundles ## bundles over data sets: in processes, on Ray, Spark and Daft
	tools/data.sh
	.deps/data/bin/python -m pytest -q -n $(JOBS) --dist loadfile --durations=5 tests/data

test-studies: build ## the use cases at a small size, and the examples, in Python and in C++
	OMP_NUM_THREADS=1 $(PY) -m pytest -q -n $(JOBS) tests/studies tests/examples

test-sanitizers: test-bundles ## the C++ tests under ASan+UBSan and TSan
	@for preset in asan-ubsan tsan; do
	  cmake --preset $$preset > /dev/null
	  cmake --build --preset $$preset -j $(JOBS)
	  ctest --preset $$preset -j $(JOBS)
	done
	cmake --build --preset asan-ubsan -j $(JOBS) --target artifact
	OMP_NUM_THREADS=1 $(PY) tests/robustness/sanitized_artifacts.py --few

# Later runs use the cache of compiled code.
sanitize-artifacts: build ## forty compiled ops under ASan and UBSan, every tensor guarded (an hour)
	@cmake --preset asan-ubsan > /dev/null
	cmake --build --preset asan-ubsan -j $(JOBS) --target artifact
	OMP_NUM_THREADS=1 $(PY) tests/robustness/sanitized_artifacts.py

# A damaged bundle may also give a right answer.
attack: build test-bundles ## MUTANTS=20000 damaged bundles from FIRST=0 on: an error, never a signal
	cd build && CHIASM_TEST_BUNDLES=../$(BUNDLES) release/bin/mutants $(MUTANTS) $(FIRST) $(JOBS)

# A quarter of the time is under TSan; 20,000 loads on each backend.
soak: build test-bundles ## 64 threads on every backend for MINUTES=60, also under TSan; many loads
	cmake --preset tsan > /dev/null
	cmake --build --preset tsan -j $(JOBS) --target soak chiasm_native
	export CHIASM_TEST_BUNDLES=$(BUNDLES)
	CHIASM_RELOADS=20000 build/release/bin/reload_test
	build/release/bin/soak $$(($(MINUTES) * 45))
	TSAN_OPTIONS=suppressions=$$PWD/tests/runtime/tsan.supp build/tsan/bin/soak $$(($(MINUTES) * 15)) native

test-fuzz: setup ## libFuzzer over every reader, bundles and the C interface, 10 seconds each
	tests/fuzz/run.sh 10

# Two run at a time, and print a line a minute.
fuzz: setup ## libFuzzer for hours: SECONDS=3600 for each of the eight fuzzers
	tests/fuzz/run.sh $(or $(SECONDS),3600)

# ctest covers cmake --install.
test-install: build ## wheels, packs, Debian's and Conan's packages, used from outside
	tests/consumer/pip_install.sh
	tests/consumer/deb.sh build/release build/pip/bundles/filters.sobel.chiasm
	tests/consumer/conan.sh build/pip/bundles/filters.sobel.chiasm

# Ubuntu's jammy needs MIRROR=, the address of one of its mirrors.
fresh-root: build ## the wheel and packages in a system of their own: SUITE=trixie or jammy
	tests/consumer/fresh_root.sh $(or $(SUITE),trixie) $(MIRROR)

# PYTHONS="python3.10 python3.12" makes chiasm for more Pythons.
wheels: build build-x86-64-v4 build-aarch64 ## chiasm (aarch64's too), chiasm-ops, chiasm-export and chiasm-torch -> dist
	tools/wheels.sh runtime aarch64 ops export torch

# Compilations are cached.
dist: wheels bundles ## the wheels, and the catalog as a wheel for each family -> dist (hours)
	tools/packs.sh $(BUNDLES)

# WHAT=speed (the default), images, geometry, peers, memory, matching, serving, ray, letterbox, networks,
# augmentation, kernels or cuda
bench: build ## measure against peers: WHAT=speed, images, ... -> docs/benchmarks*.md
	@case "$(WHAT)" in images | augmentation) tools/kornia.sh ;; esac
	[ "$(WHAT)" != augmentation ] || ABOUT="Albumentations and DALI: 1.4 GB" tools/environment.sh augmentation tools/augmentation.txt
	[ "$(WHAT)" != networks ] || $(MAKE) build-x86-64-v4
	[ "$(WHAT)" != serving ] || tools/triton.sh server
	[ "$(WHAT)" != ray ] || tools/data.sh
	$(PY) -m bench $(or $(WHAT),speed)

lint: build ## layout, style, types and columns of the sources
	@echo "lint: ruff"
	.venv/bin/ruff check --quiet .
	.venv/bin/ruff format --check --quiet .
	echo "lint: clang-format"
	clang-format --dry-run --Werror $(CPP)
	echo "lint: columns of prose and comments"
	$(PY) tools/columns.py $(CPP) $(PROSE)
	echo "lint: clang-tidy"
	tools/tidy.sh
	echo "lint: pyright"
	.venv/bin/basedpyright --level error

format: setup ## lay out the sources: ruff, clang-format
	@.venv/bin/ruff check --fix --quiet .
	.venv/bin/ruff format --quiet .
	clang-format -i $(CPP)

stubs: build ## write the module classes' stubs, for editors -> python/chiasm/*/__init__.pyi
	$(PY) tools/stubs.py

lock: setup ## every *.in -> *.txt, pinned with hashes
	@for name in requirements tools/uv tools/data tools/kornia tools/wheels tools/conan tools/site/site tools/browser/browser tools/triton/environment tools/triton/server \
	    tools/other_runtimes/ort-1.17 tools/other_runtimes/openvino tools/aarch64/python tools/augmentation; do
	  options=(--python-version 3.11)
	  case $$name in
	    tools/uv | tools/wheels | tools/conan) options=(--python-version 3.10) ;;
	    tools/aarch64/python) options=(--python-version 3.10 --no-deps) ;;
	    tools/kornia | tools/triton/server) options+=(--no-deps) ;;
	  esac
	  .venv/bin/uv pip compile -q --upgrade --generate-hashes --no-emit-index-url --no-header "$${options[@]}" $$name.in -o $$name.txt
	done
	tools/browser.sh lock

clean: ## remove what was built (not .venv)
	rm -rf build python/chiasm/*.so python/chiasm/artifact
