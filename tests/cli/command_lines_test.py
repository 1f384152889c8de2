"""Every row of command_lines.txt, as text and with --json.  python3 command_lines_test.py GANTRY"""
import concurrent.futures, json, os, shlex, shutil, subprocess, sys, tempfile

gantry = os.path.abspath(sys.argv[1])
here = os.path.dirname(os.path.abspath(__file__))
root = os.path.dirname(os.path.dirname(here))
PATIENCE_S = 60


def files_in(folder):
    def write(name, content):
        with open(os.path.join(folder, name), "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())

    for name in ("folder", "full/recipes", "states"):
        os.makedirs(os.path.join(folder, name))
    write("recipe.yaml", """version: 1
recipe: one-dot
placement: fixture
board: {size: [90 mm, 60 mm], thickness: 8 mm, frame: pallet}
materials:
  a: {speed: 15 mm/s, gap: 0.8 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 12 ms, retract: 3 mm}
features:
  - dot: {name: d, material: a, at: [30 mm, 30 mm]}
""")
    write("full/recipes/demo-board.yaml", "mine")
    write("empty.yaml", "")
    write("bytes.yaml", b"\xff\xfe\x00")
    write("list.yaml", "- {at: cycle 1, do: stall}\n")
    body = {"name": "tip", "type": "sphere", "center": [0, 0, 0], "radius": 1}
    write("scene.json", json.dumps({"workspace_tip": {"min": [0, 0, 0], "max": [100, 100, 100]},
                                    "required_clearance_mm": 1, "head": [body], "obstacles": []}))
    write("queries.json", json.dumps([{"id": 1, "start": [1, 1, 1], "goal": [9, 9, 9]}]))
    shutil.copy(os.path.join(root, "config/machines/dispenser.yaml"), os.path.join(folder, "machine.yaml"))


def rows_of(table):
    for number, line in enumerate(open(table), 1):
        if line.strip() and not line.startswith("#"):
            code, words, piece = (part.strip() for part in line.rstrip("\n").split(" |", 2))
            yield number, int(code), words, piece


def run(words, folder):
    environment = {**os.environ, "GANTRY_STATE": os.path.join(folder, "nobody")}
    return subprocess.run([gantry, *words], cwd=folder, env=environment, text=True, capture_output=True,
                          stdin=subprocess.DEVNULL, timeout=PATIENCE_S)


def judge(row, folder):
    """What is wrong with it, as text."""
    number, code, words, piece = row
    words = shlex.split(words.replace("DIR/state", f"DIR/states/{number}").replace("DIR/", folder + "/"))
    piece = piece.replace("DIR/", folder + "/")
    wrong = []
    try:
        told, document = run(words, folder), run(["--json", *words], folder)
    except subprocess.TimeoutExpired:
        return [f"line {number}: it goes on for {PATIENCE_S} s"]
    if told.returncode != code:
        wrong.append(f"exit {told.returncode} instead of {code}: {told.stderr[-300:]}")
    if piece not in told.stderr:
        wrong.append(f"no '{piece}' in: {told.stderr[-300:]}")
    if told.stderr.count("    remedy: ") != 1:
        wrong.append(f"{told.stderr.count('    remedy: ')} messages: {told.stderr[-400:]}")
    if told.stdout and "board is untouched" not in told.stdout:
        wrong.append(f"something on stdout: {told.stdout[:200]}")
    try:
        said = json.loads(document.stdout)
        if not document.returncode == said["exit_code"] == code:
            wrong.append(f"with --json exit {document.returncode}, in the document {said['exit_code']}, not {code}")
        if len(said["errors"]) != 1 or piece not in said["errors"][0]["where"] + ": " + said["errors"][0]["message"]:
            wrong.append(f"with --json: {json.dumps(said['errors'])[:400]}")
    except (ValueError, KeyError, TypeError):
        wrong.append(f"with --json no document: {document.stdout[-200:]}{document.stderr[-200:]}")
    return [f"line {number}: gantry {row[2]}: {each}" for each in wrong]


def main():
    rows = list(rows_of(os.path.join(here, "command_lines.txt")))
    with tempfile.TemporaryDirectory() as folder:
        files_in(folder)
        before = sorted(os.listdir(folder))
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            wrong = [each for found in pool.map(lambda row: judge(row, folder), rows) for each in found]
        left = [name for name in sorted(os.listdir(folder)) if name not in before + ["nobody"]]
        if left:
            wrong.append(f"left in the folder: {left}")
    for each in wrong:
        print("FAILED:", each)
    print(f"{len(rows)} command lines, {len(wrong)} mistakes")
    return 1 if wrong or len(rows) < 90 else 0


sys.exit(main())
