#!/usr/bin/env python3
"""Three terminals of clumsy operators on one `gantry up`, in simulation and real time.
  python3 bench/clumsy_clients/campaign.py [--runs 100] [--seed 1] [--first 0] [--gantry build/release/bin/gantry]
Each run: in each of three terminals a few verbs one after the other, at instants of the seed, and to each verb at another
instant something that happens to verbs: Ctrl-C (once, twice), Ctrl-Z and `fg`, SIGSTOP and SIGCONT, SIGHUP, kill -9, nothing.
In one run of seven the owner itself is stopped for up to 7 s (SIGSTOP). A fourth client watches. What must hold:
  - the owner answers the watcher within 2 s, while it is not stopped, and never as idle (ready, disabled) while it is busy
  - what a verb has ordered of a stopped owner, and given up after 5 s (G715), is not begun when the owner goes on
  - every verb ends within 30 s of the end of the run, when what is left is aborted, with an exit code of docs/index
  - the exit code of a document is that of its program
  - a verb ends with 130 only if something was done to itself, and with G701 only if somebody has aborted, or a jog was silent
  - while a `run` or `park` is suspended by Ctrl-Z, what it has ordered does not move before somebody resumes it
  - a jog whose client is stopped, suspended or dead stands 0.5 s later
  - abort, reset and part-removed bring the machine back to where nothing is under way and nothing is latched
Exit code 0: all of it held, in every run."""
import argparse, collections, json, os, random, shutil, signal, subprocess, sys, tempfile, threading, time

here = os.path.dirname(os.path.abspath(__file__))
top = os.path.dirname(os.path.dirname(here))
sys.path[:0] = [os.path.join(top, "tests/cli"), os.path.join(top, "bench")]
import quick_machine
from owner_client import OwnerClient

VERBS = {"run": 4, "home": 2, "park": 3, "jog": 3, "hold": 2, "resume": 2, "abort": 1, "reset": 1, "override": 1, "enable": 1,
         "disable": 1, "status": 2, "part-removed": 1}
ACTS = {"nothing": 3, "Ctrl-C": 3, "Ctrl-C twice": 1, "Ctrl-Z": 3, "SIGSTOP": 2, "SIGHUP": 1, "kill -9": 1}
ORDER_OF = {"part-removed": "part_removed"}
CODES = {0, 1, 4, 5, 6, 7, 8, 9, 130, -signal.SIGKILL}
IDLE = ("ready", "disabled")
ANSWER_S, END_S, JOG_STANDS_S = 2.0, 30.0, 0.5
# What the owner has answered between `asked` and `at`: on a busy host these may be far apart.
Seen = collections.namedtuple("Seen", "asked at state busy held")


class Watcher:
    """What the owner says of itself, some 50 times a second."""

    def __init__(self, rig):
        self.rig, state = rig, rig.state
        self.client, self.seen, self.wrong, self.over = OwnerClient(state), collections.deque(maxlen=20000), [], False
        self.last = None
        self.thread = threading.Thread(target=self.watch, daemon=True)
        self.thread.start()

    def watch(self):
        while not self.over:
            asked = time.monotonic()
            try:
                answer = self.client.ask(order="status")
            except (OSError, ValueError) as e:
                self.wrong.append(f"the owner is gone: {e}")
                return
            now = time.monotonic()
            if now - asked > ANSWER_S and not self.rig.was_stopped(asked, now):
                self.wrong.append(f"the owner was silent for {now - asked:.1f} s")
            if answer["busy_with"] is not None and answer["state"] in IDLE:
                self.wrong.append(f"busy with {answer['busy_with']}, and reads as {answer['state']}")
            self.last = answer
            self.seen.append(Seen(asked, now, answer["state"], answer["busy_with"], answer["held"]))
            time.sleep(0.02)

    def end(self):
        self.over = True
        self.thread.join(5)


class Verb:
    """One verb in a process group of its own, as a shell starts it; what is done to it, and what became of it."""

    def __init__(self, rig, verb, act, at_s, for_s, rng):
        self.rig, self.verb, self.act, self.at_s, self.for_s = rig, verb, act, at_s, for_s
        words = {"run": [rig.recipe, "--out", os.path.join(rig.folder, "out"), "--force"],
                 "jog": [rng.choice("XY"), f"{rng.choice([-1, 1]) * rng.uniform(5, 30):.2f}mm", "--speed", "20 mm/s"],
                 "override": [str(rng.choice([0, 50, 100]))],
                 "hold": rng.choice([[], ["--now"]])}.get(verb, [])
        self.begun, self.suspended, self.acted, self.ended, self.done = None, [], None, None, None
        self.command = [rig.gantry, "-q", "--json", verb, *words, "--state", rig.state]

    def signal(self, number):
        if self.process.poll() is None:
            os.killpg(self.process.pid, number)

    def is_stopped(self):
        try:
            with open(f"/proc/{self.process.pid}/stat") as file:
                return file.read().rsplit(")", 1)[1].split()[0] == "T"
        except OSError:
            return False

    def hears(self):
        """Its signal handlers are there: a program that has ordered nothing yet ends, and is suspended, as any is."""
        try:
            with open(f"/proc/{self.process.pid}/status") as file:
                caught = next(line for line in file if line.startswith("SigCgt:"))
            heard = int(caught.split()[1], 16)
            wanted = [signal.SIGINT] + [signal.SIGTSTP] * (self.act == "Ctrl-Z" and self.verb in ("run", "park", "home", "jog"))
            return all(heard >> (number - 1) & 1 for number in wanted)
        except (OSError, StopIteration):
            return True

    def do(self):
        end = time.monotonic() + 20
        while time.monotonic() < end and not self.hears() and self.process.poll() is None:
            time.sleep(0.005)
        self.acted = time.monotonic()
        if self.act.startswith("Ctrl-C"):
            self.signal(signal.SIGINT)
            if self.act.endswith("twice"):
                time.sleep(0.3)
                self.signal(signal.SIGINT)
        elif self.act == "SIGHUP":
            self.signal(signal.SIGHUP)
        elif self.act == "kill -9":
            self.signal(signal.SIGKILL)
        elif self.act in ("Ctrl-Z", "SIGSTOP"):
            self.signal(signal.SIGTSTP if self.act == "Ctrl-Z" else signal.SIGSTOP)
            end = time.monotonic() + 10  # homing of a job comes to its end
            while time.monotonic() < end and self.process.poll() is None and not self.is_stopped():
                time.sleep(0.01)
            if self.is_stopped():
                begin = time.monotonic()
                time.sleep(self.for_s)
                self.suspended.append((begin, time.monotonic()))
            self.signal(signal.SIGCONT)

    def run(self):
        self.begun = time.monotonic()
        self.process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        text=True, process_group=0)
        self.rig.running.append(self)
        reader = threading.Thread(target=self.read, daemon=True)
        reader.start()
        if self.act != "nothing":
            reader.join(self.at_s)
            self.do()
        reader.join(self.rig.patience())
        if reader.is_alive():
            self.rig.abort_all()
            reader.join(END_S)
        if reader.is_alive():
            self.done = "it does not end"
            self.signal(signal.SIGKILL)
            reader.join(5)

    def read(self):
        self.out, self.err = self.process.communicate()
        self.ended = time.monotonic()

    def judge(self, aborts, resumes):
        wrong, name = [], f"{self.verb} with {self.act}"
        if self.done:
            return [f"{name}: {self.done}"]
        code = self.process.returncode
        if code not in CODES:
            wrong.append(f"{name}: exit {code}: {self.err[-200:]!r}")
        errors = []
        if self.out.strip():
            try:
                document = json.loads(self.out)
                errors = [e["code"] for e in document["errors"]]
                if document["exit_code"] != code and not (code == 130 and self.act == "Ctrl-C twice"):
                    wrong.append(f"{name}: exit {code}, and its document says {document['exit_code']}")
            except ValueError:
                wrong.append(f"{name}: no document: {self.out[-200:]!r}")
        elif code not in (-signal.SIGKILL, 130):
            wrong.append(f"{name}: exit {code} without a document: {self.err[-200:]!r}")
        done_to = self.act in ("Ctrl-C", "Ctrl-C twice", "SIGHUP") or (self.act == "Ctrl-Z" and self.verb in ("home", "jog"))
        if code == 130 and not (done_to and self.acted is not None and self.acted < self.ended + 0.1):
            wrong.append(f"{name}: 130, and nothing was done to it: {errors} {self.err[-200:]!r}")
        aborted = any(self.begun - 0.5 < at < self.ended for at in aborts)
        silent = self.verb == "jog" and ("silent" in self.out or "closed" in self.out)
        if "G701" in errors and not aborted and not silent:
            wrong.append(f"{name}: aborted, and nobody has: {self.out[-300:]!r}")
        if self.act == "Ctrl-Z" and self.verb in ("run", "park"):
            wrong += self.judge_suspended(name, resumes)
        if self.verb == "jog":
            wrong += self.judge_jog(name)
        if "G715" in errors:
            wrong += self.judge_given_up(name)
        return wrong

    def judge_given_up(self, name):
        stopped = self.rig.stopped
        if stopped is None:
            return [f"{name}: the owner was not stopped: {self.out[-300:]!r}"]
        if self.begun < stopped[0]:
            return []  # it may have begun
        others = [v for v in self.rig.running if v is not self and v.verb == self.verb]
        begun = [s for s in self.rig.watcher.seen if s.asked > max(self.ended, stopped[1]) and s.busy == ORDER_OF.get(self.verb, self.verb)]
        return [f"{name}: given up, and begun: {begun[0]}"] if begun and not others else []

    def judge_suspended(self, name, resumes):
        for begin, end in self.suspended:
            if any(begin - 1 < at < end for at in resumes):
                continue
            moving = [s for s in self.rig.watcher.seen if begin < s.asked and s.at < end and s.busy == self.verb and
                      s.state in ("running", "homing")]
            # The needle is lifted off what a hold has cut, held all the while.
            if any(not s.held for s in moving):
                return [f"{name}: suspended, and it moves: {moving[0]}"]
        return []

    def judge_jog(self, name):
        gone = self.acted if self.act in ("SIGSTOP", "kill -9", "SIGHUP", "Ctrl-Z") else None
        if gone is None or (self.act == "SIGSTOP" and not self.suspended):
            return []
        until = self.suspended[0][1] if self.suspended else gone + 2
        others = any(v is not self and v.verb == "jog" and v.begun < until and (v.ended or until) > gone for v in self.rig.running)
        late = [s for s in self.rig.watcher.seen if gone + JOG_STANDS_S < s.asked and s.at < until and s.busy == "jog" and s.state == "running"]
        others = others or self.rig.was_stopped(gone, until)
        return [f"{name}: its client is gone, and it moves: {late[0]}"] if late and not others else []


class Rig:
    def __init__(self, given, folder):
        self.gantry_program, self.folder, self.state = given.gantry, folder, os.path.join(folder, "state")
        self.recipe = os.path.join(top, "tests/cli/short-board.yaml")
        machine = quick_machine.write(folder, [("sim: 50}", "sim: 2000}")])
        self.gantry = os.path.join(folder, "gantry")
        with open(self.gantry, "w") as file:
            file.write(f'#!/bin/sh\nexec "{given.gantry}" --machine "{machine}" "$@"\n')
        os.chmod(self.gantry, 0o755)
        self.log = open(os.path.join(folder, "up.log"), "w")
        self.up = subprocess.Popen([self.gantry, "up", "--state", self.state], stdin=subprocess.DEVNULL, stdout=self.log,
                                   stderr=self.log)
        end = time.monotonic() + 60
        while time.monotonic() < end:
            try:
                if OwnerClient(self.state).ask(order="status")["state"] != "offline":
                    break
            except (OSError, ValueError):
                pass
            time.sleep(0.1)
        else:
            sys.exit("no owner came up")
        self.hand = OwnerClient(self.state)
        self.aborts, self.running, self.over_at, self.stopped = [], [], 0, None

    def was_stopped(self, begin, end):
        return self.stopped is not None and begin < self.stopped[1] + 1 and end > self.stopped[0]

    def stop_owner(self, after_s, for_s):
        time.sleep(after_s)
        self.stopped = (time.monotonic(), float("inf"))
        self.up.send_signal(signal.SIGSTOP)
        time.sleep(for_s)
        self.up.send_signal(signal.SIGCONT)
        self.stopped = (self.stopped[0], time.monotonic())

    def patience(self):
        return max(0.0, self.over_at - time.monotonic())

    def abort_all(self):
        self.aborts.append(time.monotonic())
        return OwnerClient(self.state).ask(order="abort")

    def clear(self):
        """By orders alone, to where nothing is under way and nothing is latched. What is in the way, or ""."""
        end, last = time.monotonic() + 20, {}
        while time.monotonic() < end:
            self.abort_all()
            hand = OwnerClient(self.state)
            last = hand.ask(order="status")
            if last["busy_with"] is None and not last["faults"] and last["state"] in IDLE:
                hand.ask(order="override", value=1)
                removed = hand.ask(order="part_removed")
                return "" if removed["ok"] else f"part_removed: {removed['errors']}"
            hand.ask(order="reset")
            time.sleep(0.1)
        return f"no way out of {last['state']}, {last['busy_with']}, {last['faults']}"

    def one(self, rng):
        """What is wrong, and the figures of the run."""
        self.running, self.aborts, self.stopped = [], [], None
        self.watcher = Watcher(self)
        if rng.random() < 0.7 and not all(a["referenced"] for a in OwnerClient(self.state).ask(order="status")["axes"][:5]):
            OwnerClient(self.state).ask(order="home")
        plans = []
        for _ in range(3):
            plan = []
            for _ in range(rng.randint(2, 3)):
                verb = rng.choices(list(VERBS), VERBS.values())[0]
                act = rng.choices(list(ACTS), ACTS.values())[0]
                plan.append((rng.uniform(0, 1), Verb(self, verb, act, rng.uniform(0.02, 2.5), rng.uniform(0.2, 1.5), rng)))
            plans.append(plan)
        self.over_at = time.monotonic() + 8

        def terminal(plan):
            for wait_s, verb in plan:
                time.sleep(wait_s)
                verb.run()

        threads = [threading.Thread(target=terminal, args=(plan,)) for plan in plans]
        if rng.random() < 1 / 7:
            threads.append(threading.Thread(target=self.stop_owner, args=(rng.uniform(0.5, 4), rng.uniform(0.3, 7))))
        for t in threads:
            t.start()
        for t in threads:
            t.join(120)
        left = self.clear()
        self.watcher.end()
        verbs = [v for plan in plans for _, v in plan if v.begun]
        aborts = self.aborts + [v.begun + 0.01 * i for v in verbs if v.verb == "abort" for i in range(100)]
        resumes = [v.begun + 0.01 * i for v in verbs if v.verb == "resume" for i in range(100)]
        wrong = list(self.watcher.wrong) + ([left] if left else [])
        for v in verbs:
            wrong += v.judge(aborts, resumes)
        said = ("owner stopped for %.1f s: " % (self.stopped[1] - self.stopped[0]) if self.stopped else "") + ", ".join(f"{v.verb}/{v.act}={v.process.returncode}" for v in verbs)
        return wrong, said

    def end(self):
        self.up.terminate()
        return self.up.wait(60)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--runs", type=int, default=100)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--first", type=int, default=0, help="run of the seed to begin with")
    options.add_argument("--gantry", default=os.path.join(top, "build/release/bin/gantry"))
    given = options.parse_args()
    given.gantry = os.path.abspath(given.gantry)
    folder = tempfile.mkdtemp()
    rig, failed, verbs = Rig(given, folder), 0, 0
    try:
        for number in range(given.first, given.first + given.runs):
            wrong, said = rig.one(random.Random(given.seed * 1000 + number))
            failed += bool(wrong)
            verbs += len(said.split(", "))
            print(f"{number:3} {'ok' if not wrong else 'FAILED: ' + '; '.join(wrong)}  [{said}]", flush=True)
            if rig.up.poll() is not None:
                print(f"the owner has ended with {rig.up.returncode}")
                return 1
        code = rig.end()
        print(f"seed {given.seed}: {given.runs - failed} of {given.runs} held, {verbs} verbs; the owner ended with {code}")
        return 1 if failed or code != 0 else 0
    finally:
        if rig.up.poll() is None:
            rig.up.kill()
        if failed:
            print(f"the owner's log: {folder}/up.log")
        else:
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
