"""Clients of an owner whose part the test plays: what Ctrl-C and Ctrl-Z send, what is shown of a hold, and an owner that
says nothing.  python3 clients_test.py GANTRY FOLDER
Limits of time are generous: what is judged is what was sent, shown and returned."""
import json, os, signal, socket, subprocess, sys, threading, time

gantry, work = sys.argv[1:3]
recipe = os.path.abspath("tests/cli/short-board.yaml")
failed = 0

# Which verbs there are, and what each is given: order, words of the command line.
ASKING = {"status": [], "hold": [], "resume": [], "abort": [], "reset": [], "override": ["50"], "down": []}
ACTING = {"enable": [], "disable": [], "part-removed": [], "home": [], "park": [], "jog": ["X", "1mm"], "run": [recipe]}
ORDER_OF = {"down": "quit", "part-removed": "part_removed"}


def expect(what, good, more=""):
    global failed
    print("ok:" if good else "FAILED:", what, "" if good else more, flush=True)
    failed += not good


class PlayedOwner:
    """Answers every look with `state`, as long as it is not `silent`, and the order itself when it is told to."""

    def __init__(self, name):
        self.folder = os.path.join(work, name)
        os.mkdir(self.folder, 0o700)
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.bind(os.path.join(self.folder, "owner.sock"))
        self.socket.listen(8)
        self.heard, self.silent, self.order, self.client = [], False, None, None
        self.answers_left = 0  # when it is silent
        self.state = {"ok": True, "state": "running", "held": False, "held_by": None, "owner": {}, "features_total": 3}
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        while True:
            client, _ = self.socket.accept()
            threading.Thread(target=self.talk, args=(client,), daemon=True).start()

    def talk(self, client):
        try:
            for line in client.makefile("r"):
                said = json.loads(line)
                self.heard.append(said)
                if self.silent and self.answers_left == 0:
                    continue
                self.answers_left = max(0, self.answers_left - 1)
                if said.get("id") == 1:
                    self.order, self.client = said, client
                elif said["order"] in ("status", "hold", "abort"):
                    self.send(client, {**self.state, "order": said["order"], "id": said.get("id")})
        except (OSError, ValueError):
            pass

    def send(self, client, answer):
        client.sendall((json.dumps(answer) + "\n").encode())

    def answer(self, **members):
        """To the order itself."""
        self.send(self.client, {"ok": True, "state": "ready", "order": self.order["order"], "id": 1, **members})

    def fail(self, code, exit_code):
        self.answer(ok=False, exit_code=exit_code, errors=[{"code": code, "message": "as the owner says", "where": ""}])

    def sent(self, order):
        return [said for said in self.heard if said["order"] == order]

    def close(self):
        self.socket.close()
        os.unlink(os.path.join(self.folder, "owner.sock"))


class Client:
    """A verb in a process group of its own, as a shell starts it."""

    def __init__(self, owner, verb, *words, json_document=True):
        self.begun = time.monotonic()
        self.process = subprocess.Popen([gantry, *(["--json"] if json_document else []), verb, *words, "--state", owner.folder],
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                        process_group=0)

    def signal(self, number):
        self.process.send_signal(number)

    def stopped(self):
        with open(f"/proc/{self.process.pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] == "T"

    def end(self, seconds=60):
        self.out, self.err = self.process.communicate(timeout=seconds)
        self.took = time.monotonic() - self.begun
        return self.process.returncode

    def document(self):
        return json.loads(self.out)


def until(condition, seconds=30):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.01)
    return False


number = 0


def owner_for(verb):
    global number
    number += 1
    return PlayedOwner(f"{verb}-{number}")


# ---- Ctrl-C ends what this client has ordered, and nothing else ----
for verb, words in {**ASKING, **ACTING}.items():
    owner = owner_for(verb)
    client = Client(owner, verb, *words)
    expect(f"{verb}: the order comes", until(lambda: owner.order is not None), owner.heard)
    client.signal(signal.SIGINT)
    if verb in ACTING:
        expect(f"{verb}: Ctrl-C ends its own order", until(lambda: owner.sent("abort")), owner.heard)
        owner.fail("G700", 130)
    code = client.end()
    others = [said for said in owner.heard if said["order"] in ("abort", "hold", "quit") and said is not owner.order and
              said.get("mine") is not True]
    expect(f"{verb}: and no other client's", not others, others)
    expect(f"{verb}: exit code 130, in the document too", (code, client.document()["exit_code"]) == (130, 130),
           (code, client.out, client.err))
    expect(f"{verb}: one that only asks ends at once", verb in ACTING or client.document()["errors"][0]["code"] == "G716",
           client.out)
    owner.close()

# What had happened before Ctrl-C was heard is what is told.
owner = owner_for("home")
client = Client(owner, "home")
until(lambda: owner.order is not None)
client.signal(signal.SIGINT)
until(lambda: owner.sent("abort"))
owner.fail("G200", 5)
code = client.end()
expect("a fault that came first is told as such", (code, client.document()["exit_code"]) == (5, 5), (code, client.out))
owner.close()

# ---- Ctrl-Z leaves nothing in motion unwatched ----
for verb in ("run", "park"):
    for as_json in (True, False):
        owner = owner_for(verb)
        client = Client(owner, verb, *ACTING[verb], json_document=as_json)
        until(lambda: owner.order is not None)
        client.signal(signal.SIGTSTP)
        expect(f"{verb}: Ctrl-Z asks for a hold now", until(lambda: owner.sent("hold")) and owner.sent("hold")[0].get("now") is True,
               owner.heard)
        time.sleep(0.5)
        expect(f"{verb}: it goes on watching what still moves", not client.stopped())
        owner.state.update(state="held", held=True, held_by={"by": "order", "yours": True, "words": "held", "next": "resume"})
        expect(f"{verb}: it is suspended when the machine stands", until(client.stopped))
        client.signal(signal.SIGCONT)
        owner.state.update(state="running", held=False, held_by=None)
        owner.answer()
        expect(f"{verb}: after fg it hears how it ended", client.end() == 0, client.err)
        expect(f"{verb}: Ctrl-Z has aborted nothing", not owner.sent("abort"), owner.heard)
        owner.close()
for verb in ("home", "jog"):
    owner = owner_for(verb)
    client = Client(owner, verb, *ACTING[verb])
    until(lambda: owner.order is not None)
    client.signal(signal.SIGTSTP)
    expect(f"{verb}: Ctrl-Z ends what cannot be held", until(lambda: owner.sent("abort")) and owner.sent("abort")[0].get("mine") is True,
           owner.heard)
    owner.fail("G700", 130)
    code = client.end()
    expect(f"{verb}: as Ctrl-C does", (code, client.document()["exit_code"]) == (130, 130), (code, client.out))
    owner.close()

# ---- why it stands ----
owner = owner_for("run")
client = Client(owner, "run", recipe, json_document=False)
until(lambda: owner.order is not None)
for by, words in (("order", "held by the order `hold`"), ("button", "held by the machine's hold button"),
                  ("fault", "stopped: the door is open [G704]")):
    owner.state.update(state="held", held=True, held_by={"by": by, "yours": False, "words": words, "next": f"what {by} needs"})
    time.sleep(0.6)
owner.state.update(held_by={"by": "order", "yours": True, "words": "held by what it asked for", "next": "nothing"})
time.sleep(0.6)
owner.state.update(state="running", held=False, held_by=None)
time.sleep(0.6)
owner.answer()
client.end()
for line in ("held by the order `hold` of another client; what order needs", "held by the machine's hold button; what button needs",
             "stopped: the door is open [G704]; what fault needs", "no longer on hold"):
    expect(f"it is told: {line}", client.err.count(line) == 1, client.err)
expect("what it has asked for itself is not", "what it asked for" not in client.err, client.err)
owner.close()
owner = owner_for("run")
client = Client(owner, "run", recipe, json_document=False)
until(lambda: owner.order is not None)
owner.state.update(state="held", held=True, held_by={"by": "order", "yours": False, "words": "held by the order `hold`", "next": "n"})
time.sleep(0.6)
owner.state.update(state="stopping", held=False, held_by=None)
time.sleep(0.6)
owner.fail("G701", 7)
client.end()
expect("what is aborted on hold is not told to go on", "held by" in client.err and "no longer" not in client.err, client.err)
owner.close()

# ---- an owner that says nothing ----
silent = []
for verb, words in {**ASKING, **ACTING}.items():
    owner = owner_for(verb)
    owner.silent = True
    owner.answers_left = verb in ("home", "jog", "run")  # which ask first whose machine it is
    silent.append((verb, owner, Client(owner, verb, *words)))
for verb, owner, client in silent:
    code = client.end()
    error = client.document()["errors"][0]
    expect(f"{verb}: an owner that does not answer is told", (code, client.document()["exit_code"], error["code"]) == (7, 7, "G715"),
           (code, client.out, client.err))
    expect(f"{verb}: after some 5 s", client.took > 4.5, client.took)
    expect(f"{verb}: with its process and what to do", str(os.getpid()) in error["message"] and "kill -CONT" in error["remedy"], error)
    begins = verb not in ("status",)
    taken_back = lambda: [said.get("mine") for said in owner.sent("abort") if said.get("id") != 1]
    until(lambda: not begins or taken_back(), 5)
    mine = taken_back()
    expect(f"{verb}: what was ordered is taken back", mine == ([True] if begins else []), owner.heard)
    owner.close()

# A job takes as long as it takes.
owner = owner_for("run")
client = Client(owner, "run", recipe)
until(lambda: owner.order is not None)
time.sleep(8)
expect("a long job is waited for while its owner gives signs of life", client.process.poll() is None, client.process.returncode)
owner.silent = True
code = client.end()
expect("and told when they end", code == 7 and client.document()["errors"][0]["code"] == "G715" and
       client.document()["board"] is None, (code, client.out))
owner.close()

# A stopped process takes no connection when others wait already.
owner = owner_for("full")
full = []
blocked = socket.socket(socket.AF_UNIX)
blocked.bind(os.path.join(work, "full.sock"))
blocked.listen(0)
owner.close()
os.symlink(os.path.join(work, "full.sock"), os.path.join(owner.folder, "owner.sock"))
for _ in range(4):
    waiting = socket.socket(socket.AF_UNIX)
    waiting.setblocking(False)
    try:
        waiting.connect(os.path.join(work, "full.sock"))
    except BlockingIOError:
        pass
    full.append(waiting)
client = Client(owner, "status")
code = client.end()
expect("an owner that takes no connection", (code, client.document()["errors"][0]["code"]) == (7, "G715"), (code, client.out))
sys.exit(1 if failed else 0)
