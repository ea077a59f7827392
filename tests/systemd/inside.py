"""What boot_test.py does inside its container, as root: it looks at the service as a technician would, with systemctl and
the journal, and does to it what a shop does. Each line that it prints says what passed."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import urllib.request

LIMIT = 60.0  # Seconds for each thing to come true; reached only where it does not.
SHORT_LIMIT = 5.0
HERE = pathlib.Path(__file__).resolve().parent
UNIT = "cheval.service"
LIMIT_MESSAGE = "Start request repeated too quickly"
PORT = 8080
EXAMPLES = pathlib.Path("/usr/local/share/doc/cheval/examples")
SETTINGS = pathlib.Path("/etc/cheval/cheval.toml")
DROP_INS = pathlib.Path("/run/systemd/system/cheval.service.d")


class Failure(Exception):
    pass


def run(*command):
    return subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=LIMIT)


def journal():
    return run("journalctl", "--no-pager", f"--unit={UNIT}", "--output=cat").stdout


def show():
    """The unit's properties."""
    lines = run("systemctl", "show", UNIT).stdout.splitlines()
    return dict(line.split("=", 1) for line in lines if "=" in line)


def wait(what, condition):
    """Waits until condition(properties) holds, and says what came true."""
    began = time.monotonic()
    while True:
        unit = show()
        if condition(unit):
            print(f"ok: {what} ({time.monotonic() - began:.1f} s; {unit['StatusText'] or 'no status'})", flush=True)
            return unit
        if time.monotonic() - began > LIMIT:
            raise Failure(f"not in {LIMIT:.0f} s: {what}; ActiveState={unit['ActiveState']} Result={unit['Result']} "
                          f"NRestarts={unit['NRestarts']} StatusText={unit['StatusText']!r}")
        time.sleep(0.05)


def check(what, good):
    if not good:
        raise Failure(what)
    print(f"ok: {what}", flush=True)


def active(unit):
    return unit["ActiveState"] == "active" and unit["SubState"] == "running"


def fed_after(moment):
    """The watchdog was fed after this moment of READY or feeding: the loop and the renderer both moved on."""
    return lambda unit: active(unit) and int(unit["WatchdogTimestampMonotonic"]) > moment


def starts():
    unit = wait("it starts, says READY and has a status", lambda unit: active(unit) and unit["StatusText"])
    for _ in range(2):
        unit = wait("the watchdog is fed: loop and renderer move on under the sandbox",
                    fed_after(int(unit["WatchdogTimestampMonotonic"])))
    wait("the shopper is dressed", lambda unit: unit["StatusText"].startswith("wearing: ") and "sensor ok" in unit["StatusText"])
    return int(unit["MainPID"])


def sandbox(pid):
    status = dict(line.split(":", 1) for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines())
    check("no privileges can be gained", status["NoNewPrivs"].strip() == "1")
    check("no capability can be had", int(status["CapBnd"], 16) == 0 and int(status["CapEff"], 16) == 0)
    check("system calls are filtered", status["Seccomp"].strip() == "2")
    user = run("id", "-u", "cheval").stdout.strip()
    check("it runs as its own user", user != "0" and status["Uid"].split() == [user] * 4)
    groups = run("id", "-nG", "cheval").stdout.split()
    check("which may open sensors, buttons and the display", {"plugdev", "gpio", "video", "render"} <= set(groups))
    mounts = pathlib.Path(f"/proc/{pid}/mountinfo").read_text().splitlines()
    options = {line.split()[4]: line.split()[5].split(",") for line in mounts}
    check("the system is read-only to it", all("ro" in options[place] for place in ("/", "/usr")))
    check("its state folder is not", "rw" in options["/var/lib/cheval"])
    folder = pathlib.Path("/var/lib/cheval").stat()
    check("and is its own", folder.st_uid == int(user) and folder.st_mode & 0o777 == 0o750)


def sandbox_holds():
    """The installed unit again, with the probe in the mirror's place."""
    text = pathlib.Path(show()["FragmentPath"]).read_text()
    probe = pathlib.Path("/run/systemd/system/cheval-probe.service")
    probe.write_text(text + "[Unit]\nStartLimitAction=none\n[Service]\nType=exec\nRestart=no\nExecStart=\n"
                     f"ExecStart=/usr/bin/python3 -B {HERE}/sandbox_probe.py\nStandardOutput=file:/var/probe\nStandardError=inherit\n"
                     "WatchdogSec=0\nRuntimeDirectoryPreserve=yes\n")
    # Stand-ins for device nodes, which a container cannot make: like these they are opened by their group on a system that is
    # read-only.
    for group, mode in (("plugdev", 0o660), ("root", 0o600)):
        fifo = f"/run/device-of-{group}"
        os.mkfifo(fifo)
        shutil.chown(fifo, "root", group)
        os.chmod(fifo, mode)
    run("systemctl", "daemon-reload")
    run("systemctl", "start", "--wait", probe.name)
    result = run("systemctl", "show", "--value", "--property=Result", probe.name).stdout.strip()
    print(pathlib.Path("/var/probe").read_text(), end="", flush=True)
    check("the sandbox allows what is needed and refuses the rest", result == "success")


def clothes_are_on(_unit):
    told = json.loads(run("/usr/local/bin/chevalctl", "status", "--json").stdout)
    runs = {task["name"]: task["runs"] for task in told["tasks"]}
    return told["overall"] == "ok" and all(runs[task] > 0 for task in ("body", "layering", "animate", "draw", "present"))


def bus():
    told = run("/usr/local/bin/chevalctl", "status")
    check("chevalctl reaches it, by the policy and out of the sandbox", told.returncode == 0)
    wait("every part is well; clothes are fitted, moved and drawn", clothes_are_on)


def reload(pid):
    good = SETTINGS.read_text()
    SETTINGS.write_text(good.replace("[loop]\n", "[loop]\nfsp = 20.0\n"))
    run("systemctl", "reload", UNIT)
    wait("SIGHUP with bad settings: told, and the mirror goes on", lambda unit: active(unit) and "fsp" in unit["StatusText"])
    # Debian does this when a package brings a catalog.
    run("journalctl", "--update-catalog")
    explained = run("journalctl", "--no-pager", f"--unit={UNIT}", "--catalog").stdout
    check("the journal explains it", "chevald --check-config" in explained)
    SETTINGS.write_text(good)
    run("systemctl", "reload", UNIT)
    unit = wait("SIGHUP with good settings", lambda unit: active(unit) and "fsp" not in unit["StatusText"])
    check("it is the same process", int(unit["MainPID"]) == pid)
    unit = wait("the watchdog is fed again", fed_after(int(unit["WatchdogTimestampMonotonic"])))


def started_again(pid, restarts):
    return lambda unit: active(unit) and int(unit["NRestarts"]) == restarts and int(unit["MainPID"]) not in (0, pid)


def faults(pid):
    os.kill(pid, signal.SIGSTOP)
    unit = wait("SIGSTOP: the watchdog ends it, and it starts again", started_again(pid, 1))
    check("the journal says that it was the watchdog", "Watchdog timeout" in journal())
    pid = int(unit["MainPID"])
    os.kill(pid, signal.SIGKILL)
    wait("SIGKILL: it starts again", started_again(pid, 2))


def page_answers(_unit):
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{PORT}/", timeout=SHORT_LIMIT) as page:
            return page.status == 200 and b"<html" in page.read()
    except OSError:
        return False


def preview():
    good = SETTINGS.read_text()
    SETTINGS.write_text(good.replace("[display]", f'[preview]\nenabled = true\nport = {PORT}\n[display]\nkind = "preview"'))
    run("systemctl", "stop", UNIT)
    # What was done to it so far is not to count towards the restart limit.
    run("systemctl", "reset-failed", UNIT)
    run("systemctl", "start", UNIT)
    check("the sandbox keeps the preview from the network", not active(show()) and not page_answers(None))
    drop_in = DROP_INS / "preview.conf"
    DROP_INS.mkdir(parents=True)
    shutil.copy(EXAMPLES / drop_in.name, drop_in)
    run("systemctl", "daemon-reload")
    run("systemctl", "restart", UNIT)
    wait("with the example's drop-in it is on the loopback", page_answers)
    drop_in.unlink()
    SETTINGS.write_text(good)


def sensor_processes():
    found = []
    for comm in pathlib.Path("/proc").glob("[0-9]*/comm"):
        try:
            if comm.read_text().strip() == "cheval-sensor":
                found.append(int(comm.parent.name))
        except OSError:
            continue  # It ended meanwhile.
    return found


def dressed(unit):
    return active(unit) and unit["StatusText"].startswith("wearing: ") and "sensor ok" in unit["StatusText"]


def real_sensor():
    """The real OpenNI2 with a driver that serves the simulated shopper."""
    good = SETTINGS.read_text()
    SETTINGS.write_text('[sensor]\nsource = "openni"\n' + good)
    drop_in = DROP_INS / "sensor.conf"
    drop_in.write_text("[Service]\nEnvironment=LD_LIBRARY_PATH=/run/cheval-openni\n"
                       "Environment=CHEVAL_SIMULATED_SENSOR=sim:visit_s=60,pause_s=0,noise=0\n")
    run("systemctl", "daemon-reload")
    run("systemctl", "reset-failed", UNIT)
    run("systemctl", "restart", UNIT)
    unit = wait("through OpenNI2 and cheval-sensor, under the sandbox, the shopper is dressed", dressed)
    sensors = sensor_processes()
    check("one process reads the sensor", len(sensors) == 1)
    status = dict(line.split(":", 1) for line in pathlib.Path(f"/proc/{sensors[0]}/status").read_text().splitlines())
    check("in the same sandbox", status["Seccomp"].strip() == "2" and status["NoNewPrivs"].strip() == "1"
          and status["Uid"].split()[0] != "0")
    restarts = unit["NRestarts"]
    os.kill(sensors[0], signal.SIGKILL)
    wait("killed, it is started again by the mirror, which goes on",
         lambda unit: dressed(unit) and sensor_processes() not in ([], sensors) and unit["NRestarts"] == restarts)
    drop_in.unlink()
    SETTINGS.write_text(good)
    run("systemctl", "daemon-reload")


def stops():
    run("systemctl", "stop", UNIT)
    unit = show()
    check("it stops when it is told to, and well", unit["ActiveState"] == "inactive" and unit["Result"] == "success")


def limit_reached(_number, _frame):
    """The machine goes down, and this program with it."""
    # systemctl is no help any more, and the journal may be a moment behind.
    until = time.monotonic() + SHORT_LIMIT
    while not (good := LIMIT_MESSAGE in journal()) and time.monotonic() < until:
        time.sleep(0.05)
    print("ok: the restart limit is what ends it" if good else "failed: no restart limit is in the journal", flush=True)
    os._exit(0)


def never_starts():
    # The shorter pause is for the test's time alone; the limit and what comes after it are the unit's own.
    (DROP_INS / "never.conf").write_text(
        "[Service]\nExecStart=\nExecStart=/usr/bin/false\nRestartSec=100ms\n")
    run("systemctl", "daemon-reload")
    signal.signal(signal.SIGTERM, limit_reached)
    # Not waited for: what is to come is the end of this container.
    run("systemctl", "start", "--no-block", UNIT)
    time.sleep(LIMIT)
    unit = show()
    raise Failure(f"in {LIMIT:.0f} s no restart limit had a consequence; Result={unit['Result']} NRestarts={unit['NRestarts']}")


def main():
    pid = starts()
    bus()
    sandbox(pid)
    sandbox_holds()
    reload(pid)
    faults(pid)
    preview()
    real_sensor()
    stops()
    never_starts()


if __name__ == "__main__":
    try:
        main()
    except (Failure, KeyError, OSError, subprocess.SubprocessError) as fault:
        print(f"failed: {fault!r}")
        print(run("journalctl", "--no-pager", "--lines=100", "--output=short-monotonic").stdout, flush=True)
        sys.exit(1)
