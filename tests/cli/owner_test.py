"""An owner that is up, and what its clients may do to it.  python3 owner_test.py GANTRY FOLDER PROGRAM
GANTRY takes a machine that forgives a slow host; PROGRAM is the program as it is.
Limits of time are generous: what is judged is counted in cycles of the machine, from the answers."""
import json, os, shutil, signal, socket, subprocess, sys, threading, time

from owner_client import OwnerClient

gantry, work, plain = sys.argv[1:4]
recipe = os.path.abspath("tests/cli/short-board.yaml")
state = os.path.join(work, "state")
failed = 0


def expect(what, good, more=""):
    global failed
    print("ok:" if good else "FAILED:", what, "" if good else more)
    failed += not good


class Client(OwnerClient):
    def __init__(self, folder=state):
        super().__init__(folder)


class Owner:
    def __init__(self, *options, environment=None, folder=state, stand=None, gantry=gantry):
        self.log = open(os.path.join(work, "up.log"), "a+")
        self.process = subprocess.Popen([gantry, "up", *(["--state", folder] if folder else []), *options], stdout=self.log,
                                        stderr=self.log, stdin=subprocess.DEVNULL, env=environment, cwd=stand)

    def wait(self, folder=state):
        end = time.monotonic() + 60
        while time.monotonic() < end:
            try:
                if Client(folder).ask(order="status")["state"] not in ("offline",):
                    return self
            except (OSError, ValueError):
                pass
            time.sleep(0.05)
        self.log.seek(0)
        sys.exit("FAILED: no owner came up: " + self.log.read()[-2000:])

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(60)


def program(*words, gantry=gantry, **options):
    return subprocess.run([gantry, *words], capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=240, **options)


def cycle():
    return Client().ask(order="status")["cycle"]


# ---- what the owner is, and whose options are others ----
owner = Owner("--sim-board", "dx=0.5 mm").wait()
who = Client().ask(order="status")["owner"]
expect("the owner names its machine, bus and board", who["bus"] == "sim" and who["board"] == "dx=0.5 mm" and
       os.path.isabs(who["machine"]) and len(who["machine_hash"]) == 16, who)
expect("the state folder is its user's alone", os.stat(state).st_mode & 0o777 == 0o700)
other = os.path.join(work, "other.yaml")
with open(who["machine"]) as file, open(other, "w") as copy:
    copy.write(file.read() + "\n# another\n")
shutil.copytree("config/drives", os.path.join(work, "drives"), dirs_exist_ok=True)
for option, value in (("--bus", "ethercat:none0"), ("--sim-board", "dx=9 mm"), ("--sim-seed", "77"), ("--world", "w.sock")):
    refused = program("run", recipe, "--state", state, option, value)
    expect(f"another {option} is refused", refused.returncode == 2 and option in refused.stderr and
           value in refused.stderr, (refused.returncode, refused.stderr))
refused = program("--machine", other, "home", "--state", state, gantry=plain)
expect("another machine file is refused", refused.returncode == 2 and other in refused.stderr and
       who["machine"] in refused.stderr, refused.stderr)
second = program("up", "--state", state)
expect("a second owner of this state is refused", second.returncode == 7 and "G703" in second.stderr, second.stderr)

# ---- a job through the owner is a job in process ----
alone = program("--json", "run", recipe, "--state", os.path.join(work, "none"), "--sim-board", "dx=0.5 mm", "--out", os.path.join(work, "alone"))
through = program("--json", "run", recipe, "--state", state, "--sim-board", "rot=0 deg, dx=500 um", "--out", "through", cwd=work)
a, t = json.loads(alone.stdout), json.loads(through.stdout)
expect("both jobs are done", (alone.returncode, through.returncode) == (0, 0), through.stderr)
expect("both documents have the same members", list(a) == list(t), (list(a), list(t)))
expect("and the same features", a["counts"] == t["counts"], (a["counts"], t["counts"]))
expect("a relative folder is the client's", t["folder"] == "through" and os.path.exists(os.path.join(work, "through/report.html")))
shown = program("run", recipe, "--state", state, cwd=work)
expect("figures are shown", shown.returncode == 0 and "done: 3 of 3 features" in shown.stdout and "setpoint hash" in shown.stdout and
       "out/short-board-001/report.html" in shown.stdout, shown.stdout)
missing = program("run", "nothing.yaml", "--state", state)
expect("a recipe that cannot be read is told", missing.returncode == 3 and "cannot read this recipe" in missing.stderr and
       "remedy:" in missing.stderr, missing.stderr)

# ---- a flood ----
stop, answered = threading.Event(), [0]


def flood():
    client = Client()
    client.socket.settimeout(1)

    def read():
        while not stop.is_set():
            try:
                answered[0] += client.socket.recv(65536).count(b"\n")
            except OSError:
                pass

    reader = threading.Thread(target=read)
    reader.start()
    while not stop.is_set():
        try:
            client.socket.sendall(b'{"order":"status"}\n' * 50)
        except OSError:
            pass
    reader.join()


flooding = threading.Thread(target=flood)
idle = [Client() for _ in range(20)]
flooding.start()
job = subprocess.Popen([gantry, "run", recipe, "--state", state, "--out", os.path.join(work, "flooded")], stdin=subprocess.DEVNULL,
                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
operator = Client()
end = time.monotonic() + 60
while time.monotonic() < end and operator.ask(order="status")["state"] != "running":
    time.sleep(0.02)
before = cycle()
asked = time.monotonic()
aborted = operator.ask(order="abort")
took = time.monotonic() - asked
expect("an abort in a flood is taken at once", aborted["ok"] and aborted["cycle"] - before < 1000 and took < 2,
       (aborted.get("cycle"), before, took))
errors = job.communicate(timeout=60)[1]
expect("and its job ends", job.returncode == 7 and "G701" in errors, (job.returncode, errors))
expect("the flood is answered meanwhile", answered[0] > 100, answered[0])
asked = time.monotonic()
code = owner.end()
expect("SIGTERM in a flood", code == 0 and time.monotonic() - asked < 10, (code, time.monotonic() - asked))
stop.set()
flooding.join()

# ---- a jog depends on its client ----
owner = Owner().wait()
Client().ask(order="reset")
expect("homed", program("home", "--state", state).returncode == 0)
for name in (signal.SIGSTOP, signal.SIGKILL, signal.SIGINT):
    jog = subprocess.Popen([gantry, "jog", "X", "150mm", "--speed", "10 mm/s", "--state", state], stdin=subprocess.DEVNULL,
                           stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    watch = Client()
    end = time.monotonic() + 30
    while time.monotonic() < end and watch.ask(order="status")["state"] != "running":
        time.sleep(0.02)
    time.sleep(0.5)
    going = watch.ask(order="status")
    expect(f"the jog goes on while its client lives ({name.name})", going["state"] == "running", going["state"])
    here, now = going["axes"][0]["position"], watch.ask(order="status")["cycle"]
    jog.send_signal(name)
    last, stood = here, None
    while stood is None and time.monotonic() < end + 30:
        s = watch.ask(order="status")
        if s["state"] != "running":
            stood = s
    # 100 ms of silence and braking; what lies between two looks of a loaded host comes on top
    expect(f"{name.name} of the client stops the jog", stood is not None and stood["cycle"] - now < 400 and
           stood["axes"][0]["position"] - here < 4, (stood and stood["cycle"] - now, here, stood and stood["axes"][0]))
    if name == signal.SIGSTOP:
        jog.send_signal(signal.SIGCONT)
    code = jog.wait(30)
    expect(f"{name.name}: its exit code", code == {signal.SIGSTOP: 7, signal.SIGKILL: -9, signal.SIGINT: 130}[name], code)
    Client().ask(order="reset")
    program("jog", "X", f"{here - watch.ask(order='status')['axes'][0]['position'] - 5:.3f}mm", "--state", state)

# ---- a job does not ----
job = subprocess.Popen([gantry, "run", recipe, "--state", state, "--out", os.path.join(work, "lost")], stdin=subprocess.DEVNULL,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
end = time.monotonic() + 60
while time.monotonic() < end and job.poll() is None and Client().ask(order="status")["features_done"] < 1:
    time.sleep(0.02)
expect("a job has begun", job.poll() is None, job.poll())
job.kill()
job.wait()
while time.monotonic() < end and not os.path.exists(os.path.join(work, "lost/summary.json")):
    time.sleep(0.05)
with open(os.path.join(work, "lost/summary.json")) as file:
    summary = json.load(file)
expect("a job goes on without its client", summary["result"] == "done", (summary["result"], summary["errors"], summary["cycle"]))
expect("the owner ends in order", owner.end() == 0)

# ---- where state lives ----
home = os.path.join(work, "home")
os.mkdir(home)
environment = {k: v for k, v in os.environ.items() if k not in ("GANTRY_STATE", "XDG_STATE_HOME")} | {"HOME": home}
elsewhere = os.path.join(work, "elsewhere")
os.makedirs(os.path.join(elsewhere, "config/machines"))
with open(os.path.join(elsewhere, "config/machines/dispenser.yaml"), "w") as planted:
    planted.write("this is no machine\n")
owner = Owner(environment=environment, folder=None, stand=elsewhere, gantry=plain)
places = os.path.join(home, ".local/state/gantry")
end = time.monotonic() + 60
while time.monotonic() < end and not os.path.exists(places):
    time.sleep(0.05)
found = os.path.join(places, os.listdir(places)[0])
owner.wait(found)
expect("by machine name under the home folder", os.stat(found).st_mode & 0o777 == 0o700, found)
expect("its clients find it from anywhere", program("status", env=environment, cwd=work, gantry=plain).returncode == 0)
expect("nothing is left where one stands", os.listdir(elsewhere) == ["config"], os.listdir(elsewhere))
owner.end()

# ---- links ----
os.makedirs(os.path.join(work, "planted"))
victim = os.path.join(work, "victim")
with open(victim, "w") as file:
    file.write("precious")
for name in ("report.html", "summary.json", "setpoints.bin", "bead_speeds.csv", "deposits.csv", "summary.json.part", "report.html.part"):
    os.symlink(victim, os.path.join(work, "planted", name))
done = program("dry-run", recipe, "--out", os.path.join(work, "planted"), "--force")
with open(victim) as file:
    expect("nothing is written through planted links", done.returncode == 0 and file.read() == "precious", done.stderr)
os.symlink(state, os.path.join(work, "link"))
linked = program("up", "--state", os.path.join(work, "link"))
expect("a state folder that is a link is refused", linked.returncode == 7, linked.stderr)
if os.geteuid() == 0:
    os.chown(state, 65534, 65534)
    theirs = program("up", "--state", state)
    expect("another user's state folder is refused", theirs.returncode == 7 and "65534" in theirs.stderr, theirs.stderr)
sys.exit(1 if failed else 0)
