#!/bin/sh
# Fills fuzz/corpus/dmu_decoder from a folder of captures with clean_330.bin, damaged.bin and
# golden_angle.json. Usage: fuzz/seed-dmu.sh CAPTURES/dmu_synthetic
set -eu
captures=${1:?usage: $0 CAPTURES/dmu_synthetic}
corpus=$(dirname "$0")/corpus/dmu_decoder
mkdir -p "$corpus"

# seed NAME HEAD: standard input after the three bytes that choose mode, piece and announcement.
seed() {
    { printf "$2"; cat; } >"$corpus/$1"
}

for file in clean_330 damaged; do
    at=0
    size=$(wc -c <"$captures/$file.bin")
    while [ "$at" -lt "$size" ]; do
        # 301 bytes: every slice begins at another offset in a packet.
        tail -c +$((at + 1)) "$captures/$file.bin" | head -c 301 | seed "$file-$at" '\000\377\000'
        tail -c +$((at + 1)) "$captures/$file.bin" | head -c 90 | seed "$file-$at-short" '\006\036\001'
        at=$((at + 301))
    done
done

grep -o '"hex": *"[0-9a-f]*"' "$captures/golden_angle.json" | tr -d '": ' | sed 's/^hex//' |
    while read -r hex; do
        octal=$(printf '%s' "$hex" | sed 's/../0x& /g' | xargs printf '\\%03o')
        printf "$octal$octal$octal" | seed "golden-$hex" '\000\017\000'
    done

# Replies to R, a and c, each alone on the line, then packets.
{ printf 'HA'; head -c 240 "$captures/clean_330.bin"; } | seed replies-angle '\000\001\000'
{ printf 'HC'; head -c 240 "$captures/clean_330.bin"; } | seed replies-scaled '\001\001\000'
{ printf 'HA'; head -c 240 "$captures/clean_330.bin"; } | seed replies-polled '\006\001\000'
ls "$corpus" | wc -l
