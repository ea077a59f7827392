#!/usr/bin/env python3
"""Boots a small Debian in a container, with the mirror installed as a service, and plays out what happens to a kiosk.

    boot_test.py --probe                                        exits 0 where such a container can be booted (it needs root)
    boot_test.py --build FOLDER [--cmake CMAKE] [--sanitized]   installs the build and boots it

The container's /usr is this machine's, read-only; /etc and /var are its own; it has no network. What is tried inside is in
inside.py beside this file, which says what passed. It ends with a start that always fails, after which the unit must restart
the "machine": systemd-nspawn exits with 133 then.
"""
import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
LIMIT = 280.0  # Seconds for the whole; reached only where something hangs.
REBOOTED = 133  # What systemd-nspawn --keep-unit exits with when the container restarts itself.
PROBED = 3  # What the probe's container exits with.
PREFIX = "/usr/local"

# Where this machine's settings of libraries are wanted in the container.
SHARED_SETTINGS = ("fonts", "alternatives", "ld.so.cache", "ld.so.conf", "ld.so.conf.d")

# A failure inside ends the container with status 1.
TEST_UNIT = """
[Unit]
Description=What the test does inside
FailureAction=exit-force
FailureActionExitStatus=1
[Service]
Type=exec
ExecStart={command}
StandardOutput=file:/var/report
StandardError=inherit
"""

# In multi-user.target's place: what else this machine's /usr would start there is no part of the test.
TARGET = """
[Unit]
Requires=basic.target
After=basic.target
Wants=cheval.service cheval-test.service
AllowIsolate=yes
"""

# A display that is quick to draw, clothes that are quick to load, under sanitizers too, and a shopper who comes soon.
# Few frames a second: with time enough for each, no task is put off.
SETTINGS = """
[simulation]
pause_s = 0.0
visit_s = 60.0
[display]
width = 270
height = 480
[loop]
fps = 10.0
degrade = false
[wardrobe]
garments = ["tshirt"]
outfits = ["tshirt"]
"""

# The address sanitizer's look for leaks needs ptrace, which the sandbox forbids.
SANITIZER_DROP_IN = """
[Service]
Environment=ASAN_OPTIONS=detect_leaks=0
MemoryMax=infinity
"""


def make_root(root, command):
    for folder in ("usr", "etc/systemd/system/cheval.service.d", "etc/cheval",
                   "proc", "sys", "dev", "run", "tmp", "var"):
        (root / folder).mkdir(parents=True)
    for link in ("bin", "sbin", "lib", "lib64"):
        (root / link).symlink_to(f"usr/{link}")
    # Looked for before anything is mounted.
    shutil.copy("/usr/lib/os-release", root / "etc/os-release")
    (root / "etc/nsswitch.conf").write_text("passwd: files\ngroup: files\nshadow: files\n")
    # Debian makes the bus's user when the package is installed; everybody else comes from sysusers.d.
    (root / "etc/passwd").write_text("root:x:0:0::/root:/bin/sh\nmessagebus:x:100:100::/nonexistent:/usr/sbin/nologin\n")
    (root / "etc/group").write_text("root:x:0:\nmessagebus:x:100:\n")
    units = root / "etc/systemd/system"
    (units / "cheval-test.service").write_text(TEST_UNIT.format(command=command))
    (units / "default.target").write_text(TARGET)


def nspawn(root, *arguments):
    command = ["systemd-nspawn", "--quiet", f"--directory={root}", "--register=no", "--keep-unit", "--private-network",
               "--console=pipe", "--bind-ro=/usr", *arguments]
    return subprocess.run(command, timeout=LIMIT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace")


def probe(root):
    make_root(root, f"/usr/bin/systemctl exit {PROBED}")
    ended = nspawn(root, "--boot")
    return None if ended.returncode == PROBED else f"a container ends with status {ended.returncode}: {ended.stdout}"


def boot(root, build, cmake, sanitized):
    stage = root.parent / "stage"
    subprocess.run([cmake, "--install", build, "--prefix", PREFIX], env={"DESTDIR": str(stage), "PATH": "/usr/bin:/bin"},
                   check=True, stdout=subprocess.DEVNULL)
    make_root(root, "/usr/bin/python3 -B /run/cheval-test/inside.py")
    settings = root / "etc/cheval/cheval.toml"
    settings.write_text(SETTINGS)
    if sanitized:
        (root / "etc/systemd/system/cheval.service.d/sanitizer.conf").write_text(SANITIZER_DROP_IN)
    binds = [f"--bind-ro={stage}{PREFIX}:{PREFIX}", f"--bind-ro={HERE}:/run/cheval-test",
             f"--bind-ro={build}/openni:/run/cheval-openni"]
    for name in SHARED_SETTINGS:
        if pathlib.Path("/etc", name).exists():
            binds.append(f"--bind-ro=/etc/{name}")
    # The bus looks for policies under /usr and /etc alone, whatever the prefix.
    shutil.copytree(stage / PREFIX.lstrip("/") / "share/dbus-1/system.d", root / "etc/dbus-1/system.d")
    ended = nspawn(root, "--boot", *binds)
    report = root / "var/report"
    told = report.read_text(errors="replace") if report.exists() else ""
    print(told or ended.stdout)
    if ended.returncode != REBOOTED:
        return f"the container ended with status {ended.returncode}, not by restarting itself ({REBOOTED})"
    if "ok: the restart limit" not in told:
        return "the container restarted itself, but not at the restart limit"
    print("ok: at the limit the machine is restarted")
    return None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--probe", action="store_true")
    parser.add_argument("--build", type=pathlib.Path)
    parser.add_argument("--cmake", default="cmake")
    parser.add_argument("--sanitized", action="store_true")
    arguments = parser.parse_args()
    if shutil.which("systemd-nspawn") is None:
        return "there is no systemd-nspawn (package systemd-container)"
    # Not under a folder of the build: the container needs a file system that can hold its files' owners.
    with tempfile.TemporaryDirectory(prefix="cheval_boot_") as name:
        root = pathlib.Path(name) / "root"
        root.mkdir()
        try:
            if arguments.probe:
                return probe(root)
            return boot(root, arguments.build, arguments.cmake, arguments.sanitized)
        except subprocess.TimeoutExpired as late:
            report = root / "var/report"
            print(report.read_text(errors="replace") if report.exists() else late.stdout)
            return f"not over after {LIMIT:.0f} s"


if __name__ == "__main__":
    fault = main()
    sys.exit(f"failed: {fault}" if fault else 0)
