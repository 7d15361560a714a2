# feeler: everything there is to run. `make help` lists it; CI calls the same targets.
#
# Each target does the set-up it needs, once: a virtual environment in .venv from requirements.lock, the extension
# module built in release mode. Works with GNU make 3.81 and any POSIX shell.

VENV := .venv
ifeq ($(OS),Windows_NT)
BIN := $(VENV)/Scripts
else
BIN := $(VENV)/bin
endif
PY := $(BIN)/python

# make PYTHON=python3.12 ...: the Python that .venv is made from. PROFILE=dev: an extension module for debugging.
PYTHON ?=
PROFILE ?= release
# make QUICK=1 bench | test: the short form. DEMO_ARGS, VIEW_ARGS, BENCH_ARGS, STUDY_ARGS, PYTEST_ARGS, CARGO_ARGS are passed on.
QUICK ?=
DEMO_ARGS ?=
VIEW_ARGS ?= sample:engine:1600000 --tool sample:wrench
BENCH_ARGS ?=
STUDY_ARGS ?=
STUDY_OUT ?= feeler-study
PYTEST_ARGS ?=
CARGO_ARGS ?=
# make TARGET=aarch64-apple-darwin wheel: a target of Rust.
TARGET ?=
PAIRS ?= 10000000
CASTS ?= 1000000
BODIES ?= 3000
CONTACTS ?= 5000
DEPTHS ?= 3000
FUZZ_SECONDS ?= 1200
FUZZ ?= collide contacts distance mesh saved_scene $(shell $(PY) fuzz/loaders.py --list 2>/dev/null)

# Where rustup puts cargo, for shells that were not told.
export PATH := $(PATH):$(HOME)/.cargo/bin
export VIRTUAL_ENV := $(CURDIR)/$(VENV)
# The Python that PyO3's build script asks; one and the same for all cargo commands, so that none rebuilds for another.
export PYO3_PYTHON := $(CURDIR)/$(PY)
# The build backend of pyproject.toml wraps maturin's; maturin would warn of its name.
export MATURIN_NO_MISSING_BUILD_BACKEND_WARNING := 1
# No recipe calls make; with `make -j2` cargo would look for make's jobserver, which only a make of its own may use.
unexport CONDA_PREFIX PYTHONHOME MAKEFLAGS MFLAGS

# The Rust crates that others may depend on; the rest has `publish = false`.
PUBLISHED := feeler-lanes feeler-core feeler-contacts feeler-world feeler-plan feeler-haptics feeler-devices feeler-saved

# Poses of the core as the types of other crates.
FEATURES := --features feeler-core/glam,feeler-core/nalgebra

# CI compiles once: what cargo keeps for the next time costs a quarter of it.
ifneq ($(CI),)
export CARGO_INCREMENTAL := 0
endif

# In CI the lock file is law; at home cargo may bring it up to date with an edited Cargo.toml.
LOCKED := $(if $(CI),--locked)

# A stamp for each PYTHON, so that naming another one takes effect.
INSTALLED := $(VENV)/.installed$(subst /,-,$(PYTHON))
BUILT := $(VENV)/.built-$(PROFILE)
WHEEL_TOOLS := .venv-wheel/.installed
DOCS_TOOLS := .venv-docs/.installed
RUST_SOURCES := Cargo.toml $(wildcard Cargo.lock) \
	$(shell find crates -name Cargo.toml -o -name build.rs -o -name '*.rs' -path '*/src/*' 2>/dev/null)
EXTENSION := $(wildcard python/feeler/_core*.so python/feeler/_core*.pyd)
NODE_MODULES := viewer/node_modules/.package-lock.json
PAGE := python/feeler/workbench/static/index.html
PAGE_SOURCES := viewer/build.mjs viewer/licences.mjs viewer/tsconfig.json $(shell find viewer/src viewer/public -type f 2>/dev/null)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.SUFFIXES:

##@ Use

.PHONY: help
help: ## list the targets
	@awk 'BEGIN { FS = ":.*## " } \
		/^##@ / { printf "\n%s\n", substr($$0, 5) } \
		/^[a-z][a-z0-9-]*:.*## / { printf "  make %-14s %s\n", $$1, $$2 }' Makefile
	@printf '\nVariables: PYTHON=python3.12 (the Python to use)  QUICK=1 (bench, test: the short form)\n'
	@printf '           DEMO_ARGS= VIEW_ARGS= BENCH_ARGS= PYTEST_ARGS= CARGO_ARGS= (passed on)  PROFILE=dev (unoptimised extension)\n'

.PHONY: demo
demo: build ## index an engine of 1.6M triangles, drive a wrench through it, say what it hits
	@$(BIN)/feeler demo $(DEMO_ARGS)

.PHONY: view
view: build ## the same engine in the browser, to fly through and to take apart (VIEW_ARGS="engine.step --tool wrench.stl")
	@$(BIN)/feeler view $(VIEW_ARGS)

.PHONY: bench
bench: build ## measure feeler and its peers on the same poses, into bench/records (QUICK=1: into target)
	@$(PY) bench/run.py $(if $(QUICK),--quick) $(BENCH_ARGS)
	@$(PY) bench/clash/run.py $(if $(QUICK),--quick)
	@$(PY) bench/removal/run.py $(if $(QUICK),--quick)
	@$(PY) bench/mechanism/run.py $(if $(QUICK),--quick)
	@$(PY) bench/reaching/run.py $(if $(QUICK),--quick)

.PHONY: clash-bench
clash-bench: build ## clash checks alone: hard pairs and times, beside ifcclash and python-fcl (QUICK=1: a minute or two)
	@$(PY) bench/clash/run.py $(if $(QUICK),--quick) $(BENCH_ARGS)

.PHONY: removal-bench
removal-bench: build ## ways out and access alone: puzzles, the engine, beside OMPL (QUICK=1: a minute)
	@$(PY) bench/removal/run.py $(if $(QUICK),--quick) $(BENCH_ARGS)

.PHONY: mechanism-bench
mechanism-bench: build ## mechanisms alone: a door of the engine, what steps miss, bounds; beside python-fcl and MuJoCo (QUICK=1: a minute)
	@$(PY) bench/mechanism/run.py $(if $(QUICK),--quick) $(BENCH_ARGS)

.PHONY: task-bench
task-bench: build ## plans of 300 random assemblies against exhaustive search (QUICK=1: 40; a few seconds)
	@$(PY) bench/tasks/run.py $(if $(QUICK),40) $(BENCH_ARGS)

.PHONY: feel-bench
feel-bench: build ## feel without hardware: passing, tessellation, energy, fits, the engine (QUICK=1: minutes)
	@$(PY) bench/feel/run.py $(if $(QUICK),--quick) $(BENCH_ARGS)

.PHONY: view-bench
view-bench: build ## the workbench in a headless Chromium, against its goals (QUICK=1: minutes)
	@$(PY) bench/workbench/run.py $(if $(QUICK),--quick) $(BENCH_ARGS)

.PHONY: figures
figures: $(INSTALLED) ## make docs/figures.md and the figures in README.md from bench/records
	@$(PY) bench/figures.py

.PHONY: docs
docs: $(DOCS_TOOLS) ## the documentation as a site, in target/site (needs Python 3.11 or later, no Rust)
	@$(dir $(DOCS_TOOLS))$(notdir $(BIN))/python tools/docs_site.py

.PHONY: study
study: build ## repeat the paper's experiments (about ten minutes), write tables, plots and pages to STUDY_OUT
	@for name in voxel-size hashing scaling filters piece-size; do \
		$(BIN)/feeler study $$name --out "$(STUDY_OUT)" $(if $(QUICK),--quick) $(STUDY_ARGS) || exit $$?; \
	done

##@ Set up

.PHONY: setup
setup: $(INSTALLED) ## make .venv with everything of requirements.lock

.PHONY: build
build: $(BUILT) $(PAGE) ## compile the extension module and the workbench's page into python/feeler

.PHONY: page
page: $(PAGE) ## build the workbench's page alone

.PHONY: wheel
wheel: $(WHEEL_TOOLS) $(PAGE) ## build the wheel for all Pythons from 3.10 on into dist/, check and use it (TARGET=: another platform)
	@command -v cargo >/dev/null || { echo "make wheel: cargo not found. Install Rust (stable), or put cargo on the PATH." >&2; exit 1; }
	@$(dir $(WHEEL_TOOLS))$(notdir $(BIN))/python tools/make_wheel.py $(if $(TARGET),--target $(TARGET))

# What is published is compiled from its package, each against the packages below it.
.PHONY: package
package: ## make the packages of the Rust crates that are published, in target/package, and compile them
	@cargo package --allow-dirty $(LOCKED) $(PUBLISHED:%=-p %)

# An environment does not survive a move of the clone, nor the loss of its interpreter.
ifneq ($(shell $(PY) -c "" 2>/dev/null && cat $(VENV)/.made-in 2>/dev/null),$(CURDIR))
.PHONY: $(INSTALLED)
endif
$(INSTALLED): requirements.lock tools/make_venv.sh
	@PYTHON="$(PYTHON)" sh tools/make_venv.sh $(VENV) requirements.lock "$(CURDIR)"
	@touch $@

# The tools of `make wheel` and `make docs` have environments of their own: few need them, and these need little else.
.venv-%/.installed: requirements-%.lock tools/make_venv.sh
	@PYTHON="$(PYTHON)" sh tools/make_venv.sh .venv-$* $< "$(CURDIR)"
	@touch $@

# The editable install leaves the extension beside its sources; make it again if somebody removed it.
ifeq ($(EXTENSION),)
.PHONY: $(BUILT)
endif
$(BUILT): $(INSTALLED) pyproject.toml $(RUST_SOURCES)
	@command -v cargo >/dev/null || { echo "make build: cargo not found. Install Rust (stable), or put cargo on the PATH." >&2; exit 1; }
	@PIP_QUIET=1 $(PY) -m maturin develop --profile $(PROFILE) $(LOCKED)
	@rm -f $(VENV)/.built-*
	@touch $@

$(NODE_MODULES): viewer/package.json viewer/package-lock.json
	@command -v npm >/dev/null || { echo "make build: npm not found. Install Node 20 or newer, or put it on the PATH." >&2; exit 1; }
	@npm ci --prefix viewer --no-progress --loglevel=error
	@touch $@

$(PAGE): $(NODE_MODULES) $(PAGE_SOURCES)
	@node viewer/build.mjs
	@touch $@

##@ Check

.PHONY: test
test: test-rust test-haply test-page test-browser test-python ## all tests
	@echo "make test: cargo test, node --test and pytest passed"

# feeler-py is a module for Python to load: it has no tests of its own, and would need libpython to link one.
.PHONY: test-rust
test-rust: ## cargo test of all crates but the Python binding, and their examples
	@command -v cargo >/dev/null || { echo "make test: cargo not found. Install Rust (stable), or put cargo on the PATH." >&2; exit 1; }
	@cargo test --workspace --exclude feeler-py $(FEATURES) $(LOCKED) $(CARGO_ARGS)

# A project of its own: the maker's crate brings an HTTP client, which on Linux is compiled against OpenSSL.
.PHONY: test-haply
test-haply: ## the Haply driver's messages, judged by the maker's own crate (on Linux: needs OpenSSL's headers)
	@command -v cargo >/dev/null || { echo "make test-haply: cargo not found. Install Rust (stable), or put cargo on the PATH." >&2; exit 1; }
	@if [ "$$(uname -s)" != Linux ] || pkg-config --exists openssl 2>/dev/null; then \
		cargo test --manifest-path tools/haply_judge/Cargo.toml --target-dir target/haply $(LOCKED) $(CARGO_ARGS); \
	elif [ -n "$(CI)" ]; then \
		echo "make test-haply: no OpenSSL headers, and CI may not leave it out (Debian: libssl-dev, pkg-config)" >&2; exit 1; \
	else \
		echo "make test-haply: left out, for it needs OpenSSL's headers (Debian: libssl-dev, pkg-config)"; \
	fi

.PHONY: test-page
test-page: $(NODE_MODULES) ## the workbench's page without a browser: node --test
	@npm test --prefix viewer --silent

# In pytest there are those that use the whole workbench.
.PHONY: test-browser
test-browser: $(NODE_MODULES) ## the page's picture, sound and VR in a Chromium (FEELER_CHROMIUM=: another than /usr/bin/chromium)
	@npm run test:browser --prefix viewer --silent

# Three processes, by the names of the files, for `make -j3`: much of their time is waiting. The longest begins first. What is asked
# for by PYTEST_ARGS runs in one.
SHARES := $(addprefix test-python-,third second first)
.PHONY: test-python $(SHARES)
ifeq ($(strip $(PYTEST_ARGS)),)
test-python: $(SHARES) ## pytest: warnings are errors, every test has a time-out
else
test-python: build
	@$(PY) -m pytest $(if $(QUICK),-m "not slow") $(PYTEST_ARGS)
endif
FILES_first := tests/test_[a-f]*.py
FILES_second := tests/test_[g-r]*.py
FILES_third := tests/test_[s-z]*.py
$(SHARES): test-python-%: build
	@$(PY) -m pytest $(if $(QUICK),-m "not slow") -p no:cacheprovider $(FILES_$*)

.PHONY: exact
exact: build ## ten million hard pairs, thousands of scenes, a million casts, bodies, contacts and depths (PAIRS=, CASTS=, BODIES=, CONTACTS=, DEPTHS=)
	@cargo run --release $(LOCKED) -p feeler-exact -- mass --pairs $(PAIRS)
	@cargo run --release $(LOCKED) -p feeler-exact -- casts --casts $(CASTS)
	@cargo run --release $(LOCKED) -p feeler-exact -- bodies --sets $(BODIES)
	@cargo run --release $(LOCKED) -p feeler-exact -- contacts --cases $(CONTACTS)
	@cargo run --release $(LOCKED) -p feeler-exact -- depths --cases $(DEPTHS)
	@cargo test --release $(LOCKED) -p feeler-core -p feeler-contacts --test determinism
	@FEELER_LARGE=1 $(PY) -m pytest tests/test_stores.py

.PHONY: fuzz
fuzz: build ## fuzz collisions, distances, contacts, saved scenes and every loader (FUZZ_SECONDS= each, FUZZ="collide stl")
	@sh tools/fuzz.sh $(PY) $(FUZZ_SECONDS) $(FUZZ)

.PHONY: project-kills
project-kills: build ## kill the workbench 200 times while it saves, and damage a project 3,000 times (KILLS=, DAMAGES=)
	@FEELER_PROJECT_KILLS=$(or $(KILLS),200) FEELER_PROJECT_FUZZ=$(or $(DAMAGES),3000) \
		$(PY) -m pytest tests/test_project.py tests/test_project_workbench.py -k "kill or damage"

.PHONY: sanitize
sanitize: ## the core's tests under AddressSanitizer (needs a nightly Rust)
	@cargo +nightly --version >/dev/null 2>&1 || { echo "make sanitize: needs a nightly Rust (rustup toolchain install nightly)" >&2; exit 1; }
	@RUSTFLAGS=-Zsanitizer=address cargo +nightly test -p feeler-lanes -p feeler-core -p feeler-contacts --target $$(rustc -vV | sed -n 's/^host: //p') \
		--target-dir target/sanitize $(CARGO_ARGS)

.PHONY: arm64
arm64: export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER = aarch64-linux-gnu-gcc
arm64: export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER = qemu-aarch64 -L /usr/aarch64-linux-gnu
arm64: ## the core's tests and the corpus of hard pairs for arm64, emulated: the same answers (15 minutes)
	@command -v qemu-aarch64 >/dev/null && command -v aarch64-linux-gnu-gcc >/dev/null || { echo "make arm64: needs an emulator and a linker (Debian: qemu-user, gcc-aarch64-linux-gnu, libc6-dev-arm64-cross)" >&2; exit 1; }
	@[ -d "$$(rustc --print sysroot)/lib/rustlib/aarch64-unknown-linux-gnu" ] || { echo "make arm64: needs Rust's library for it (rustup target add aarch64-unknown-linux-gnu)" >&2; exit 1; }
	cargo test --release $(LOCKED) --target aarch64-unknown-linux-gnu --target-dir target/arm64 -p feeler-lanes -p feeler-core -p feeler-contacts $(CARGO_ARGS)
	cargo test --release $(LOCKED) --target aarch64-unknown-linux-gnu --target-dir target/arm64 -p feeler-exact --test corpus $(CARGO_ARGS)

.PHONY: arm64-wheel
arm64-wheel: $(WHEEL_TOOLS) $(PAGE) ## build the wheel for arm64 Linux into dist/, and use it with an emulated Python (Debian; 5 minutes)
	@command -v cargo >/dev/null || { echo "make arm64-wheel: cargo not found. Install Rust (stable), or put cargo on the PATH." >&2; exit 1; }
	@$(dir $(WHEEL_TOOLS))$(notdir $(BIN))/python tools/smoke_arm64.py --check
	@rm -f dist/feeler-*manylinux*aarch64.whl
	@$(dir $(WHEEL_TOOLS))$(notdir $(BIN))/python tools/make_wheel.py --target aarch64-unknown-linux-gnu
	@$(dir $(WHEEL_TOOLS))$(notdir $(BIN))/python tools/smoke_arm64.py dist/feeler-*manylinux*aarch64.whl

.PHONY: portable
portable: ## cargo check for arm64 Linux, macOS and Windows: no warning there either (needs Rust's libraries for them)
	@set -e; for target in aarch64-unknown-linux-gnu aarch64-apple-darwin x86_64-pc-windows-gnu; do \
		[ -d "$$(rustc --print sysroot)/lib/rustlib/$$target" ] || { echo "make portable: needs Rust's library for it (rustup target add $$target)" >&2; exit 1; }; \
		echo "make portable: $$target"; \
		RUSTFLAGS="--deny warnings" PYO3_NO_PYTHON=1 cargo check -p feeler-py --features extension-module $(LOCKED) --quiet \
			--target $$target --target-dir target/portable; \
	done

.PHONY: avx512
avx512: export CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER = $(CURDIR)/tools/emulate_avx512.sh
avx512: ## the core's kernels with AVX-512, emulated, where the CPU lacks it: the same answers (20 minutes)
	cargo test --release $(LOCKED) -p feeler-core --test proximity $(CARGO_ARGS) -- speck lattice long_thin
	cargo test --release $(LOCKED) -p feeler-core --test brute_force $(CARGO_ARGS) -- tool_triangles many_ large_batches outside
	cargo test --release $(LOCKED) -p feeler-lanes -p feeler-core -p feeler-contacts --lib $(CARGO_ARGS) -- --skip tests::convex

.PHONY: lint
lint: lint-rust lint-python lint-page lint-rules ## everything below
	@echo "make lint: all clean"

.PHONY: lint-rust
lint-rust: $(INSTALLED) ## rustfmt, clippy (the lints are listed in Cargo.toml) and rustdoc
	@cargo fmt --version >/dev/null 2>&1 || { echo "make lint: rustfmt not found (rustup component add rustfmt)" >&2; exit 1; }
	@cargo clippy --version >/dev/null 2>&1 || { echo "make lint: clippy not found (rustup component add clippy)" >&2; exit 1; }
	cargo fmt --all --check
	cargo clippy --workspace --all-targets $(FEATURES) $(LOCKED) --quiet -- --deny warnings
	RUSTDOCFLAGS="--deny warnings" cargo doc --workspace --no-deps $(FEATURES) $(LOCKED) --quiet

.PHONY: lint-python
lint-python: build ## ruff, mypy (strict), and the type stubs against the compiled module
	$(BIN)/ruff check --quiet .
	$(BIN)/ruff format --check --quiet .
	$(PY) -m mypy
	$(PY) -m mypy examples
	MYPYPATH=python $(PY) -m mypy.stubtest feeler._core --mypy-config-file pyproject.toml

.PHONY: lint-page
lint-page: $(INSTALLED) $(NODE_MODULES) ## TypeScript (strict), Biome, who may import whom, and the messages' types against their source
	npm run check --prefix viewer --silent
	$(PY) tools/check_page.py
	$(PY) tools/protocol_ts.py --check
	$(PY) tools/view_commands.py --check

.PHONY: lint-rules
lint-rules: $(INSTALLED) ## who may import whom; file sizes, SAFETY comments, left-overs
	$(PY) tools/check_layers.py
	$(PY) tools/check_files.py
	$(PY) tools/docstrings.py --check

##@ Care

.PHONY: format
format: $(INSTALLED) $(NODE_MODULES) ## format Rust, Python and TypeScript, apply ruff's safe fixes
	@cargo fmt --all
	@$(BIN)/ruff check --fix --quiet . || true
	@$(BIN)/ruff format .
	@npm run format --prefix viewer --silent

.PHONY: lock
lock: $(INSTALLED) ## make the lock files anew from pyproject.toml (newest versions)
	@$(PY) -m pip install --quiet uv
	$(call pin,requirements.lock,make setup,--extra step --extra gltf --extra study --extra volume --extra xlsx --extra mcp --extra bench \
		--group build --group test --group lint pyproject.toml)
	$(call pin,requirements-wheel.lock,make wheel,--group wheel)
	$(call pin,requirements-docs.lock,make docs,--group docs)

# $(1): a lock file. $(2): the command that installs it. $(3): what of pyproject.toml it has.
define pin
	@{ echo '# Everything `$(2)` installs, exactly, for Python 3.10 and later on Linux, macOS and Windows.'; \
	   echo '# Made from pyproject.toml by `make lock`; not edited by hand.'; \
	   $(BIN)/uv pip compile --quiet --universal --python-version 3.10 --generate-hashes --no-header --no-annotate \
		--no-emit-index-url --no-emit-find-links $(3); } >$(1).new
	@mv $(1).new $(1)
endef

.PHONY: clean
clean: ## remove everything that make made
	@rm -rf viewer/node_modules python/feeler/workbench/static
	@rm -rf $(VENV) .venv-wheel .venv-docs target build dist feeler-demo feeler-study .hypothesis .mypy_cache .pytest_cache .ruff_cache
	@rm -f python/feeler/_core*.so python/feeler/_core*.pyd
	@find . -name __pycache__ -type d -not -path './node_modules/*' -prune -exec rm -rf {} +
