#!/bin/sh
# Renews the pictures of docs/gallery.md and the report of README.md: runs the commands and photographs the pages.
# Needs chromium, the datasets of the repository, and the logs in the directory SHARED.
# Usage: docs/gallery.sh HOVERNAV SHARED
set -eu
hovernav=${1:?usage: $0 HOVERNAV SHARED}
shared=${2:?usage: $0 HOVERNAV SHARED}
docs=$(cd "$(dirname "$0")" && pwd)
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT

# browse HEIGHT ARGUMENT...: the page, in a window of this height
browse() {
    height=$1
    shift
    chromium --headless=new --no-sandbox --hide-scrollbars --window-size="1400,$height" \
        --force-device-scale-factor=0.65 --virtual-time-budget=8000 "$@" 2>"$place/chromium.txt"
}

# photograph PAGE NAME SECTION...: the head of the page and these of its sections, whole
photograph() {
    page=$1 name=$2
    shift 2
    shown=$(printf ':not(#%s)' "$@")
    file=$place/$page/shown.html
    cp "$place/$page/report.html" "$file"
    cat >>"$file" <<END
<style>main section$shown, nav { display: none } h1, h2, p { margin: 4px 0 }</style>
<script>setTimeout(() => {
    const end = Math.max(...[...document.querySelectorAll("main > *")].map(e => e.getBoundingClientRect().bottom));
    document.body.dataset.end = Math.ceil(end + window.scrollY);
}, 4000)</script>
END
    # A window of another height than the page would cut it or leave a blank.
    end=$(browse 860 --dump-dom "file://$file" | sed -n 's/.*<body[^>]* data-end="\([0-9]*\)".*/\1/p')
    browse "$((end + 16))" --screenshot="$docs/gallery-$name.png" "file://$file"
}

# A log of somebody's own: the hover in degrees, g and milliseconds, axes forward, left, up.
foreign() {
    awk -F, 'BEGIN { print "time_ms;gx_dps;gy_dps;gz_dps;ax_g;ay_g;az_g" }
        NR > 1 { d = 57.29577951308232; g = 9.80665
            printf "%.3f;%.7f;%.7f;%.7f;%.7f;%.7f;%.7f\n",
                1000 * $1, d * $2, -d * $3, -d * $4, $5 / g, -$6 / g, -$7 / g }' \
        "$docs/../datasets/heli-hover/imu.csv" >"$place/own-imu.csv"
    cp "$docs/../datasets/heli-hover/gps.csv" "$place/own-gps.csv"
    (cd "$place" && "$hovernav" --quiet init own-imu.csv own-gps.csv --out own)
}

# As README.md has it, for the page shows the path.
(cd "$docs/.." && "$hovernav" --quiet estimate datasets/heli-hover --out "$place/dataset")
photograph dataset dataset map
photograph dataset report velocity
mv "$docs/gallery-report.png" "$docs/report.png"
"$hovernav" --quiet estimate "$shared/logs/px4-quad-vibration-2025.ulg" --out "$place/ulog"
photograph ulog ulog position
photograph ulog ulog-innovations innovations
"$hovernav" --quiet estimate "$shared/datasets/quad-ardupilot-5hz" --out "$place/quad"
photograph quad quad attitude
"$hovernav" --quiet estimate "$shared/datasets/car-rtk" --outage 200:30 --out "$place/car"
photograph car car velocity
foreign
"$hovernav" --quiet estimate "$place/own" --out "$place/text"
photograph text text map
"$hovernav" --quiet identify "$docs/../datasets/heli-hover" --out "$place/helicopter"
photograph helicopter helicopter second-opinion
gunzip -c "$shared/cases/identification/sid.bin.gz" >"$place/sid.bin"
"$hovernav" --quiet identify "$place/sid.bin" --out "$place/multirotor"
photograph multirotor multirotor second-opinion
"$hovernav" --quiet design raptor60 --at raptor60@4 --at raptor60@8 --out "$place/forward"
photograph forward forward forward
"$hovernav" --quiet design raptor60 --out "$place/design"
sed -e "s#/tmp/hovernav-#$place/line-#" -e "s#../out/raptor60#$place/design#" \
    -e "s#\"out/records\"#\"$place/records\"#" "$docs/../examples/loop.toml" >"$place/loop.toml"
"$hovernav" --quiet simulate --lines --config "$place/loop.toml" --duration 60 --do engage@25:33 \
    --out "$place/truth" &
"$hovernav" --quiet fly --config "$place/loop.toml" --record "$place/flight.mcap" --duration 60
wait
"$hovernav" --quiet report "$place/flight.mcap" --out "$place/record"
photograph record record modes
"$hovernav" --quiet estimate "$docs/../datasets/heli-hover" --smooth --out "$place/smoothed"
"$hovernav" --quiet compare "$place/dataset/solution.csv" "$place/smoothed/solution.csv" \
    --out "$place/compared"
photograph compared compared velocity
