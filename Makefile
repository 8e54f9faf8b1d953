# Every target that builds first sees to it that the machine can: setup takes a moment when all is there.
.DEFAULT_GOAL := help
.NOTPARALLEL: # cargo uses all cores by itself, and two set-ups at once would collide
.PHONY: help setup setup-tests setup-python demo install uninstall python test test-python test-long fuzz gallery docs bench curves views cluster style lint deny clean

env := . scripts/env.sh &&
# Tests also run the CPU kernels with bounds checks; what checks builds the same, or it would be built twice.
# Mesa's compiler of software Vulkan takes half as long for short vectors; programs that are run so are tests alone.
test_env := $(env) LP_NATIVE_VECTOR_WIDTH=128 RAGGIO_KERNEL_LEVELS=all

PREFIX ?= $(HOME)/.local
target := $${CARGO_TARGET_DIR:-target}

help: ## list these targets
	@echo "raggio, a progressive path tracer. Targets:"
	@sed -n 's/^\([a-z-]*\):[^#]*## \(.*\)/  make \1	\2/p' Makefile

setup: ## install what is missing: slangc and Python tools into .venv
	@bash scripts/setup.sh

setup-tests: # setup, and a software Vulkan device where root can install one
	@bash scripts/setup.sh --tests

setup-python: # setup, and what builds and tests the Python module
	@bash scripts/setup.sh --python

demo: setup ## build raggio and render its showcase
	@# Without the window, and for this processor alone: a third of what there is to compile.
	$(env) RAGGIO_KERNEL_LEVELS=native cargo run --profile quick --package raggio-cli --no-default-features -- demo

install: setup ## put raggio, completions and manual pages into PREFIX (~/.local)
	$(env) cargo build --release --package raggio-cli
	$(env) bash scripts/install.sh "$(target)/release/raggio" "$(DESTDIR)$(PREFIX)"

uninstall: ## take away what `make install` put into PREFIX
	bash scripts/install.sh --remove "$(DESTDIR)$(PREFIX)"

# Without the window, and for this processor alone, as the demo. `pip install .` builds all of it.
python: setup-python ## build the Python module into .venv
	$(env) RAGGIO_KERNEL_LEVELS=native maturin develop --release --no-default-features

test: setup-tests ## build and run all tests
	$(test_env) cargo test --profile quick --workspace

test-python: python ## test the Python module
	$(env) python -m pytest -q

# Every lamp on every material alone, every lamp at every depth, software Vulkan beside Mitsuba's pictures, instructions of a
# sample as valgrind counts them, and CONTRIBUTING's disk built into a copy of the tree: what takes long and has rarely found
# anything beyond what `make test` runs. No run for a change needs it.
test-long: setup-tests ## the tests with all that is too slow for `make test`
	$(test_env) RAGGIO_TEST_LONG=1 cargo test --profile quick --workspace

# The readers need no kernels, so nothing is set up. The limit on memory, in KiB, is for all formats of a program together.
fuzz_seconds ?= 60
fuzzed := --release --package raggio-scene --package raggio-models --package raggio-images

fuzz: ## damage scenes, models and images, each format for fuzz_seconds (60), and read them
	$(env) cargo test $(fuzzed) --no-run
	$(env) ulimit -v 4194304 && RAGGIO_FUZZ_SECONDS=$(fuzz_seconds) \
	cargo test $(fuzzed) -- --nocapture fuzz hostile::mutated

gallery: setup ## render the pictures of the documentation
	$(env) python scripts/gallery.py

# Fails where links lead to no file or heading. The variable keeps Material from advertising its successor.
docs: ## make the documentation's site, with the Python reference and the gallery, in site/
	@bash scripts/setup.sh --docs
	NO_MKDOCS_2_WARNING=1 .venv-docs/bin/mkdocs build --strict

# Options of scripts/bench: --quick, --all, --only, --without, --help.
bench_options ?=

bench: setup ## measure raggio beside Mitsuba, Cycles and Embree (bench_options=--quick: a minute)
	$(env) python scripts/bench $(bench_options)

# Options of scripts/bench/curves.py: --all, --only, --plots docs/images, --help.
curve_options ?=

curves: setup ## measure how cost grows with triangles, pixels, lights ..., and how the error falls with samples
	$(env) python scripts/bench/curves.py $(curve_options)

views ?= 1000

views: python ## measure many small views from Python, beside Mitsuba and pyrender, and how memory grows
	$(env) python scripts/bench/views.py --views $(views)

cluster: python ## measure a cluster of one worker and of two, and simulate a thousand
	$(env) python scripts/bench/cluster.py

style: setup # lint without the compiler
	$(env) cargo fmt --all --check
	$(env) python scripts/check_links.py
	@$(env) if cargo deny --version >/dev/null 2>&1; then cargo deny check bans licenses sources; \
	else echo "lint: cargo-deny is not installed: licences and sources of dependencies were NOT checked (see make deny)"; fi

lint: style ## check formatting, the documentation's links, warnings and, with cargo-deny, licences
	$(test_env) cargo clippy --workspace --all-targets --profile quick -- -D warnings

deny: ## check dependencies: licences, sources, known vulnerabilities (needs cargo-deny and the network)
	@$(env) cargo deny --version >/dev/null 2>&1 || \
	{ echo "deny: cargo-deny is not installed: cargo install --locked cargo-deny"; exit 1; }
	$(env) cargo deny check

clean: ## remove what was built; .venv stays
	$(env) cargo clean
	rm -rf site
