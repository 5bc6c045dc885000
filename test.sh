#!/usr/bin/env bash
# All tests: format, lints, docs, unit, integration and doc tests, and the files that we write opened by their real readers.
# Needs Rust and a C compiler; Python 3 for the last part.
set -euo pipefail
cd "$(dirname "$0")"

step() { printf '\n== %s\n' "$*"; }

step "format"
cargo fmt --all --check

step "lints"
cargo clippy --workspace --all-targets --locked -- -D warnings

step "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked

step "tests"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
cargo test --workspace --locked 2>&1 | tee "$log"
# A suite in which nothing ran has not passed. Binaries and crates without tests of their own kind report 0 and are
# not suites; the integration tests and the doc tests are.
awk '
    /^ +Running tests\// { suite = $2 }
    /^ +Doc-tests/ { suite = $0 }
    /^ +Running unittests/ { suite = "" }
    /^test result:/ {
        total += $4
        if (suite != "" && $4 == 0) { print "ran nothing: " suite; bad = 1 }
        suite = ""
    }
    END { print total " tests passed"; exit (bad || total == 0) }
' "$log"

step "library without the command line"
cargo check -p fieldstone --no-default-features --locked

step "files opened by their real readers"
if [ ! -x .venv/bin/python ]; then
    python3 -m venv .venv
fi
.venv/bin/python -m pip install --quiet --requirement tools/requirements.txt
samples=$(mktemp -d)
trap 'rm -rf "$log" "$samples"' EXIT
cargo run --quiet --locked -p fieldstone-io --example write_vtk_samples -- "$samples"
printf 'x,y,z,r,mass\n0.003,0.003,0.003,0.001,1\n' > "$samples/ball.csv"
cargo run --release --quiet --locked -p fieldstone -- fields --particles "$samples/ball.csv" \
    --mesh "$samples/standard_raw_zlib.vtu" --fields volume_fraction,density,mean_radius --out "$samples/fields.vtu"
.venv/bin/python tools/check_vtk_output.py "$samples" "$samples/fields.vtu"

step "the demo"
cargo run --release --quiet --locked -p fieldstone -- demo "$samples/demo"
for file in solid_fraction.vtu solid_fraction.png summary.txt summary.json; do
    test -s "$samples/demo/$file"
done

step "surfaces opened by pyvista"
.venv/bin/python tools/check_surfaces.py --with "${CARGO_TARGET_DIR:-target}/release/fieldstone" "$samples/surfaces"

printf '\nall tests passed\n'
