#!/usr/bin/env bash
# A slice of bench/terminal_loss/campaign.py: terminals that are lost in five ways, judged by the frames on a cable; and a
# kill -9 of everything, which the same judge must not let pass.
source "$(dirname "$0")/lib.sh"
python3 -c 'import pty; pty.openpty()' 2>/dev/null || {
  echo "skipped: no terminal can be made here (mount -t devpts devpts /dev/pts)"
  exit 77
}
campaign() { python3 bench/terminal_loss/campaign.py --gantry "$gantry" "$@"; }
campaign --runs 5 --seed 7
case $? in
  0) ;;
  77) [ "$(id -u)" = 0 ] && fail "root, and no cable" || exit 77 ;;
  *) fail "a terminal that was lost" ;;
esac
campaign --runs 1 --seed 3 --control && fail "the judge sees nothing"
[ "$failures" = 0 ] && echo "ok: five losses, and a control that did not hold"
