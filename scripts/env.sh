# shellcheck shell=sh
# Sourced from the project's root by the Makefile: finds cargo and the tools that scripts/setup.sh put into .venv.
# It sets PATH alone. SLANGC stays the user's own choice: setting it here would have the kernels rebuilt at each
# change between `make` and a plain `cargo build`, which finds .venv/bin/slangc by itself.
if ! command -v cargo >/dev/null 2>&1; then
    PATH="$PATH:${CARGO_HOME:-${HOME:-}/.cargo}/bin"
fi
if [ -d .venv/bin ]; then
    PATH="$(pwd)/.venv/bin:$PATH"
fi
export PATH
