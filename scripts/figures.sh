#!/bin/sh
# Figures: measures the table and the chart of the README, and the table of references of docs/BENCHMARKS.md.
#   sh scripts/figures.sh [--quick]
# Builds the release; renders references into target/figures/ and keeps those that are there; runs `joton bench` with
# them; writes the parts of README.md and docs/BENCHMARKS.md that stand between <!-- figures --> and <!-- references -->
# and their ends, docs/images/figures.svg and docs/benchmarks/figures.csv. How long that takes: docs/BENCHMARKS.md.
# --quick tries the script in a minute: tiny pictures, a tenth of the time, bad references, all of it in target/figures/quick/.
# Needs a software Vulkan device: the cost is CPU seconds, which say nothing of a GPU.
set -eu
cd "$(dirname "$0")/.."

say() { printf 'figures: %s\n' "$*"; }
fail() {
    say "FAILED: $*" >&2
    exit 1
}

scenes="cornell spheres pool"
target=${CARGO_TARGET_DIR:-target}
joton=$target/release/joton
case "$*" in
'')
    size=256x256 seeds=3 times=0.25,0.5,1,1.5,2,3,5,8,12 wanted='1 3 10' shrink=1
    out=$target/figures readme=README.md page=docs/BENCHMARKS.md
    chart=docs/images/figures.svg rows=docs/benchmarks/figures.csv
    mkdir -p "$out"
    ;;
--quick)
    size=32x32 seeds=2 times=0.05,0.1,0.2,0.5,1,1.2 wanted='0.1 0.3 1' shrink=16
    out=$target/figures/quick readme=$out/README.md page=$out/BENCHMARKS.md
    chart=$out/figures.svg rows=$out/figures.csv
    mkdir -p "$out"
    cp README.md docs/BENCHMARKS.md "$out"
    ;;
*) fail "$* is not known; give --quick or nothing" ;;
esac

# Passes of a scene's reference, and samples a pixel of each of two pictures of the path tracer.
passes() {
    case $1 in
    cornell) echo $((4096 / shrink)) ;;
    spheres) echo $((1024 / shrink)) ;;
    pool) echo $((512 / shrink)) ;;
    esac
}
samples=$((512 / shrink))

# render SCENE FILE ARGUMENTS…: a picture with its report, unless it is there. Files are named by all that makes them.
render() {
    scene=$1 file=$out/$2
    shift 2
    if [ -s "$file.exr" ]; then
        say "$file.exr is there"
        return
    fi
    say "rendering $file.exr"
    # a render that is stopped saves what it has: only a whole one gets its name
    "$joton" render "scenes/$scene.toml" --size "$size" --device cpu --quiet "$@" --report "$file.json" \
        -o "$out/unfinished.exr"
    mv "$out/unfinished.exr" "$file.exr"
}

# cpu_seconds FILE: of a render, from its report.
cpu_seconds() { awk -F '[:,]' '/"cpu_seconds"/ { printf "%.0f", $2; exit }' "$out/$1.json"; }

# between MARK FILE REPLACEMENT: puts a file in place of what stands between <!-- MARK --> and <!-- /MARK -->.
between() {
    awk -v mark="$1" -v replacement="$3" '
        $0 == "<!-- /" mark " -->" { inside = 0; ends++ }
        !inside { print }
        $0 == "<!-- " mark " -->" {
            inside = 1; begins++
            print ""
            while ((getline line < replacement) > 0) print line
            print ""
        }
        END { exit !(begins == 1 && ends == 1 && !inside) }' "$2" >"$out/between" || fail "$2 has no <!-- $1 --> with its end"
    cat "$out/between" >"$2"
    rm "$out/between"
}

name() {
    case $1 in
    cornell) echo "Cornell box" ;;
    spheres) echo "glass and mirror spheres" ;;
    pool) echo "pool, seen through waves" ;;
    esac
}

cargo build --release --locked

# The first kernels are compiled here, and a device that these figures are not of is told before anything is rendered.
"$joton" render scenes/furnace.toml --size 8x8 --device gpu --passes 1 --quiet --report "$out/device.json" \
    -o "$out/device.png" || fail "no device; on Debian: apt-get install mesa-vulkan-drivers libvulkan1"
device=$(sed -n 's/^ *"device": "\(.*\)",$/\1/p' "$out/device.json")
case $device in
*"(software, "*) ;;
*) fail "$device is a GPU; let VK_DRIVER_FILES name the driver of software Vulkan alone" ;;
esac
device=$(echo "$device" | sed 's/.*(software, [^,]*, \(.*\))$/\1/')

# Seeds are far from those of the bench, 0, 1, 2.
map() { echo "$1-$(passes "$1")"; }
other() { echo "$1-other-$(($(passes "$1") / 4))"; }
for scene in $scenes; do
    render "$scene" "$(map "$scene")" --seed 1000001 --passes "$(passes "$scene")"
    render "$scene" "$(other "$scene")" --seed 1000002 --passes $(($(passes "$scene") / 4))
    render "$scene" "$scene-paths1-$samples" --seed 1000003 --reference --passes "$samples"
    render "$scene" "$scene-paths2-$samples" --seed 1000004 --reference --passes "$samples"
done

# What the references are worth: SCENE NOISE COMMON DEVIATION MEAN SPREAD, where MEAN is that of both pictures of the
# path tracer over the reference's, and SPREAD half of what these differ by.
for scene in $scenes; do
    reference=$out/$(map "$scene").exr
    paths1=$out/$scene-paths1-$samples.exr
    paths2=$out/$scene-paths2-$samples.exr
    # relMSE is the other's noise and the reference's own; the other has a quarter of the passes and so at least twice
    # the noise: a third of the sum, at most, is the reference's
    noise=$("$joton" compare "$out/$(other "$scene").exr" "$reference" | awk '{ printf "%.3e", $2 / 3 }')
    {
        "$joton" compare "$paths1" "$reference" --twin "$paths2"
        "$joton" compare "$paths2" "$reference"
    } | awk -v scene="$scene" -v noise="$noise" '
        $1 == "relMSE" { mean[++n] = ($(NF - 2) + $(NF - 1) + $NF) / 3 }
        $1 == "in" { common = $3; deviation = $5 }
        END {
            spread = (mean[1] - mean[2]) / 2
            if (spread < 0) spread = -spread
            printf "%s %s %s %s %.5f %.5f\n", scene, noise, common, deviation, (mean[1] + mean[2]) / 2, spread
        }'
done >"$out/references.txt"

say "measuring, $seeds seeds"
load=$(awk '{ print $1 }' /proc/loadavg 2>/dev/null || echo unknown)
set --
for scene in $scenes; do
    set -- "$@" "scenes/$scene.toml" --reference "$out/$(map "$scene").exr"
done
"$joton" bench "$@" --size "$size" --device gpu --device cpu --device cpu-reference --cpu-seconds --times "$times" \
    --seeds "$seeds" -o "$out/bench"
cp "$out/bench.svg" "$chart"
cp "$out/bench.csv" "$rows"

# relMSE at the CPU seconds that are wanted, between the steps by the logarithms, mean of the seeds:
# SCENE DEVICE RELMSE RELMSE RELMSE SPREAD; - is no picture yet, SPREAD the largest distance of a seed from the mean.
awk -v wanted="$wanted" '
    { gsub(/"[^"]*"/, "quoted"); count = split($0, cell, ",") }
    NR == 1 { for (i = 1; i <= count; i++) column[cell[i]] = i; next }
    {
        key = cell[column["scene"]] " " cell[column["device"]]
        seed = cell[column["seed"]]
        if (!(key in seeds)) { keys[++number] = key; seeds[key] = 0 }
        if (!((key, seed) in steps)) { seeds[key]++; order[key, seeds[key]] = seed }
        n = ++steps[key, seed]
        time[key, seed, n] = cell[column["cpu_seconds"]]
        error[key, seed, n] = cell[column["rel_mse"]]
    }
    function at(key, seed, t,    n, share) {
        for (n = 2; n <= steps[key, seed]; n++) {
            if (time[key, seed, n - 1] <= t && t <= time[key, seed, n]) {
                share = log(t / time[key, seed, n - 1]) / log(time[key, seed, n] / time[key, seed, n - 1])
                return exp((1 - share) * log(error[key, seed, n - 1]) + share * log(error[key, seed, n]))
            }
        }
        return -1
    }
    END {
        split(wanted, moment, " ")
        for (k = 1; k <= number; k++) {
            key = keys[k]
            line = key
            spread = 0
            for (w = 1; w <= 3; w++) {
                sum = 0
                for (s = 1; s <= seeds[key]; s++) {
                    found[s] = at(key, order[key, s], moment[w])
                    if (found[s] < 0) { sum = -1; break }
                    sum += found[s] / seeds[key]
                }
                line = line " " (sum < 0 ? "-" : sum)
                for (s = 1; sum > 0 && s <= seeds[key]; s++) {
                    off = found[s] / sum - 1
                    if (off < 0) off = -off
                    if (off > spread) spread = off
                }
            }
            print line, spread
        }
    }' "$out/bench.csv" >"$out/figures.txt"

# How a machine is told.
system=$(sed -n 's/^PRETTY_NAME="\(.*\)"$/\1/p' /etc/os-release 2>/dev/null || true)
processor=$(sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo 2>/dev/null | head -n 1 || true)
machine="$(getconf _NPROCESSORS_ONLN) processor cores (${processor:-$(uname -m)}), ${system:-$(uname -s)}"
commit=$(git rev-parse --short HEAD 2>/dev/null || echo unknown)
[ -z "$(git status --porcelain -- src shaders scenes 2>/dev/null)" ] || commit="$commit and changes"
today=$(date +%Y-%m-%d)

# Functions for numbers in tables.
numbers='
    function short(x,    text) {
        if (x == "-") return "–"
        text = x >= 0.1 && x < 1000 ? sprintf("%.2g", x) : sprintf("%.1e", x)
        sub(/e-0/, "e-", text)
        sub(/e[+]0?/, "e", text)
        return text
    }'

{
    echo "![Error over CPU seconds for three scenes: joton on software Vulkan, joton on the CPU, path tracer](docs/images/figures.svg)"
    echo
    echo "relMSE after $(echo "$wanted" | sed 's/ / · /g') CPU seconds of all threads while rendering, $size pixels, mean of $seeds seeds:"
    echo
    echo "| scene | joton, gpu (software Vulkan) | joton, cpu | path tracer | the reference's own error |"
    echo "|---|---|---|---|---|"
    for scene in $scenes; do
        awk -v scene="$scene" -v name="$(name "$scene")" "$numbers"'
            FNR == NR && $1 == scene { own = $2; if ($3 > 2 * $4 && $3 > own) own = $3 }
            FNR != NR && $1 == scene {
                cell[$2] = short($3) " · " short($4) " · " short($5)
                if ($5 != "-" && (least == "" || $5 + 0 < least)) least = $5 + 0
            }
            END {
                printf "| [%s](scenes/%s.toml) | %s | %s | %s | ", name, scene, cell["gpu"], cell["cpu"], cell["cpu-reference"]
                printf "%s%s |\n", short(own), (own * 10 > least ? " \\*" : "")
            }' "$out/references.txt" "$out/figures.txt"
    done
    echo
    awk -v today="$today" -v commit="$commit" -v machine="$machine" -v device="$device" -v load="$load" "$numbers"'
        FNR == NR { own[$1] = $2; if ($3 > 2 * $4 && $3 > own[$1]) own[$1] = $3; next }
        { if ($6 > spread[$2]) spread[$2] = $6; if ($5 != "-" && own[$1] * 10 > $5) near = 1 }
        END {
            printf "%s, commit %s, `sh scripts/figures.sh`,\n%s.\n", today, commit, machine
            printf "*gpu* is software Vulkan on the same cores, %s.\nLoad average at the start: %s. – is no picture yet.\n", device, load
            printf "A seed is off the mean by up to %.0f %% (*gpu*), ", 100 * spread["gpu"]
            printf "%.0f %% (*cpu*), %.0f %% (path tracer).\n", 100 * spread["cpu"], 100 * spread["cpu-reference"]
            if (near) print "\\* is more than a tenth of the smallest figure beside it: that much of it may be error of the reference."
        }' "$out/references.txt" "$out/figures.txt"
} >"$out/table.md"
between figures "$readme" "$out/table.md"

{
    echo "| scene | passes | CPU seconds | noise, at most | error by the path tracer | mean of the path tracer |"
    echo "|---|---|---|---|---|---|"
    while read -r scene noise common deviation mean spread; do
        awk -v name="$(name "$scene")" -v passes="$(passes "$scene")" -v seconds="$(cpu_seconds "$(map "$scene")")" \
            -v noise="$noise" -v common="$common" -v deviation="$deviation" -v ratio="$mean ± $spread" "$numbers"'
            BEGIN {
                sign = common < 0 ? "−" : ""
                if (common < 0) common = -common
                printf "| %s | %d | %d | %s | %s%s ± %s | %s |\n", name, passes, seconds, short(noise), sign, short(common), short(deviation), ratio
            }'
    done <"$out/references.txt"
    echo
    total=$(cat "$out"/*-*.json | awk -F '[:,]' '/"cpu_seconds"/ { sum += $2 } END { printf "%.0f", sum / 60 }')
    echo "$size pixels, $samples samples a pixel in each picture of the path tracer; all pictures took $total minutes of a core."
} >"$out/references.md"
between references "$page" "$out/references.md"
rm -f "$out/device.json" "$out/device.png"
say "done: $readme, $page, $chart, $rows"
