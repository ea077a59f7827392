#!/usr/bin/env python3
"""Sends a running chevald the signals that a service gets.

    signals_test.py CHEVALD

Passes when SIGHUP with bad settings names the key and leaves the mirror alive, SIGHUP with good ones puts them in force, and
SIGTERM ends it with status 0. Each wait is for a line of the log.
"""
import pathlib
import queue
import signal
import subprocess
import sys
import tempfile
import threading

LIMIT = 120.0  # Seconds for each line to come; reached only where it does not.

GOOD = """
[sensor]
source = "sim"
[display]
kind = "headless"
width = 270
height = 480
[bus]
kind = "none"
"""


class Failure(Exception):
    pass


class Mirror:
    def __init__(self, program, folder):
        self.process = subprocess.Popen([program, "--config", folder], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                        stderr=subprocess.PIPE, text=True)
        self.lines = queue.Queue()
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stderr:
            self.lines.put(line)
        self.lines.put(None)  # It is over.

    def wait_for(self, text):
        """The next line of the log with this text in it."""
        while True:
            try:
                line = self.lines.get(timeout=LIMIT)
            except queue.Empty:
                raise Failure(f"no line with {text!r} in {LIMIT:.0f} s") from None
            if line is None:
                raise Failure(f"it ended with status {self.process.wait()} before a line with {text!r}")
            print(line, end="")
            if text in line:
                return

    def send(self, number):
        self.process.send_signal(number)

    def end(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.reader.join(timeout=LIMIT)


def signals(mirror, settings):
    mirror.wait_for("drawing with")

    settings.write_text(GOOD + "[loop]\nfsp = 20.0\n")
    mirror.send(signal.SIGHUP)
    mirror.wait_for("loop.fsp")
    mirror.wait_for("the last good ones stay in force")

    # That it answers again is how one sees that it lived on.
    settings.write_text(GOOD + "[loop]\nfps = 20.0\n")
    mirror.send(signal.SIGHUP)
    mirror.wait_for("new settings are in force")

    mirror.send(signal.SIGTERM)
    try:
        status = mirror.process.wait(timeout=LIMIT)
    except subprocess.TimeoutExpired:
        raise Failure("SIGTERM does not end it") from None
    mirror.reader.join(timeout=LIMIT)
    if status != 0:
        while (line := mirror.lines.get()) is not None:
            print(line, end="")
        raise Failure(f"SIGTERM ended it with status {status}")


def main():
    with tempfile.TemporaryDirectory(prefix="cheval_signals_") as name:
        folder = pathlib.Path(name)
        settings = folder / "cheval.toml"
        settings.write_text(GOOD)
        mirror = Mirror(sys.argv[1], folder)
        try:
            signals(mirror, settings)
        except Failure as failure:
            return str(failure)
        finally:
            mirror.end()
    return None


if __name__ == "__main__":
    fault = main()
    sys.exit(f"failed: {fault}" if fault else 0)
