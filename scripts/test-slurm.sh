#!/bin/sh
# Test: a render on a cluster comes to the bits of a render on one machine, whatever happens to its tasks. A real Slurm of two nodes runs
# on this machine (scripts/slurm.sh); needs root.
#   sh scripts/test-slurm.sh [--install]     --install: install Slurm's packages where they are missing
# JOTON names the program; without it the release is built. Exit status: 1 where a picture differs or does not come, 3 where Slurm
# does not start.
set -u
here=$(cd "$(dirname "$0")" && pwd)
scene=$here/../scenes/spheres.toml
passes=384
options="--size 32x32 --device cpu --threads 1 --quiet"

say() { printf 'test-slurm: %s\n' "$*"; }
fail() {
    say "FAILED: $*" >&2
    tail -n 5 "$dir"/*/*.log >&2
    exit 1
}

if [ -z "${JOTON:-}" ]; then
    (cd "$here/.." && cargo build --release --quiet) || exit
    JOTON=$here/../target/release/joton
fi
dir=$(mktemp -d) || exit
# munge wants its socket within everybody's reach
chmod 711 "$dir"
trap 'sh "$here/slurm.sh" down "$dir/slurm"; rm -rf "$dir"' EXIT
trap 'exit 130' HUP INT TERM
begin=$(date +%s)
settings=$(sh "$here/slurm.sh" up "$dir/slurm" "$@") || exit 3
eval "$settings"
say "two nodes are ready"
cd "$dir" || exit

# await SECONDS WHAT COMMAND...: until the command is true
await() {
    tries=$(($1 * 10))
    what=$2
    shift 2
    until "$@"; do
        [ $((tries -= 1)) -gt 0 ] || fail "$what does not come"
        sleep 0.1
    done
}
node_of() { scontrol -o show job "$1" | sed -n 's/.* BatchHost=\([^ ]*\).*/\1/p'; }
state() { scontrol -o show job "$1" 2>/dev/null | sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p'; }
is() { [ "$(state "$1")" = "$2" ]; }
# submit NAME: the picture is NAME.exr; sets array and merge
submit() {
    # shellcheck disable=SC2086 # several words
    told=$("$JOTON" slurm "$scene" --tasks 4 --passes $passes --folder "$1" -o "$1.exr" --submit -- $options --every 0.1) ||
        fail "joton slurm"
    array=$(echo "$told" | sed -n 's/job \([0-9]*\) renders.*/\1/p')
    merge=$(echo "$told" | sed -n 's/.*job \([0-9]*\) merges/\1/p')
}
# The joton of a task, by its part
joton_of() { pgrep -f "$1/part-$2.joton"; }
is_kept() { [ -s "$dir/$1/part-$2.joton" ]; }
all_ended() { [ -z "$(squeue -h -j "$1" -t PENDING,RUNNING)" ]; }
same() { cmp "$1.exr" whole.exr || fail "$1.exr is another picture"; }

# shellcheck disable=SC2086 # several words
"$JOTON" render "$scene" --pass-range 0..$passes --checkpoint whole.joton -o whole.exr $options || fail "one machine"
say "one machine is done after $(($(date +%s) - begin)) s"

submit plain
await 60 "the merge of an undisturbed render" is "$merge" COMPLETED
same plain
say "an undisturbed render has the same bits, $(($(date +%s) - begin)) s"

# disturb NAME: the node of a task fails, one task is told that its time is over, and one is requeued. False where one had ended before.
disturb() {
    submit "$1"
    await 60 "the first checkpoint" is_kept "$1" 0
    await 60 "the second checkpoint" is_kept "$1" 1
    # it can take seconds to say that it is done
    scancel --batch --signal=USR1 "${array}_0" &
    node=$(node_of "${array}_1")
    [ -z "$node" ] || scontrol update "nodename=$node" state=down reason=test
    await 60 "the third checkpoint" is_kept "$1" 2
    scontrol requeue "${array}_2"
    await 120 "the merge of a disturbed render" is "$merge" COMPLETED
    same "$1"
    grep -q '"passes": 384' "$1/report.json" || fail "the report says otherwise"
    # only what goes on tells its device: it is not quiet
    [ "$(grep -l "joton: CPU" "$1"/render-[012].log | wc -l)" -eq 3 ]
}
disturb disturbed || disturb again || disturb once-more || fail "not all was disturbed"
say "on a node that failed, out of time, requeued: the same bits, $(($(date +%s) - begin)) s"

# What kills a task fails it and takes the merge with it; the same command again goes on from what the tasks kept.
submit killed
await 60 "a checkpoint to kill at" is_kept killed 0
pid=$(joton_of killed 0) && kill -KILL "$pid"
await 60 "the end of a killed task" is "${array}_0" FAILED
scancel "$merge"
await 120 "the end of the other tasks" all_ended "$array"
submit killed
await 60 "the merge of a render that was killed" is "$merge" COMPLETED
same killed
say "killed and submitted again: the same bits, $(($(date +%s) - begin)) s"
say "all is well"
