"""The operator's keys, on a terminal of the test's own.  python3 keys_test.py GANTRY RECIPE FOLDER"""
import json, os, pty, re, select, sys, time

gantry, recipe, folder = sys.argv[1:4]


class Job:
    def __init__(self, name):
        self.out = os.path.join(folder, name)
        self.text, self.seen = "", 0
        self.pid, self.terminal = pty.fork()
        if self.pid == 0:
            os.execv(gantry, [gantry, "run", recipe, "--state", os.path.join(folder, "none"), "--out", self.out])

    def read(self, seconds):
        if not select.select([self.terminal], [], [], seconds)[0]:
            return True
        try:
            data = os.read(self.terminal, 65536)
        except OSError:  # the child has closed its side
            return False
        self.text += data.decode(errors="replace")
        return bool(data)

    def wait_for(self, pattern, seconds=60):
        """What is shown from where the last one was found."""
        end = time.monotonic() + seconds
        while True:
            found = re.compile(pattern).search(self.text, self.seen)
            if found:
                self.seen = found.end()
                return
            if time.monotonic() > end or not self.read(0.2):
                sys.exit(f"FAILED: no '{pattern}' in {self.text[self.seen:][-600:]!r}")

    def press(self, key):
        os.write(self.terminal, key.encode())

    def end(self):
        while self.read(60):
            pass
        status = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
        with open(os.path.join(self.out, "summary.json")) as file:
            return status, json.load(file)


def expect(what, got, wanted):
    if got != wanted:
        sys.exit(f"FAILED: {what}: {got!r}, expected {wanted!r}")
    print("ok:", what)


job = Job("held")
job.wait_for(r" running")
job.press("+")
job.wait_for(r"running 110 %")
job.press("-")
job.press(" ")
job.wait_for(r" held")
job.press(" ")
job.wait_for(r" running")
status, summary = job.end()
expect("held, resumed and done", (status, summary["result"], summary["counts"]["features_done"]), (0, "done", 3))
expect("every shot on its feature", sorted(d["id"] for d in summary["deposits"]), ["a", "b", "corner"])

job = Job("aborted")
job.wait_for(r" running")
job.press("a")
status, summary = job.end()
expect("aborted", (status, summary["result"], summary["errors"][0]["code"]), (7, "aborted", "G701"))
