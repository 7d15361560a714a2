#!/usr/bin/env bash
# Runs a Rust test binary on an emulated CPU with AVX-512, for machines that have none: a small Linux in Bochs, some eighty times
# slower than the machine itself. Used as cargo's runner by `make avx512`:
#
#   tools/emulate_avx512.sh BINARY [ARGUMENTS...]
#
# Needs (Debian): bochs bochsbios vgabios bochs-term isolinux syslinux-common xorriso cpio busybox-static, and a kernel:
# KERNEL=path, or the newest in /boot (linux-image-cloud-amd64 will do).
set -euo pipefail

fail() {
    echo "make avx512: $1" >&2
    exit 1
}

[ $# -ge 1 ] || fail "no test binary given"
[ "$(uname -sm)" = "Linux x86_64" ] || fail "is for Linux on x86-64"
for tool in bochs script xorriso cpio busybox strip ldd pkill; do
    command -v "$tool" >/dev/null || fail "needs $tool (Debian: bochs bochsbios vgabios bochs-term isolinux syslinux-common xorriso cpio busybox-static)"
done
kernel=${KERNEL:-$(find /boot -name 'vmlinuz-*' 2>/dev/null | sort -V | tail -n 1)}
[ -r "$kernel" ] || fail "needs a Linux kernel: KERNEL=path, or one in /boot (Debian: linux-image-cloud-amd64)"
loader=/usr/lib/ISOLINUX/isolinux.bin
modules=/usr/lib/syslinux/modules/bios
[ -r "$loader" ] && [ -r "$modules/ldlinux.c32" ] || fail "needs a boot loader (Debian: isolinux, syslinux-common)"

root=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
finish() {
    # The emulator is in a session of its own, that of its terminal.
    pkill --full "$work/bochsrc" || true
    rm -rf "$work"
}
trap finish EXIT
trap 'exit 130' INT TERM

# The file system of the small Linux: the test, what it is linked with, and its data where it looks for them.
system=$work/system
mkdir -p "$system"/{bin,dev,proc,tmp} "$system$root" "$work/iso"
cp "$(command -v busybox)" "$system/bin/busybox"
strip -o "$system/bin/test" "$1"
ldd "$1" | grep -o '/[^ ]*' | while read -r library; do
    mkdir -p "$system$(dirname "$library")"
    cp -L "$library" "$system$library"
done
cp -r "$root/testdata" "$system$root/"
shift
printf '%q ' "$@" >"$system/arguments"
cat >"$system/init" <<'END'
#!/bin/busybox sh
/bin/busybox mount -t proc proc /proc
/bin/busybox mount -t devtmpfs dev /dev
cd /tmp
eval "set -- $(/bin/busybox cat /arguments)"
if /bin/busybox grep -q avx512vl /proc/cpuinfo; then
    /bin/test --test-threads=1 "$@" >/dev/ttyS0 2>&1
else
    echo "the emulated CPU has no AVX-512" >/dev/ttyS0
    false
fi
echo "exit status $?" >/dev/ttyS0
# What is written last is still on its way.
/bin/busybox sleep 5
/bin/busybox halt -f
END
chmod +x "$system/init"
(cd "$system" && find . | cpio --create --format=newc --quiet) >"$work/iso/initrd"

# xsavec and xsaves: what Bochs says of their sizes is not what Linux computes, and it would go on without AVX.
cp "$kernel" "$work/iso/vmlinuz"
cp "$loader" "$modules/ldlinux.c32" "$work/iso/"
cat >"$work/iso/isolinux.cfg" <<'END'
DEFAULT test
LABEL test
 KERNEL vmlinuz
 INITRD initrd
 APPEND console=ttyS0 quiet loglevel=1 panic=1 clearcpuid=321,323 mitigations=off nosmp noapic acpi=off pci=off
END
xorriso -as mkisofs -quiet -o "$work/test.iso" -b isolinux.bin -c boot.cat -no-emul-boot -boot-load-size 4 \
    -boot-info-table "$work/iso" 2>/dev/null

cat >"$work/bochsrc" <<END
config_interface: textconfig
display_library: term
megs: 2048
cpu: model=corei7_skylake_x, ips=100000000
romimage: file=/usr/share/bochs/BIOS-bochs-latest
vgaromimage: file=/usr/share/bochs/VGABIOS-lgpl-latest
ata0-master: type=cdrom, path=$work/test.iso, status=inserted
boot: cdrom
com1: enabled=1, mode=file, dev=$work/output
log: $work/log
panic: action=fatal
error: action=ignore
info: action=ignore
END
# Debian's Bochs has a debugger, which waits to be told to go on, and a terminal is all it can draw to.
echo c >"$work/commands"
touch "$work/output"
mkfifo "$work/keys"
exec 3<>"$work/keys"
TERM=xterm script --quiet --flush --command "bochs -q -f '$work/bochsrc' -rc '$work/commands'" /dev/null \
    <&3 >"$work/screen" 2>&1 &
emulator=$!

shown=0
while sleep 1; do
    size=$(stat --format=%s "$work/output")
    if [ "$size" -gt "$shown" ]; then
        tail --bytes=+"$((shown + 1))" "$work/output" | head --bytes="$((size - shown))" | tr -d '\r'
        shown=$size
    fi
    status=$(tr -d '\r' <"$work/output" | sed -n 's/^exit status \([0-9]*\)$/\1/p')
    [ -z "$status" ] || exit "$status"
    kill -0 "$emulator" 2>/dev/null || fail "the emulator ended before the tests did: $(tail -c 300 "$work/log")"
done
