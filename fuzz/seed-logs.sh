#!/bin/sh
# Fills the corpora of ulog and dataflash from a folder of logs: the start of each, with the
# definitions and the first data. Usage: fuzz/seed-logs.sh LOGS
set -eu
logs=${1:?usage: $0 LOGS}
for kind in ulog:ulg dataflash:bin; do
    corpus=$(dirname "$0")/corpus/${kind%:*}
    mkdir -p "$corpus"
    for file in "$logs"/*."${kind#*:}"; do
        head -c 90000 "$file" >"$corpus/$(basename "$file")"
    done
done
