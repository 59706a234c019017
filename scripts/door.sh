#!/bin/sh
# Door: what a newcomer does, from the README to the first picture.
#   sh scripts/door.sh             in a clean clone, with an empty home and without any crates
#   sh scripts/door.sh --chroot    the same in an empty Debian 12, as root, with debootstrap
# Takes the first block of the README with `cargo run --release`, runs it as it stands, and looks for its pictures. Says
# how many steps (commands) that were, and how many seconds the pictures took. The Rust in use here is the newcomer's, too;
# a C compiler and the packages that the README names are installed in the empty Debian before the clock starts.
# What is not committed is not tried. Downloads every crate, and in the second case the packages.
set -u
cd "$(dirname "$0")/.." || exit 2

say() { printf 'door: %s\n' "$*"; }
fail() {
    say "FAILED: $*" >&2
    exit 1
}

case "$*" in
'') chroot="" ;;
--chroot) chroot=yes ;;
*) fail "$* is not known; give --chroot or nothing" ;;
esac
for tool in git rustc ${chroot:+debootstrap chroot unshare}; do
    command -v "$tool" >/dev/null 2>&1 || fail "$tool is not installed"
done
rust=$(rustc --print sysroot) || fail "rustc does not say where it lies"

scratch=$(mktemp -d) || exit 2
trap 'rm -rf "$scratch"' EXIT
trap 'exit 130' INT TERM

# The first fenced block that runs cargo.
git show HEAD:README.md | awk '
    /^```/ { if (inside && block ~ /cargo run --release/) { printf "%s", block; exit } inside = !inside; block = ""; next }
    inside { block = block $0 "\n" }' >"$scratch/block"
[ -s "$scratch/block" ] || fail "no block of the README has cargo run --release"
steps=$(grep -vc -e '^ *#' -e '^ *$' "$scratch/block")

before="Rust and a C compiler"
if [ -n "$chroot" ]; then
    [ "$(id -u)" -eq 0 ] || fail "an empty Debian needs root"
    root="$scratch/debian"
    # mounts, debootstrap's too, end with their name spaces: nothing but files is left to remove
    # the mirror that apt uses here, where there is apt; debootstrap knows one else
    mirror=$(apt-get indextargets --format '$(SITE)' 2>/dev/null | head -n 1)
    # what the README tells to install with apt-get
    named=$(git show HEAD:README.md | sed -n 's/.*apt-get install \([a-z0-9.+ -]*\)`.*/\1/p' | tr '\n' ' ' | sed 's/ $//')
    before="$before, in a Debian with ${named:-nothing else}"
    say "installing $before"
    packages=$(printf '%s ' gcc libc6-dev ca-certificates $named | sed 's/ $//' | tr -s ' ' ',')
    unshare --mount debootstrap --variant=minbase --include="$packages" bookworm "$root" $mirror \
        >"$scratch/log" 2>&1 || fail "debootstrap: $(tail -n 3 "$scratch/log")"
    mkdir "$root/rust"
    cp -R "$rust/bin" "$rust/lib" "$root/rust/"
    # names and certificates are those of this machine, as on any network
    cp /etc/resolv.conf /etc/hosts "$root/etc/"
    [ ! -s /etc/ssl/certs/ca-certificates.crt ] || cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
    clone="$root/root/joton"
else
    mkdir "$scratch/home"
    clone="$scratch/home/joton"
fi
git clone --quiet . "$clone" || fail "git does not clone"
cp "$scratch/block" "$clone/../block"

run() {
    if [ -n "$chroot" ]; then
        unshare --mount sh -c 'mount -t proc proc "$1/proc" && exec chroot "$1" env -i HOME=/root \
            PATH=/rust/bin:/usr/bin:/bin sh -c "cd /root/joton && sh -e ../block"' door "$root"
    else
        (cd "$clone" && env -i HOME="$scratch/home" PATH="$rust/bin:/usr/bin:/bin" sh -e ../block)
    fi
}

say "running:"
cat "$scratch/block"
begin=$(date +%s)
run || fail "the README's commands end with status $?"
seconds=$(($(date +%s) - begin))

# A clean clone has no pictures beside its README.
pictures=$(cd "$clone" && git ls-files --others -- ':(glob)*.png' ':(glob)*.exr')
[ -n "$pictures" ] || fail "there is no picture"
for picture in $pictures; do
    [ -s "$clone/$picture" ] || fail "$picture is empty"
    say "$picture: $(wc -c <"$clone/$picture") bytes"
done
say "before: $before"
say "steps: $steps, seconds to the pictures: $seconds"
