#!/usr/bin/env python3
"""Nothing that someone wrote steers a terminal or a page: file names, serials and words of the command line with control
characters (C0, C1), characters that turn the direction of writing, and bytes that are no UTF-8.
   python3 clean_output_test.py GANTRY"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parents[2]
EVIL = b"a\x1b[31mb\xc2\x9b2Jc\xe2\x80\xaed\xe2\x81\xa6e\x07f\xff"
STEERS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")
failures = 0


def fail(what):
    global failures
    failures += 1
    print(f"FAILED: {what}")


def expect_clean(what, data):
    try:
        text = data.decode()
    except UnicodeDecodeError as error:
        return fail(f"{what}: no UTF-8: {error}")
    found = STEERS.search(text)
    if found:
        fail(f"{what}: {found.group()!r} in {text[max(0, found.start() - 60):found.end() + 20]!r}")


def run(gantry, exit_code, *arguments):
    ran = subprocess.run([gantry, *arguments], capture_output=True, timeout=120, stdin=subprocess.DEVNULL)
    what = f"{arguments[0]} {arguments[1]}"
    if ran.returncode != exit_code:
        fail(f"{what}: exit {ran.returncode}, expected {exit_code}: {ran.stderr[-300:]!r}")
    expect_clean(f"{what}: stdout", ran.stdout)
    expect_clean(f"{what}: stderr", ran.stderr)
    return ran


def main():
    gantry = os.path.realpath(sys.argv[1]).encode()
    with tempfile.TemporaryDirectory() as name:
        work = name.encode()
        os.environ["HOME"] = name
        recipe, broken = work + b"/" + EVIL + b".yaml", work + b"/broken-" + EVIL + b".yaml"
        demo = (TOP / "recipes/demo-board.yaml").read_bytes()
        pathlib.Path(os.fsdecode(recipe)).write_bytes(demo)
        pathlib.Path(os.fsdecode(broken)).write_bytes(demo.replace(b"speed: 15 mm/s", b"sped: 15 mm/s"))
        folder = work + b"/job-" + EVIL
        for json_flag in ((), (b"--json",)):
            run(gantry, 0, *json_flag, b"check", recipe)
            run(gantry, 3, *json_flag, b"check", broken)
            run(gantry, 3, *json_flag, b"check", work + b"/none-" + EVIL)
            run(gantry, 3, *json_flag, b"dry-run", broken, b"--out", work + b"/none")
            run(gantry, 2, *json_flag, b"dry-run", recipe, b"--" + EVIL)
            run(gantry, 2, *json_flag, b"dry-run", recipe, b"--only", EVIL, b"--out", work + b"/none")
            run(gantry, 2, *json_flag, b"explain", EVIL)
            run(gantry, 3, *json_flag, b"--machine", work + b"/" + EVIL, b"check")
            run(gantry, 7, *json_flag, b"status", b"--state", work + b"/" + EVIL)
            run(gantry, 2, *json_flag, b"part-removed", b"--serial", EVIL, b"--state", work + b"/" + EVIL[:60])
            run(gantry, 0, *json_flag, b"part-removed", b"--serial", b"A-1", b"--state", work + b"/" + EVIL[:60])
            run(gantry, 2, *json_flag, b"dry-run", recipe, b"--serial", EVIL, b"--out", work + b"/none")
            run(gantry, 0, *json_flag, b"dry-run", recipe, b"--only", b"anchor_left", b"--out", folder, b"--force")
        expect_clean("report.html", pathlib.Path(os.fsdecode(folder + b"/report.html")).read_bytes().replace(b"\t", b" "))
        summary = json.loads(pathlib.Path(os.fsdecode(folder + b"/summary.json")).read_bytes())
        if r"\u001b[31m" not in json.dumps(summary):
            fail("the summary has another name of the recipe")
    print("ok" if failures == 0 else f"{failures} failed")
    return 1 if failures else 0


sys.exit(main())
