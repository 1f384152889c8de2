#!/usr/bin/env bash
# A cable between an owner and a virtual machine that stands still, is started again, or is wanted by a second owner.
source "$(dirname "$0")/lib.sh"
machine=$(patient_machine)
name=gcab$$
if ! scripts/veth-pair up $name >"$work/pair" 2>&1; then
  cat "$work/pair"
  [ "$(id -u)" = 0 ] && exit 1
  echo "only root may make a veth pair: nothing to test"
  exit 77
fi
trap 'ip netns pids $name 2>/dev/null | xargs -r kill; scripts/veth-pair down $name >/dev/null 2>&1; finish' EXIT
scripts/veth-pair exec $name -- python3 tests/cli/cable_test.py "$gantry" "$machine" $name "$work" || failures=$((failures + 1))
