#!/bin/bash
# check_deb.sh FOLDER: the Debian packages in FOLDER (tandem_*.deb, tandem-dev_*.deb), as a user of them would try them: install,
# demo, window, example, purge. To be run as root on a Debian that may be changed, such as a container or a fresh chroot; not a
# test of the suite. The window needs xvfb, which this script installs beside them.
set -euo pipefail
source "$(dirname "$0")/dead_links.sh"
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
shopt -s nullglob
folder=$(realpath "$1")
tandem=("$folder"/tandem_*.deb) development=("$folder"/tandem-dev_*.deb)
[[ ${#tandem[@]} = 1 && ${#development[@]} = 1 ]] || { echo "no two packages in $folder"; exit 2; }
say() { echo "=== $*"; }
fail() { echo "FAULT: $*"; exit 1; }
work=$(mktemp -d)
chmod 755 "$work"
trap 'rm -rf "$work"' EXIT
cp "${tandem[0]}" "${development[0]}" "$work"
cd "$work"

files() { # everything but what is volatile, and what dpkg and apt note for themselves
  find / -xdev \( -path /proc -o -path /sys -o -path /dev -o -path /run -o -path /tmp -o -path "$work" -o -path "$folder" -o \
    -path /var/lib/dpkg -o -path /var/lib/apt -o -path /var/cache -o -path /var/log -o -path /root \) -prune -o -print | sort
}
missing_libraries() { ldd /usr/bin/tandem /usr/bin/tandem-view /usr/bin/tandem-bench 2>/dev/null | grep 'not found'; }

say "install tandem alone, and nothing but what it depends on"
apt-get -q update >/dev/null
apt-get -qq -y install --no-install-recommends ./tandem_*.deb >install.log 2>&1 || { tail -40 install.log; fail "apt-get install"; }
! missing_libraries || fail "libraries are missing"
tandem --version
tandem-view --version
tandem bench points --scene peg_in_slot --voxel 0.004 --rounds 1 >/dev/null
[[ ! -e /etc/systemd/system/multi-user.target.wants/tandem-relay.service ]] || fail "the relay's service is enabled"

say "documents"
dead=$(dead_links /usr/share/doc/tandem)
[[ ! $dead ]] || fail "links that lead nowhere: $dead"
[[ -f /usr/share/doc/tandem/docs/using.md ]] || fail "the guide is not installed"

say "an ordinary user: demo, keys, a secured session"
useradd --create-home tester
as_tester() { runuser -u tester -- env -i HOME=/home/tester USER=tester PATH=/usr/bin:/bin LC_ALL=C.UTF-8 "$@"; }
cd /home/tester
as_tester tandem demo --headless --json >"$work/demo.json" 2>"$work/demo.log" || { cat "$work/demo.log"; fail "tandem demo --headless"; }
tail -3 "$work/demo.log"
as_tester tandem keys session KEYS >/dev/null
as_tester tandem keys viewer KEYS vic >/dev/null
as_tester tandem keys peer KEYS anna >/dev/null
as_tester tandem peer --session S --scene peg_in_slot --hold peg --secure KEYS/anna --seconds 10 >"$work/peer.log" 2>&1 &
peer=$!
as_tester tandem watch --session S --secure KEYS/vic --seconds 8 >"$work/watch.log" 2>&1 &&
  grep 'is secured' "$work/watch.log" || fail "no secured session: $(cat "$work/watch.log" "$work/peer.log")"
wait "$peer" || fail "the secured peer: $(cat "$work/peer.log")"

say "the window"
apt-get -qq -y install --no-install-recommends xvfb xauth >"$work/xvfb.log" 2>&1 || fail "xvfb"
# abstract sockets are shared with the machine outside of a chroot: a number that nobody else takes
as_tester xvfb-run -a -n 250 tandem view --scene bracket_actuator --screenshot picture.png || fail "tandem view --screenshot: exit $?"
[[ $(stat -c %s picture.png) -gt 20000 ]] || fail "the picture is empty"
cp picture.png "$folder/check_deb.png"

say "man pages, completion"
apt-get -qq -y install --no-install-recommends groff-base bash-completion >/dev/null 2>&1 || fail "groff-base"
[[ $(as_tester bash -c 'source /usr/share/bash-completion/bash_completion; _completion_loader tandem
  COMP_WORDS=(tandem view --screenshot-a); COMP_CWORD=2; _tandem; echo "${COMPREPLY[*]}"') == --screenshot-after ]] ||
  fail "no completion"
page=$(zcat /usr/share/man/man1/tandem-peer.1.gz | groff -man -Tascii -P-cbou)
[[ $page == *--session* ]] || fail "no manual page"

say "the example against tandem-dev, with find_package(Tandem) alone"
apt-get -qq -y install --no-install-recommends "$work"/tandem-dev_*.deb g++ cmake make >"$work/dev.log" 2>&1 ||
  { tail -40 "$work/dev.log"; fail "apt-get install tandem-dev"; }
as_tester cp -r /usr/share/doc/tandem-dev/examples example
as_tester cmake -S example -B built >cmake.log || { cat cmake.log; fail "find_package(Tandem)"; }
as_tester cmake --build built >cmake.log || { cat cmake.log; fail "the example does not build"; }
as_tester built/one_frame example/press.json | tail -1

say "purge leaves nothing"
cd /
userdel --remove tester 2>/dev/null
apt-get -qq -y purge tandem tandem-dev >"$work/purge.log" 2>&1 || { tail -40 "$work/purge.log"; fail "purge"; }
files >"$work/purged" # everything else is still installed
apt-get -qq -y install --no-install-recommends "$work"/tandem_*.deb "$work"/tandem-dev_*.deb >/dev/null 2>&1 || fail "install again"
echo "# changed" >>/etc/default/tandem-relay
comm -13 "$work/purged" <(files) >"$work/added"
apt-get -qq -y purge tandem tandem-dev >"$work/purge.log" 2>&1 || fail "purge"
files >"$work/again"
cmp "$work/purged" "$work/again" || fail "files are left: $(diff "$work/purged" "$work/again")"
left=$(find / -xdev \( -path /proc -o -path /sys -o -path "$work" -o -path "$folder" \) -prune -o -name '*tandem*' -print | grep -v '^/var/cache/\|^/var/log/\|^/root/' || true)
[[ ! $left ]] || fail "left: $left"
echo "$(wc -l <"$work/added") files and folders came and went"
say "all is well"
