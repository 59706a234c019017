#!/bin/sh
# A real Slurm for tests, on this machine alone: one controller and two nodes of one CPU each, n1 and n2. Needs root.
#   slurm.sh up DIR             starts it and prints what to export; all of its files lie in DIR, an absolute path
#   slurm.sh up DIR --install   the same, but installs the Debian packages that are missing first
#   slurm.sh down DIR           stops it and kills its jobs; the files stay for a look at DIR/log
# In a script:
#   trap 'slurm.sh down "$dir"' EXIT
#   settings=$(slurm.sh up "$dir") || exit
#   eval "$settings"
#   sbatch --wait --wrap 'echo hello'
# Needs neither cgroups nor a database, so sacct has nothing to tell. Other Slurms of this machine are left alone.
# What a job leaves behind with another parent and an empty environment is not found, neither by Slurm nor by `down`.
set -u
umask 022
PATH=$PATH:/usr/sbin:/sbin
packages="slurmctld slurmd slurm-client munge"

say() { printf 'slurm.sh: %s\n' "$*" >&2; }
fail() {
    say "FAILED: $*"
    exit 1
}
usage() {
    say "usage: slurm.sh up DIR [--install], or slurm.sh down DIR; DIR is an absolute path"
    exit 2
}

missing() {
    for program in munged slurmctld slurmd sbatch scontrol; do
        command -v "$program" >/dev/null 2>&1 || return 0
    done
    return 1
}

install() {
    command -v apt-get >/dev/null 2>&1 || fail "there is no apt-get to install $packages with"
    say "installing $packages"
    # shellcheck disable=SC2086 # several words
    { apt-get -q update && DEBIAN_FRONTEND=noninteractive apt-get -qy install --no-install-recommends $packages; } \
        >"$dir/log/install" 2>&1 </dev/null || fail "apt-get: $(tail -n 5 "$dir/log/install")"
}

# Whether a socket of this machine has the port $1, in the state $2 if given (0A: it listens).
in_use() { cat /proc/net/tcp /proc/net/tcp6 2>/dev/null | grep -qE "^ *[0-9]+: [0-9A-F]+:$(printf %04X "$1") [^ ]+ ${2:-}"; }

# The next free port after $1, below those that the kernel gives away by itself.
port_after() {
    port=$1
    while
        port=$((port < 31999 ? port + 1 : 20000))
        in_use "$port"
    do :; done
    echo "$port"
}

configure() {
    port_0=$(port_after $((20000 + $(od -An -N2 -tu2 /dev/urandom) % 12000)))
    port_1=$(port_after "$port_0")
    port_2=$(port_after "$port_1")
    host=$(uname -n)
    # Slurm can listen at the address that the host's name has, or at every address. Only the key lets a caller in.
    listen=""
    case $(getent ahostsv4 "$host") in
    "127.0.0.1 "*) listen="CommunicationParameters=NoInAddrAny,NoCtldInAddrAny" ;;
    esac
    host=${host%%.*}
    cat >"$dir/slurm.conf" <<END
ClusterName=$cluster
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port_0
$listen
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
# A requeued job waits for cred_expire seconds. 5 is the least: less is taken for 120.
AuthInfo=socket=$dir/run/munge.socket,cred_expire=5

StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/%n
SlurmctldPidFile=$dir/run/slurmctld.pid
SlurmdPidFile=$dir/run/%n.pid
SlurmctldLogFile=$dir/log/slurmctld
SlurmdLogFile=$dir/log/%n

ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2

SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
# look once a second for jobs that can start
SchedulerParameters=sched_interval=1,batch_sched_delay=1
# seconds from SIGTERM to SIGKILL
KillWait=5
# squeue and scontrol know an ended job for so many seconds
MinJobAge=3600

NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$port_1 CPUs=1
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=$port_2 CPUs=1
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=INFINITE
END
    # v1 does nothing until it is needed; a node that looks for the right one can fail to start, in a container for one
    echo CgroupPlugin=cgroup/v1 >"$dir/cgroup.conf"
}

# start NAME COMMAND...: a daemon out of reach of the terminal. Its environment says whose it is.
start() {
    name=$1
    shift
    SLURM_SH_DIR=$dir SLURM_CONF=$dir/slurm.conf setsid "$@" </dev/null >"$dir/log/$name.start" 2>&1 &
    started="$started $!"
}

# Waits until the command given is true. False if a daemon ends, or after 30 seconds.
await() {
    tries=600
    until "$@"; do
        [ $((tries -= 1)) -gt 0 ] || return
        for pid in $started; do
            kill -0 "$pid" 2>/dev/null || return
        done
        sleep 0.05
    done
}

nodes_idle() { [ "$(SLURM_CONF=$dir/slurm.conf sinfo -h -N -o %t 2>/dev/null | tr '\n' ' ')" = "idle idle " ]; }

# false if they do not come up
launch() {
    started=""
    rm -f "$dir/run/munge.socket"
    start munged munged --foreground --socket="$dir/run/munge.socket" --key-file="$dir/run/munge.key" \
        --pid-file="$dir/run/munged.pid" --seed-file="$dir/run/munged.seed" --log-file="$dir/log/munged"
    await [ -S "$dir/run/munge.socket" ] || return
    start slurmctld slurmctld -D -f "$dir/slurm.conf"
    # a node or a client that comes too early sleeps for a second
    await in_use "$port_0" 0A || return
    for node in n1 n2; do
        mkdir -p "$dir/$node"
        start "$node" slurmd -D -N "$node" -f "$dir/slurm.conf"
    done
    await in_use "$port_1" 0A && await in_use "$port_2" 0A && await nodes_idle
}

# The daemons and the tasks, which their environment tells, with all that they started, and the clients that wait for them.
processes() {
    {
        grep -lszxF -e "SLURM_SH_DIR=$dir" -e "SLURM_CLUSTER_NAME=$cluster" /proc/[0-9]*/environ
        grep -lszxF "SLURM_CONF=$dir/slurm.conf" /proc/[0-9]*/environ | sed 's/environ/user/'
        grep -s -e '^Name:' -e '^PPid:' /proc/[0-9]*/status
    } | awk -F '[/:\t]+' '
        $4 == "environ" { ours[$3] = 1 }
        $4 == "user" { user[$3] = 1 }
        $5 == "Name" { name[$3] = $6 }
        $5 == "PPid" { parent[$3] = $6 }
        END {
            for (p in user) if (name[p] ~ /^(srun|sbatch|salloc)$/) ours[p] = 1
            do {
                found = 0
                for (p in parent) if (!(p in ours) && parent[p] in ours) found = ours[p] = 1
            } while (found)
            for (p in ours) print p
        }'
}

stop() {
    tries=200
    while pids=$(processes) && [ -n "$pids" ]; do
        [ $((tries -= 1)) -gt 0 ] || fail "these processes do not end: $(echo "$pids" | tr '\n' ' ')"
        # shellcheck disable=SC2086 # several numbers
        kill -KILL $pids 2>/dev/null
        sleep 0.05
    done
}

up() {
    [ "$(id -u)" -eq 0 ] || fail "needs root"
    [ ${#dir} -le 80 ] || fail "$dir is too long a path: sockets lie there; give one of at most 80 characters"
    if missing && [ "$1" != --install ]; then
        fail "Slurm is not installed; as root: apt-get install --no-install-recommends $packages (or give --install)"
    fi
    mkdir -p "$dir" || exit
    [ -z "$(ls -A "$dir")" ] || fail "$dir is not empty"
    mkdir "$dir/run" "$dir/log" "$dir/state" || exit
    cluster=test$(od -An -N6 -tx1 /dev/urandom | tr -d ' ')
    echo "$cluster" >"$dir/run/cluster"
    (umask 077 && head -c 1024 /dev/urandom >"$dir/run/munge.key")
    # a daemon just forked is known only a moment later
    trap 'sleep 0.1; stop; exit 130' HUP INT TERM

    if missing; then
        install
        missing && fail "$packages are installed, but not all of their programs are found"
    fi
    attempts=3
    until [ $((attempts -= 1)) -lt 0 ]; do
        configure
        if launch; then
            echo "export SLURM_CONF=$dir/slurm.conf"
            return
        fi
        stop
        # another process may have taken a port in the meantime
        grep -qsi 'address already in use' "$dir"/log/*.start || break
    done
    tail -n 5 "$dir"/log/*.start >&2
    fail "Slurm did not start; see $dir/log"
}

down() {
    [ -f "$dir/run/cluster" ] || return 0
    cluster=$(cat "$dir/run/cluster")
    [ "${SLURM_CLUSTER_NAME:-}" != "$cluster" ] || fail "a job cannot stop its own Slurm"
    stop
}

[ $# -eq 2 ] || [ "$#,${1:-},${3:-}" = 3,up,--install ] || usage
dir=${2%/}
case "$dir" in
/*[!A-Za-z0-9_./+-]*) fail "$dir: only letters, digits and _./+- can be in the path" ;;
/?*) ;;
*) usage ;;
esac
case "$1" in
up) up "${3:-}" ;;
down) down ;;
*) usage ;;
esac
