#!/usr/bin/env python3
"""Looks for anybody's measurements in all that the programs write and say.

    privacy_test.py CHEVALD CHEVALCTL

Runs a visit with its report, the service with a shopper before it and a technician who asks for its status, and a recording
that is replayed; then reads every file that is there afterwards and every line that was printed. Passes when none names a
length or girth of a body, or tells a size. The technician's own tracks file is allowed to, and serves as the proof that what
is looked for would be found.
"""
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time

LIMIT = 240.0  # Seconds for each step; reached only where something hangs.

SETTINGS = """
[sensor]
source = "sim"
[simulation]
visit_s = 8.0
pause_s = 1.0
[display]
kind = "headless"
width = 270
height = 480
[loop]
budget_scale = 20.0
[privacy]
recording = true
[bus]
kind = "session"
"""

# Names in any spelling; in any file.
NAMES = re.compile(
    rb"(?i)girth|stature|inside[ _-]?leg|shoulder[ _-]?breadth|arm[ _-]?length|neck[ _-]?size|measurements?\b|"
    rb"your size|between [0-9x]*[sml] and")
# Short names, and values with what makes them lengths; in texts alone, since such bytes come by chance in a picture.
VALUES = re.compile(r"(?i:\bbust\b)|±|\+/-|\d\s?(?:cm|mm|centimet|millimet|inch)")

# What the mirror says and is no measurement of anybody.
HARMLESS = (
    # The sensor's mount, in a recording.
    re.compile(r'"(?:heightMm|height_mm)"[^\n]*'),
)


class Failure(Exception):
    pass


def findings(name, data):
    """What must not be in these bytes, as lines to print."""
    found = [f"{name}: {match.group(0).decode()!r}" for match in NAMES.finditer(data)]
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        return found
    for harmless in HARMLESS:
        text = harmless.sub("", text)
    return found + [f"{name}: {text[max(match.start() - 30, 0):match.end() + 10]!r}" for match in VALUES.finditer(text)]


def check_the_check():
    """Each way in which somebody might write a measurement is found."""
    for sample in ("chest_girth=0.942", "chestGirth: 0.942", "Chest girth 94", "stature 1.72", "insideLeg 0.8", "inside leg 80",
                   "armLength", "shoulder_breadth", "94.2 ± 1.2", "94.2 +/- 1.2", "chest 94 cm", "waist 780mm", "Your size: M",
                   "Between M and L", '{"measurements": [1.72, 0.94]}'):
        if not findings("sample", sample.encode()):
            raise Failure(f"the check does not find {sample!r}")
        if not findings("sample", b"\x00\xff" + sample.encode()) and NAMES.search(sample.encode()):
            raise Failure(f"the check does not find {sample!r} among bytes that are no text")
    for sample in ("notice: drawing with Mesa 22.3, 30.0 pictures a second, 12.5 ms", "wearing: T-shirt"):
        if findings("sample", sample.encode()):
            raise Failure(f"the check finds something in {sample!r}")


class House:
    """The programs, with every folder that they may write to under one."""

    def __init__(self, folder, chevald, chevalctl):
        self.folder = folder
        self.chevald, self.chevalctl = (str(pathlib.Path(program).resolve()) for program in (chevald, chevalctl))
        self.said = {}
        self.settings = folder / "settings"
        self.environment = dict(os.environ)
        for variable in ("HOME", "TMPDIR", "RUNTIME_DIRECTORY", "STATE_DIRECTORY", "CACHE_DIRECTORY", "LOGS_DIRECTORY",
                         "XDG_RUNTIME_DIR", "XDG_STATE_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME", "XDG_CONFIG_HOME"):
            place = folder / variable.lower()
            place.mkdir(mode=0o700)
            self.environment[variable] = str(place)
        # The drivers' shaders are not ours, and say nothing of anybody.
        self.environment["MESA_SHADER_CACHE_DISABLE"] = "true"
        self.settings.mkdir()
        (self.settings / "cheval.toml").write_text(SETTINGS)

    def keep(self, name, output):
        self.said[name] = self.said.get(name, b"") + output

    def run(self, name, *command):
        ended = subprocess.run([str(part) for part in command], timeout=LIMIT, cwd=self.folder, env=self.environment,
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.keep(name, ended.stdout)
        if ended.returncode != 0:
            raise Failure(f"{name} ended with status {ended.returncode}: {ended.stdout.decode(errors='replace')}")
        return ended.stdout

    def one_visit(self):
        self.run("chevald --once", self.chevald, "--config", self.settings, "--once", "--report", self.folder / "report")

    def recording(self):
        control = (self.chevalctl, "--config", self.settings)
        self.run("chevalctl record", *control, "record", self.folder / "recording", "--frames", "120")
        self.run("chevalctl replay", *control, "replay", self.folder / "recording", "--frames", self.folder / "pictures",
                 "--tracks", self.folder / "tracks.jsonl")

    def service(self):
        bus = subprocess.Popen(["dbus-daemon", "--session", "--nofork", "--nopidfile", "--print-address"],
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            self.environment["DBUS_SESSION_BUS_ADDRESS"] = bus.stdout.readline().strip()
            with open(self.folder / "journal", "wb") as journal:
                mirror = subprocess.Popen([self.chevald, "--config", self.settings], cwd=self.folder, env=self.environment,
                                          stdin=subprocess.DEVNULL, stdout=journal, stderr=subprocess.STDOUT)
            try:
                self.visit_of_the_service(mirror)
            finally:
                if mirror.poll() is None:
                    mirror.kill()
                mirror.wait()
        finally:
            bus.kill()
            bus.wait()
            bus.stdout.close()

    def visit_of_the_service(self, mirror):
        tick = threading.Event()
        end = time.monotonic() + LIMIT
        looks = 0
        while looks < 5:
            if mirror.poll() is not None:
                raise Failure(f"the mirror ended with status {mirror.returncode}")
            if time.monotonic() > end:
                raise Failure("nobody is dressed")
            asked = subprocess.run([self.chevalctl, "status", "--json", "--bus", "session"], env=self.environment,
                                   cwd=self.folder, timeout=LIMIT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
            self.keep("chevalctl status", asked.stdout + asked.stderr)
            # Somebody is dressed, and then for some seconds more: whoever writes measurements has some by now.
            if asked.stdout.startswith(b"{") and json.loads(asked.stdout)["state"] == "wearing":
                looks += 1
            tick.wait(0.5)
        people = subprocess.run([self.chevalctl, "status", "--bus", "session"], env=self.environment, cwd=self.folder,
                                timeout=LIMIT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.keep("chevalctl status", people.stdout)
        mirror.send_signal(signal.SIGHUP)
        tick.wait(1.0)
        mirror.send_signal(signal.SIGTERM)
        mirror.wait(timeout=LIMIT)


def check(house):
    tracks = house.folder / "tracks.jsonl"
    if not findings("tracks", tracks.read_bytes()):
        raise Failure("the check finds nothing even in the tracks file")
    files = [path for path in sorted(house.folder.rglob("*"))
             if path.is_file() and path != tracks and path != house.settings / "cheval.toml"]
    if house.folder / "journal" not in files or not (house.folder / "journal").stat().st_size:
        raise Failure("the mirror has said nothing at all")
    found = []
    for path in files:
        found += findings(path.relative_to(house.folder), path.read_bytes())
    for name, output in house.said.items():
        found += findings(name, output)
    print(f"{len(files)} files and the output of {len(house.said)} programs")
    if found:
        raise Failure("somebody's measurements, or what looks like them:\n  " + "\n  ".join(found[:40]))


def main():
    with tempfile.TemporaryDirectory(prefix="cheval_privacy_") as name:
        house = House(pathlib.Path(name), sys.argv[1], sys.argv[2])
        try:
            check_the_check()
            house.one_visit()
            house.recording()
            house.service()
            check(house)
        except Failure as failure:
            return str(failure)
    return None


if __name__ == "__main__":
    fault = main()
    sys.exit(f"failed: {fault}" if fault else 0)
