#!/usr/bin/env bash
# A slice of scripts/campaign-terminal-loss: every kind of loss once, judged by frames and by the world.
source "$(dirname "$0")/lib.sh"
[ "$(id -u)" = 0 ] || { echo "only root may make a veth pair: nothing to test"; exit 77; }
python3 -c 'import pty; pty.openpty()' 2>/dev/null || { echo "skipped: no terminal can be made here"; exit 77; }
scripts/campaign-terminal-loss --runs 6 --seed 7 --gantry "$gantry" || failures=$((failures + 1))
