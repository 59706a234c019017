#!/bin/sh
# Soak: a long render of the pool on a device. Every ten seconds it notes memory, open files, threads, passes, processor
# seconds and the error estimate. At the end it tells by how much they changed, and fails where one grows.
#   sh scripts/soak.sh [SECONDS [DEVICE [FOLDER]]]      3600 s on --device cpu by default; notes in FOLDER/DEVICE.csv
# JOTON names the program, if it is not target/release/joton; JOTON_SOAK_SCENE the scene.
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-3600} device=${2:-cpu} folder=${3:-target/soak}
joton=${JOTON:-$PWD/target/release/joton}
scene=${JOTON_SOAK_SCENE:-scenes/pool.toml}
[ -d "/proc/$$/fd" ] || { echo "soak: this needs /proc" >&2; exit 2; }
mkdir -p "$folder"
notes=$folder/$device.csv progress=$folder/$device.progress
hertz=$(getconf CLK_TCK)

"$joton" render "$scene" --device "$device" --size 64x64 --time "$seconds" --error 1e-6 --progress json \
    -o "$folder/$device.exr" 2>"$progress" &
job=$!
trap 'kill "$job" 2>/dev/null || :' EXIT
field() { sed -n "s/.*\"$1\":\([-+0-9.e]*\).*/\1/p"; }
echo "seconds,kib,files,threads,passes,cpu_seconds,error_estimate" >"$notes"
begin=$(date +%s)
while sleep 10 && kill -0 "$job" 2>/dev/null; do
    last=$(tail -n 5 "$progress" | grep '"event":"progress"' | tail -n 1) || continue
    [ -n "$last" ] || continue
    kib=$(sed -n 's/VmRSS:[^0-9]*\([0-9]*\).*/\1/p' "/proc/$job/status" 2>/dev/null) || continue
    threads=$(sed -n 's/Threads:[^0-9]*\([0-9]*\).*/\1/p' "/proc/$job/status" 2>/dev/null) || continue
    files=$(find "/proc/$job/fd" -type l 2>/dev/null | wc -l)
    cpu=$(awk -v hz="$hertz" '{ sub(/.*\) /, ""); print ($12 + $13) / hz }' "/proc/$job/stat" 2>/dev/null) || continue
    case ",$kib,$threads,$cpu," in *,,*) continue ;; esac
    echo "$(($(date +%s) - begin)),$kib,$files,$threads,$(echo "$last" | field passes),$cpu,$(echo "$last" | field error_estimate)" >>"$notes"
done
wait "$job"

# after a minute: memory within 1 %, files and threads the same, error falling, processor time of a pass within 10 %
awk -F, -v device="$device" '
    NR == 1 || $1 < 60 { next }
    { n++; time[n] = $1; kib[n] = $2; files[n] = $3; threads[n] = $4; passes[n] = $5; cpu[n] = $6; error[n] = $7 }
    function largest(of, from, to,   i, m) { m = of[from]; for (i = from; i <= to; i++) if (of[i] > m) m = of[i]; return m }
    function mean_error(from, to,   i, s) { for (i = from; i <= to; i++) s += error[i]; return s / (to - from + 1) }
    function of_pass(from, to) { return (cpu[to] - cpu[from]) / (passes[to] - passes[from]) }
    END {
        if (n < 8) { print "soak: too short to tell: more than two minutes are needed"; exit 2 }
        q = int(n / 4)
        first = largest(kib, 1, q); grown = largest(kib, n - q, n) / first - 1
        slower = of_pass(n - q, n) / of_pass(1, 1 + q) - 1
        fallen = mean_error(n - q, n) / mean_error(1, 1 + q)
        printf "%s: %d s, %d passes, %.0f MB, %d files, %d threads\n", device, time[n], passes[n], kib[n] / 1024, files[n], threads[n]
        printf "  memory of the last quarter over the first: %+.2f %%\n", 100 * grown
        printf "  processor time of a pass, likewise: %+.1f %%\n", 100 * slower
        printf "  error estimate, likewise: times %.3f\n", fallen
        bad = grown > .01 || slower > .1 || fallen >= 1 || files[n] > files[1] || threads[n] > threads[1]
        if (bad) print "  NOT FLAT"
        exit bad
    }' "$notes"
