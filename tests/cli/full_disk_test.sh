#!/usr/bin/env bash
# A full disk: a job whose results would find no room is refused before anything moves; one that runs goes on, and its
# summary and report survive. On small disks of its own, in a mount namespace that only root can make.
source "$(dirname "$0")/mounts.sh"
[ -n "${GANTRY_APART:-}" ] || { "${with_mounts[@]}" true 2>/dev/null || { echo "no mount namespace: nothing to test"; exit 77; }
                                exec env GANTRY_APART=1 "${with_mounts[@]}" bash "$0" "$@"; }
source "$(dirname "$0")/lib.sh"
demo=recipes/demo-board.yaml
disk() { mkdir -p "$work/$1" && mount -t tmpfs -o "size=$2" none "$work/$1" || { echo "no tmpfs: nothing to test"; exit 77; }; }
trap 'umount "$work"/disk-* 2>/dev/null; finish' EXIT

for size in 40k 900k 2300k; do
  disk "disk-$size" $size
  expect_exit 1 "a disk of $size" "$gantry" dry-run $demo --out "$work/disk-$size/j"
  expect_text "the disk has [0-9.]* MB free, and the results of this job need up to [0-9.]* MB; take old results away, or let .--out. name"
  grep -q "homing" "$work/err" && fail "$size: it homed"
  grep -q "report" "$work/out" && fail "$size: a report is named that is not there"
  [ -z "$(ls -A "$work/disk-$size")" ] || fail "$size: something was left: $(ls -A "$work/disk-$size")"
done

# It fills up as soon as the job has begun.
disk disk-fills 30m
(until [ -e "$work/disk-fills/j/setpoints.bin" ]; do :; done; head -c 100M /dev/zero >"$work/disk-fills/filled" 2>/dev/null) &
expect_exit 0 "a disk that fills while the job runs" "$gantry" dry-run $demo --out "$work/disk-fills/j"
wait $!
[ "$(stat -c %s "$work/disk-fills/filled")" -gt 20000000 ] || fail "it was not full"
expect_text "setpoints.bin is not kept: .*No space left on device"
grep -q "^  not kept  " "$work/out" && grep -q "^  .* setpoints.bin: .*No space left on device" "$work/out" || fail "the result does not say what is not kept"
expect_text "VIRTUAL: done: 35 of 35"
expect_text "report  *$work/disk-fills/j/report.html"
[ -s "$work/disk-fills/j/report.html" ] || fail "no report"
[ ! -e "$work/disk-fills/j/setpoints.bin" ] || fail "half a stream is left"
python3 - "$work/disk-fills/j/summary.json" <<'PY' || fail "the summary did not survive"
import json, sys
s = json.load(open(sys.argv[1]))
assert s["result"] == "done" and s["board"] == "whole" and s["exit_code"] == 0, s["result"]
assert "setpoints.bin" in [f["file"] for f in s["not_kept"]], s["not_kept"]
assert "report.html" in s["files"] and "setpoints.bin" not in s["files"], s["files"]
PY

# A simulated world that is to be kept there, also one that a killed program has left with its room as a hole.
disk disk-world 300k
mkdir "$work/disk-world/w"
for left in 0 64M; do
  truncate -s $left "$work/disk-world/w/world.log"
  head -c 400K /dev/zero >"$work/disk-world/filled" 2>/dev/null && fail "the disk is not full"
  expect_exit 1 "a full disk under a kept world" "$gantry" dry-run $demo --sim-state "$work/disk-world/w" --out "$work/j$left"
  expect_text "no room for the world's log: No space left on device; it needs 64 KiB"
  rm "$work/disk-world/filled"
done

# One on which the job's records have no room.
disk disk-little 300k
expect_exit 0 "a small disk under a kept world" "$gantry" dry-run $demo --sim-state "$work/disk-little/w" --out "$work/jl"
expect_text "world.log: the world's log was full: [0-9]* records of the last board are not remembered"
