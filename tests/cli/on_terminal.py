"""A program on a terminal of its own, as a login shell would start it.
    p = OnTerminal(["gantry", "run", "board.yaml"])
    p.wait_for(r" running")
    p.type("\x03")
    status = p.wait()
"""
import fcntl, os, pty, re, select, signal, struct, sys, termios, time


def as_a_user():
    """As a login shell starts a program: nothing is ignored."""
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGPIPE, signal.SIGTSTP):
        signal.signal(number, signal.SIG_DFL)


class OnTerminal:
    """`text` is what it has said; wait_for() looks in what came after the last pattern that was found."""

    def __init__(self, words, environment=None, columns=80):
        self.text, self.seen = "", 0
        self.pid, self.terminal = pty.fork()
        if self.pid == 0:
            as_a_user()
            fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
            os.execvpe(words[0], words, {**os.environ, "TERM": "xterm", **(environment or {})})

    def read(self, seconds):
        """What comes within that time; False when the other side is closed."""
        if self.terminal is None:
            time.sleep(seconds)
            return False
        if not select.select([self.terminal], [], [], seconds)[0]:
            return True
        try:
            data = os.read(self.terminal, 65536)
        except OSError:
            time.sleep(seconds)
            return False
        self.text += data.decode(errors="replace")
        return bool(data)

    def wait_for(self, pattern, seconds=60):
        end = time.monotonic() + seconds
        while True:
            found = re.compile(pattern).search(self.text, self.seen)
            if found:
                self.seen = found.end()
                return found
            if time.monotonic() > end or not self.read(0.2):
                sys.exit(f"FAILED: no '{pattern}' in {self.text[self.seen:][-800:]!r}")

    def type(self, keys):
        os.write(self.terminal, keys.encode())

    def close(self):
        """The window is closed, the connection drops."""
        if self.terminal is not None:
            os.close(self.terminal)
        self.terminal = None

    def child(self):
        """The process that holds the machine stands behind a front, which is the one that the shell knows."""
        with open(f"/proc/{self.pid}/task/{self.pid}/children") as file:
            children = file.read().split()
        return int(children[0]) if children else self.pid

    def ended(self):
        """Its exit status; None while it runs."""
        done, status = os.waitpid(self.pid, os.WNOHANG)
        return os.waitstatus_to_exitcode(status) if done else None

    def wait(self, seconds=60):
        """Its exit status; what it says on the way is read."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            status = self.ended()
            if status is not None:
                return status
            self.read(0.05)
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)
        return "it does not end"
