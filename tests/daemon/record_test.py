#!/usr/bin/env python3
"""chevalctl record, as it is run.

    record_test.py CHEVALCTL

Passes when it refuses to record without consent, records what chevalctl replay then plays, ends at SIGINT with a folder
that can be played, and refuses a folder that holds a recording already.
"""
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

LIMIT = 240.0  # Seconds for each step; reached only where it hangs.


class Failure(Exception):
    pass


class Technician:
    def __init__(self, program, folder):
        self.program = program
        self.settings = folder / "settings"
        self.settings.mkdir()

    def set(self, privacy):
        (self.settings / "cheval.toml").write_text(f'[sensor]\nsource = "sim"\n{privacy}')

    def command(self, *arguments):
        return [self.program, "--config", str(self.settings), *map(str, arguments)]

    def run(self, *arguments, status=0, says=()):
        ended = subprocess.run(self.command(*arguments), timeout=LIMIT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True)
        print(ended.stdout, end="")
        if ended.returncode != status:
            raise Failure(f"{arguments} ended with status {ended.returncode}, not {status}")
        for text in says:
            if text not in ended.stdout:
                raise Failure(f"{arguments} does not say {text!r}")
        return ended.stdout


def pictures(folder, kind):
    return sorted(folder.glob(f"{kind}-*.png"))


def number(text, pattern):
    found = re.search(pattern, text)
    if not found:
        raise Failure(f"no {pattern!r} in {text!r}")
    return int(found.group(1))


def consent(technician, folder):
    technician.set("")
    technician.run("record", folder / "none", "--frames", 1, status=1,
                   says=("recording is off", "privacy.recording", "consent"))
    if (folder / "none").exists():
        raise Failure("it made a folder that it was not allowed to fill")


def round_trip(technician, folder):
    technician.set("[privacy]\nrecording = true\n")
    target = folder / "depth"
    output = technician.run("record", target, "--frames", 5, says=("depth alone",))
    if number(output, r"(\d+) frames written") != 5 or len(pictures(target, "depth")) != 5:
        raise Failure("five frames were asked for")
    if pictures(target, "color"):
        raise Failure("it wrote colour without consent")
    played = technician.run("replay", target)
    if number(played, r"(\d+) frames:") != 5:
        raise Failure("what was recorded is not what is played")
    before = sorted(path.name for path in target.iterdir())
    technician.run("record", target, "--frames", 1, status=1, says=("not empty",))
    if sorted(path.name for path in target.iterdir()) != before:
        raise Failure("a refused recording changed the folder")


def interrupted(technician, folder):
    technician.set("[privacy]\nrecording = true\nrecording_colour = true\n")
    target = folder / "colour"
    process = subprocess.Popen(technician.command("record", target), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True)
    try:
        limit = time.monotonic() + LIMIT
        while len(pictures(target, "depth")) < 3:
            if time.monotonic() > limit or process.poll() is not None:
                raise Failure("no three frames came")
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=LIMIT)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
    print(output, end="")
    if process.returncode != 0:
        raise Failure(f"SIGINT ended it with status {process.returncode}")
    written = number(output, r"(\d+) frames written with colour")
    if written < 3 or len(pictures(target, "depth")) != written or len(pictures(target, "color")) != written:
        raise Failure("the folder does not hold what it said it wrote")
    left = [path.name for path in target.iterdir() if path.suffix not in (".png", ".json")]
    if left:
        raise Failure(f"unfinished files are left: {left}")
    if number(technician.run("replay", target), r"(\d+) frames:") != written:
        raise Failure("what was recorded is not what is played")


def main():
    with tempfile.TemporaryDirectory(prefix="cheval_record_") as name:
        folder = pathlib.Path(name)
        technician = Technician(sys.argv[1], folder)
        try:
            consent(technician, folder)
            round_trip(technician, folder)
            interrupted(technician, folder)
        except (Failure, subprocess.TimeoutExpired) as failure:
            return str(failure)
    return None


if __name__ == "__main__":
    fault = main()
    sys.exit(f"failed: {fault}" if fault else 0)
