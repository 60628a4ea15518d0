#!/bin/sh
# Fuzzes one target with the stable compiler: LLVM is asked directly for libFuzzer's counters. This needs a
# C++ compiler, but neither a nightly compiler nor cargo-fuzz. Usage: fuzz/run.sh TARGET [SECONDS]
set -eu
target=${1:?usage: $0 TARGET [SECONDS]}
seconds=${2:-600}
cd "$(dirname "$0")"
host=$(rustc -vV | sed -n 's/^host: //p')
llvm=-Cllvm-args=-sanitizer-coverage
RUSTFLAGS="-Cpasses=sancov-module $llvm-level=4 $llvm-inline-8bit-counters $llvm-pc-table \
    $llvm-trace-compares --cfg fuzzing -Ccodegen-units=1" \
    cargo build --release --all-features --target "$host" --bin "$target"
mkdir -p "corpus/$target"
exec "target/$host/release/$target" "corpus/$target" -runs=10000000 -max_total_time="$seconds" \
    -max_len=1024 -rss_limit_mb=256 -timeout=20 -print_final_stats=1
