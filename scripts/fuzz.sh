#!/bin/sh
# Fuzz: gives the readers bytes that nobody thought of, one target after the other (fuzz/, docs/RELIABILITY.md).
#   sh scripts/fuzz.sh [SECONDS [TARGET…]]     SECONDS for each target, 1200 by default
#   sh scripts/fuzz.sh --keep                  puts a part of what was found, that reaches most, into tests/corpus/
# Needs nightly Rust and cargo-fuzz (cargo install cargo-fuzz --locked). What is found stays in fuzz/corpus/ and is gone on with the next
# time; an input that finds a fault is in fuzz/artifacts/TARGET/. Logs: fuzz/logs/TARGET.log; a line for each run: fuzz/logs/summary.log.
# Status 1 where a fault was found.
set -u
cd "$(dirname "$0")/.." || exit 2

say() { printf 'fuzz: %s\n' "$*"; }
all="paths obj mtl scene pack checkpoint exr"
# an input takes less than so many seconds and MiB, whatever it says
limits="-timeout=10 -rss_limit_mb=2048"
# bytes: long enough for every statement there is, short enough that a small file is what takes long
length() {
    case $1 in
    paths) echo 300 ;;
    mtl | scene) echo 1024 ;;
    obj | pack) echo 2048 ;;
    *) echo 4096 ;;
    esac
}

# of the files of a folder at most so many, of every length alike
most=64
spread() {
    find "$1" -type f -printf '%s %p\n' | sort -n | cut -d ' ' -f 2 >"$scratch/files"
    awk -v all="$(wc -l <"$scratch/files")" -v most="$most" \
        'all <= most || int(NR * most / all) > int((NR - 1) * most / all)' "$scratch/files"
}

cargo +nightly fuzz --version >/dev/null 2>&1 || {
    say "cargo-fuzz or nightly Rust is missing: rustup toolchain install nightly; cargo install cargo-fuzz --locked" >&2
    exit 2
}
# joton forbids unsafe code: what sanitizers look for cannot be in it, and without them three times as much is tried
cargo +nightly fuzz build -O -s none || exit 2
bin=fuzz/target/$(rustc +nightly -vV | sed -n 's/^host: //p')/release
mkdir -p fuzz/logs
# the readers read files: in memory, where there is such a folder
[ -d /dev/shm ] && export TMPDIR=/dev/shm
export RAYON_NUM_THREADS=1
scratch=$(mktemp -d) || exit 2
trap 'rm -rf "$scratch"' EXIT
trap 'exit 130' INT TERM

if [ "${1:-}" = --keep ]; then
    for target in $all; do
        mkdir -p "$scratch/$target" "fuzz/corpus/$target"
        # edges alone: a loop that runs more often is not worth a file
        # shellcheck disable=SC2086 # limits are words
        "$bin/$target" $limits -set_cover_merge=1 -use_counters=0 -max_len="$(length "$target")" "$scratch/$target" \
            "tests/corpus/$target" "fuzz/corpus/$target" >"fuzz/logs/$target.keep.log" 2>&1 || exit 1
        # those that found faults stay, whatever they reach, and those that were written by hand
        find "tests/corpus/$target" -type f | grep -E '/[0-9a-f]{40}$' | xargs rm -f
        spread "$scratch/$target" | xargs -I '{}' cp '{}' "tests/corpus/$target/"
        say "$target: $(find "tests/corpus/$target" -type f | wc -l) files, $(cat "tests/corpus/$target"/* | wc -c) bytes"
    done
    exit 0
fi

seconds=${1:-1200}
[ $# -gt 0 ] && shift
found=
# shellcheck disable=SC2086 # names are words
[ $# -gt 0 ] || set -- $all
for target in "$@"; do
    mkdir -p "fuzz/corpus/$target" "fuzz/artifacts/$target"
    dict=
    [ -e "fuzz/dict/$target.dict" ] && dict=-dict=fuzz/dict/$target.dict
    log=fuzz/logs/$target.log
    # shellcheck disable=SC2086 # limits are words
    (
        "$bin/$target" $limits $dict -max_len="$(length "$target")" -max_total_time="$seconds" -print_final_stats=1 \
            -artifact_prefix="fuzz/artifacts/$target/" "fuzz/corpus/$target" "tests/corpus/$target" >"$log" 2>&1
        echo $? >"$scratch/code"
        times >"$scratch/times"
    )
    # minutes and seconds of user and system, of the fuzzer alone
    cpu=$(tail -n 1 "$scratch/times" | sed 's/[ms]/ /g' | awk '{ printf "%.0f", 60 * ($1 + $3) + $2 + $4 }')
    ran=$(awk '/number_of_executed_units/ { print $2 }' "$log")
    reached=$(sed -n 's/.* cov: \([0-9]*\) ft: \([0-9]*\) corp: \([^ ]*\) .*/\1 edges, \2 features, corpus \3/p' "$log" | tail -1)
    line="$(date +%F) $target: ${ran:-?} executions, $cpu CPU s, $reached"
    if [ "$(cat "$scratch/code")" != 0 ]; then
        line="$line; FOUND $(sed -n 's/.*Test unit written to //p' "$log" | tail -1)"
        found=1
    fi
    say "$line" | tee -a fuzz/logs/summary.log
done
[ -z "$found" ] || exit 1
