#!/usr/bin/env python3
"""Each program in bench/ that is a script starts: it tells what it measures when asked, with everything imported that it needs.
They run rarely, and by hand; a name that has moved would be noticed on the day of the measurement.
  python3 scripts_start_test.py BENCH"""
import pathlib, subprocess, sys

scripts = [path for path in sorted(pathlib.Path(sys.argv[1]).rglob("*.py")) if path.read_text().startswith("#!")]
failures = 0
for script in scripts:
    asked = subprocess.run([sys.executable, script, "--help"], capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL)
    if asked.returncode or "usage:" not in asked.stdout:
        failures += 1
        print(f"{script}: --help ends with {asked.returncode} and says {(asked.stdout + asked.stderr)[-500:]!r}")
print(f"{len(scripts)} scripts asked, {failures} failed")
sys.exit(failures > 0 or not scripts)
