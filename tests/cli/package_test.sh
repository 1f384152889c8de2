#!/usr/bin/env bash
# The Debian package: what stands in it, by dpkg's own tools; its program runs from where it is unpacked, and its service asks for
# no more rights than it needs, and for those.
source "$(dirname "$0")/lib.sh"
command -v dpkg-shlibdeps >/dev/null || { echo "no dpkg-shlibdeps: nothing to test"; exit 77; }

scripts/package --no-build "$work/deb" >"$work/out" 2>"$work/err" && echo "ok: packaged" || fail "$(cat "$work/err")"
deb=$(tail -1 "$work/out")
[ -s "$deb" ] || { fail "there is no package '$deb'"; exit; }

field() { dpkg-deb --field "$deb" "$1"; }
[ "$(field Package)" = gantry ] && [ "$(field Architecture)" = "$(dpkg --print-architecture)" ] || fail "another package or architecture"
commit=$("$gantry" --version | sed -E 's/.*\(([0-9a-f]*).*/\1/')
[[ "$(field Version)" == *"$commit"* ]] || fail "version $(field Version) does not name commit $commit"
dpkg --validate-version "$(field Version)" || fail "no valid version"
# Every library that the program asks for belongs to a package that it depends on.
field Depends | tr ',' '\n' | sed -E 's/^ *([^ ]+).*/\1/' >"$work/depends"
objdump -p "$gantry" | awk '/NEEDED/ {print $2}' | while read -r library; do
  path=$(ldd "$gantry" | awk -v l="$library" '$1 == l {print $3}')
  [ -n "$path" ] || continue
  path=$(realpath "$path")
  owner=$(dpkg -S "$path" "${path#/usr}" 2>/dev/null | head -1 | cut -d: -f1)
  # By its name, or by one that it provides.
  names=$(echo "$owner"; dpkg-query -W -f='${Provides}' "$owner" | tr ',' '\n' | sed -E 's/^ *([^ ]+).*/\1/')
  grep -qxF "$names" "$work/depends" || echo "$library of $owner"
done >"$work/missing"
[ -s "$work/missing" ] && fail "the package does not depend on: $(cat "$work/missing")"

dpkg-deb --contents "$deb" >"$work/contents"
for file in usr/bin/gantry usr/share/gantry/config/machines/dispenser.yaml usr/share/gantry/config/drives/std402ec.yaml \
  usr/share/gantry/recipes/demo-board.yaml usr/share/gantry/config/schema/machine.schema.json usr/share/doc/gantry/copyright \
  usr/share/doc/gantry/docs/operating.md usr/lib/systemd/system/gantry.service etc/default/gantry etc/security/limits.d/gantry.conf \
  usr/share/man/man1/gantry.1.gz usr/share/bash-completion/completions/gantry; do
  grep -qE " \./$file\$" "$work/contents" || fail "$file is not in the package"
done
awk '$2 != "root/root"' "$work/contents" | grep . && fail "files of another user than root"
grep -E '^.....w|^........w' "$work/contents" | grep -v '^l' && fail "files that others may write"
grep -E '^-..s|^-.....s' "$work/contents" && fail "files with a setuid or setgid bit"

dpkg-deb --raw-extract "$deb" "$work/at" && gantry=$work/at/usr/bin/gantry
for script in postinst prerm postrm; do sh -n "$work/at/DEBIAN/$script" || fail "$script is no shell script"; done
grep -qE 'systemctl (start|enable)' "$work/at/DEBIAN/postinst" && fail "installing starts the machine"
for file in $(cat "$work/at/DEBIAN/conffiles"); do [ -f "$work/at$file" ] || fail "conffile $file is not there"; done
(cd "$work/at" && md5sum --quiet -c DEBIAN/md5sums) || fail "wrong checksums"
cd "$work" || exit 1
expect_exit 0 "the packaged program in a dry run" "$gantry" dry-run "$work/at/usr/share/gantry/recipes/demo-board.yaml" --out "$work/job"
grep -q "$source_dir/" "$work/job/summary.json" && fail "the job's summary names the source tree"
expect_exit 0 "and its init" "$gantry" init "$work/mine"
expect_exit 0 "whose machine is right" "$gantry" --machine "$work/mine/config/machines/dispenser.yaml" check "$work/mine/recipes/demo-board.yaml"

unit=$work/at/usr/lib/systemd/system/gantry.service
setting() { sed -n "s/^$1=//p" "$unit"; }
[ "$(setting User)" = gantry ] || fail "the service is not the user gantry's"
[ "$(setting AmbientCapabilities)" = "CAP_NET_RAW CAP_SYS_NICE CAP_IPC_LOCK" ] || fail "other capabilities"
[ "$(setting CapabilityBoundingSet)" = "$(setting AmbientCapabilities)" ] || fail "more could be had"
[ "$(setting StateDirectory)" = gantry ] || fail "no state folder"
if command -v systemd-analyze >/dev/null; then
  mkdir -p "$work/systemd" && sed "s,/usr/bin/gantry,$gantry," "$unit" >"$work/systemd/gantry.service"
  systemd-analyze verify "$work/systemd/gantry.service" >"$work/out" 2>&1
  grep -E 'gantry\.service:[0-9]+|Unknown|Failed to parse' "$work/out" && fail "systemd does not understand the service"
fi
# The rights of the service are those that a machine needs.
if [ "$(id -u)" = 0 ] && command -v setpriv >/dev/null; then
  chmod -R a+rX "$work"
  set=+net_raw,+sys_nice,+ipc_lock
  expect_exit 7 "the service's rights, without a state folder of its own" \
    setpriv --reuid 65534 --regid 65534 --clear-groups --no-new-privs --inh-caps=-all,$set --ambient-caps=-all,$set --bounding-set=-all,$set \
    "$gantry" --json doctor --interface lo --state "$work/state"
  python3 - "$work/out" <<'PY' || fail "rights are missing"
import json, sys
levels = {f["name"]: f["level"] for f in json.load(open(sys.argv[1]))["findings"]}
assert all(levels[n] == "ok" for n in ("real-time priority", "locked memory", "raw frames")), levels
PY
fi
# Nothing but the rights of that group are given to people who log in.
[ "$(grep -vc '^#' "$work/at/etc/security/limits.d/gantry.conf")" = 2 ] || fail "other limits"
