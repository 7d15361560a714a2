#!/bin/sh
# Fuzzes: tools/fuzz.sh PYTHON SECONDS TARGET...   (targets: collide, contacts, distance, mesh, saved_scene, and the formats of fuzz/loaders.py)
#
# Needs a nightly Rust for the targets in Rust, and atheris (Linux, macOS) for the loaders; both say so when missing.
# Corpora and crashes: build/fuzz.
set -eu
cd "$(dirname "$0")/.."
python=$1
seconds=$2
shift 2

for target; do
    echo "== $target, $seconds s"
    case $target in
    collide | contacts | distance | mesh | saved_scene)
        if ! cargo +nightly --version >/dev/null 2>&1; then
            echo "make fuzz: the sanitizers need a nightly Rust (rustup toolchain install nightly)" >&2
            exit 1
        fi
        PATH=$PWD/build/tools/bin:$PATH
        cargo fuzz --version >/dev/null 2>&1 || cargo install --quiet --root build/tools cargo-fuzz
        mkdir -p "build/fuzz/$target"
        cargo +nightly fuzz run "$target" "build/fuzz/$target" "fuzz/seeds/$target" -- \
            -max_total_time="$seconds" -artifact_prefix="$PWD/build/fuzz/crash-$target-" -rss_limit_mb=4000 -print_final_stats=1 -verbosity=0
        ;;
    *)
        "$python" -c 'import atheris' 2>/dev/null || "$python" -m pip install --quiet 'atheris==3.0.0' || {
            echo "make fuzz: atheris cannot be installed for this Python; the loaders need it" >&2
            exit 1
        }
        "$python" fuzz/loaders.py "$target" -max_total_time="$seconds" -print_final_stats=1 -verbosity=0
        ;;
    esac
done
