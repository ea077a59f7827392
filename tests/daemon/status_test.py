#!/usr/bin/env python3
"""The mirror on the system bus, as technicians and strangers meet it: chevald, chevalctl and our policy on a bus of its own.

    status_test.py CHEVALD CHEVALCTL POLICY

Each wait is for a condition, with a limit that only a fault reaches. What needs other accounts runs as root alone.
"""
import concurrent.futures
import grp
import json
import os
import pathlib
import pwd
import signal
import subprocess
import sys
import tempfile
import threading

LIMIT = 120.0  # Seconds.
CALLS = 1000
STRANGER = {"user": 65534, "group": 65534, "extra_groups": []}
STATE_KEYS = {"version", "uptime_s", "state", "outfit", "view", "outfits", "frames_per_second", "degrade", "visits", "frames",
              "pictures", "renderer", "overall", "health", "tasks", "recovery"}

# The defaults of Debian's own system bus: no method call goes anywhere unless a policy allows it.
BUS = """<busconfig>
  <type>system</type>
  <listen>unix:path={folder}/bus</listen>
  <auth>EXTERNAL</auth>
  <policy context="default">
    <allow user="*"/>
    <deny own="*"/>
    <deny send_type="method_call"/>
    <allow send_type="signal"/>
    <allow send_requested_reply="true" send_type="method_return"/>
    <allow send_requested_reply="true" send_type="error"/>
    <allow receive_type="method_call"/>
    <allow receive_type="method_return"/>
    <allow receive_type="error"/>
    <allow receive_type="signal"/>
    <allow send_destination="org.freedesktop.DBus"/>
  </policy>
  <include>{folder}/policy.conf</include>
</busconfig>
"""

# Nobody can stand so near, so that no shopper changes the clothes between two looks.
SETTINGS = """
[display]
width = 270
height = 480
[zone]
near_m = 0.2
far_m = 0.5
[bus]
kind = "system"
"""


class Failure(Exception):
    pass


def expect(holds, what):
    if not holds:
        raise Failure(what)


def eventually(get, good, what):
    """Looks again and again until it is good, and returns it."""
    tick = threading.Event()
    for _ in range(int(LIMIT / 0.05)):
        value = get()
        if good(value):
            return value
        tick.wait(0.05)
    raise Failure(f"{what}; it is {value!r} after {LIMIT:.0f} s")


class Bus:
    def __init__(self, folder, policy):
        self.folder = folder
        (folder / "bus.conf").write_text(BUS.format(folder=folder))
        (folder / "policy.conf").write_text(policy)
        self.address = f"unix:path={folder}/bus"
        self.process = None

    def start(self):
        self.process = subprocess.Popen(["dbus-daemon", f"--config-file={self.folder}/bus.conf", "--nofork", "--nopidfile",
                                         "--print-address"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        expect(self.process.stdout.readline(), "the bus does not start")

    def end(self):
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process.stdout.close()
            (self.folder / "bus").unlink(missing_ok=True)
            self.process = None


class House:
    """The programs with a bus, settings and a runtime folder of their own."""

    def __init__(self, folder, chevald, chevalctl, policy):
        self.folder, self.chevald, self.chevalctl = folder, chevald, chevalctl
        self.bus = Bus(folder, policy)
        self.settings = folder / "settings" / "cheval.toml"
        for name in ("settings", "run", "run2"):
            (folder / name).mkdir()
        self.settings.write_text(SETTINGS)
        self.mirrors = []

    def environment(self, runtime="run"):
        other = {key: value for key, value in os.environ.items() if key != "RUNTIME_DIRECTORY"}
        return dict(other, DBUS_SYSTEM_BUS_ADDRESS=self.bus.address, XDG_RUNTIME_DIR=str(self.folder / runtime))

    def light(self, runtime="run"):
        log = self.folder / f"log{len(self.mirrors)}"
        with open(log, "w") as out:
            mirror = subprocess.Popen([self.chevald, "--config", self.folder / "settings"], stdin=subprocess.DEVNULL,
                                      stdout=subprocess.DEVNULL, stderr=out, env=self.environment(runtime))
        mirror.log = log
        self.mirrors.append(mirror)
        return mirror

    def ctl(self, *arguments):
        return subprocess.run([self.chevalctl, *arguments], capture_output=True, text=True, env=self.environment(), timeout=LIMIT)

    def status(self):
        """Of a mirror that is lit; None where there is none."""
        done = self.ctl("status", "--json")
        return json.loads(done.stdout) if done.returncode in (0, 4) else None

    def lit(self):
        return eventually(self.status, lambda status: status is not None and status["pictures"] > 0, "it is not lit")

    def send(self, *message, destination="org.cheval.Mirror1", path="/org/cheval/Mirror1", **account):
        return subprocess.run(["dbus-send", f"--bus={self.bus.address}", "--print-reply", f"--dest={destination}", path, *message],
                              capture_output=True, text=True, timeout=LIMIT, **account)

    def end(self):
        for mirror in self.mirrors:
            if mirror.poll() is None:
                mirror.kill()
            mirror.wait()
        self.bus.end()


GET_ALL = ("org.freedesktop.DBus.Properties.GetAll", "string:org.cheval.Mirror1")
NEXT = ("org.cheval.Mirror1.NextOutfit",)


def says_how_it_is(house):
    status = house.lit()
    expect(set(status) == STATE_KEYS, f"its keys are {sorted(status)}")
    parts = {row["part"]: row for row in status["health"]}
    expect(list(parts) == ["sensor", "display", "buttons", "wardrobe", "settings", "loop", "bus"], f"its parts are {list(parts)}")
    expect(parts["display"]["state"] == "absent by design", f"the headless display is {parts['display']}")
    expect(parts["wardrobe"]["state"] == "ok", f"the wardrobe is {parts['wardrobe']}")
    # The first picture may still be on its way.
    eventually(house.status, lambda now: {"ingest", "draw"} <= {row["name"] for row in now["tasks"]}, "its tasks are not listed")
    expect(status["state"] == "idle", f"it is {status['state']} with nobody there")
    eventually(house.status, lambda now: now["frames"] > status["frames"], "its frames stand still")
    for_people = house.ctl("status")
    expect(for_people.returncode == 0 and "Health\n" in for_people.stdout, f"status says {for_people}")
    expect("\033" not in for_people.stdout, "it is coloured without a terminal")


def changes_the_clothes(house):
    outfits = house.ctl("outfit", "list").stdout.split()
    expect(len(outfits) == 5, f"its outfits are {outfits}")
    expect([row["id"] for row in house.status()["outfits"]] == outfits, "status and list disagree")

    def wears(index):
        eventually(house.status, lambda status: status["outfit"] == outfits[index], f"it does not change to {outfits[index]}")

    wears(0)
    for arguments, index in ((("next",), 1), (("next",), 2), (("previous",), 1), (("set", outfits[4]), 4), (("next",), 0),
                             (("set", "T-shirt + Trousers"), 2)):
        done = house.ctl("outfit", *arguments)
        expect(done.returncode == 0, f"outfit {arguments} says {done}")
        wears(index)
    unknown = house.ctl("outfit", "set", "cape")
    expect(unknown.returncode == 1 and '"cape"' in unknown.stderr and all(name in unknown.stderr for name in outfits),
           f"an unknown outfit: {unknown}")
    expect(house.ctl("outfit").returncode == 2, "outfit without a word is no usage error")
    expect(house.send("org.cheval.Mirror1.SetView", "string:avatar").returncode == 0, "SetView is refused")
    eventually(house.status, lambda status: status["view"] == "avatar", "its view does not change")


def survives_wrong_calls(house):
    for message, name in ((("org.cheval.Mirror1.SetOutfit", "int32:5"), "InvalidArgs"),
                          (("org.cheval.Mirror1.NextOutfit", "string:twice"), "InvalidArgs"),
                          (("org.cheval.Mirror1.Explode",), "UnknownMethod"),
                          (("org.cheval.Mirror2.NextOutfit",), "UnknownInterface|UnknownMethod"),
                          (("org.freedesktop.DBus.Properties.Set", "string:org.cheval.Mirror1", "string:State",
                            "variant:string:wearing"), "PropertyReadOnly")):
        done = house.send(*message)
        expect(done.returncode != 0 and any(one in done.stderr for one in name.split("|")), f"{message}: {done}")
    expect(house.status() is not None, "it does not survive wrong calls")


def survives_a_flood(house):
    before = house.status()
    with concurrent.futures.ThreadPoolExecutor(max_workers=8) as pool:
        replies = list(pool.map(lambda _: house.send(*NEXT), range(CALLS)))
    for reply in replies:
        expect(reply.returncode == 0 or "org.cheval.Error.Busy" in reply.stderr, f"a call of the flood: {reply}")
    eventually(house.status, lambda now: now["frames"] > before["frames"] and now["pictures"] > before["pictures"],
               "frames do not go on")


class Listener:
    """What one account hears of the mirror's signals."""

    def __init__(self, house, account):
        self.process = subprocess.Popen(["stdbuf", "-oL", "dbus-monitor", "--address", house.bus.address,
                                         "type='signal',path='/org/cheval/Mirror1'"], stdout=subprocess.PIPE,
                                        stderr=subprocess.DEVNULL, text=True, **account)
        self.lines = []
        self.thread = threading.Thread(target=self.read, daemon=True)
        self.thread.start()
        eventually(lambda: list(self.lines), bool, "dbus-monitor does not start")

    def read(self):
        for line in self.process.stdout:
            self.lines.append(line)

    def hears(self):
        return any("member=PropertiesChanged" in line for line in list(self.lines))

    def end(self):
        self.process.kill()
        self.process.wait()
        self.thread.join(LIMIT)
        self.process.stdout.close()


def denies_strangers(house, member):
    request = ("org.freedesktop.DBus.RequestName", "string:org.cheval.Mirror1", "uint32:3")
    for account, may in ((STRANGER, False), (member, True)):
        for message in (GET_ALL, NEXT, ("org.freedesktop.DBus.Introspectable.Introspect",), ("org.cheval.Mirror1.Reload",)):
            done = house.send(*message, **account)
            expect((done.returncode == 0) == may, f"{account} {'may not' if may else 'may'} call {message}: {done}")
            expect(may or "AccessDenied" in done.stderr, f"{account}, {message}: {done}")
        owns = house.send(*request, destination="org.freedesktop.DBus", path="/org/freedesktop/DBus", **account)
        expect("AccessDenied" in owns.stderr, f"{account} may own the name: {owns}")
    listeners = Listener(house, STRANGER), Listener(house, member)
    try:
        # Once the second has heard two, the first would have heard one.
        for _ in range(2):
            listeners[1].lines.clear()
            expect(house.ctl("outfit", "next").returncode == 0, "outfit next fails")
            eventually(listeners[1].hears, bool, "a member of the group does not hear of a change")
        expect(not listeners[0].hears(), f"a stranger listens in: {listeners[0].lines}")
    finally:
        for listener in listeners:
            listener.end()


def refuses_a_second(house):
    for runtime, words in (("run", "another mirror runs on this machine"), ("run2", "another mirror owns org.cheval.Mirror1")):
        second = house.light(runtime)
        expect(second.wait(LIMIT) == 4, f"a second mirror ends with {second.returncode}")
        text = second.log.read_text()
        expect(words in text and "Mend: " in text, f"a second mirror says {text!r}")
    expect(house.status() is not None, "the first does not survive the second")


def reads_settings_again(house, mirror):
    house.settings.write_text(SETTINGS + "[loop]\nfsp = 20.0\n")
    expect(house.ctl("reload").returncode == 0, "reload fails")

    def settings():
        return next(row for row in house.status()["health"] if row["part"] == "settings")

    bad = eventually(settings, lambda row: row["state"] == "degraded", "refused settings are not told")
    expect("loop.fsp" in bad["reason"], f"refused settings: {bad}")
    house.settings.write_text(SETTINGS + "[loop]\nfps = 20.0\n")
    expect(house.ctl("reload").returncode == 0, "reload fails")
    eventually(settings, lambda row: row["state"] == "ok", "good settings are not taken")
    expect("new settings are in force" in mirror.log.read_text(), "good settings are not in force")


def outlives_its_bus(house):
    before = house.status()["frames"]
    house.bus.end()
    gone = house.ctl("status")
    expect(gone.returncode == 1 and "system bus cannot be reached" in gone.stderr and "Mend: " in gone.stderr, f"without a bus: {gone}")
    house.bus.start()
    after = house.lit()
    expect(after["frames"] > before, "no frame was made while the bus was away")
    eventually(lambda: next(row for row in house.status()["health"] if row["part"] == "bus"), lambda row: row["state"] == "ok",
               "its bus is back and it does not say so")


def tells_a_fault_by_its_exit_status(house):
    house.settings.write_text(SETTINGS + '[sensor]\nsource = "replay"\nfolder = "nothing-here"\n')
    mirror = house.light()
    house.lit()
    done = eventually(lambda: house.ctl("status"), lambda one: one.returncode == 4, "a lost sensor does not give 4")
    expect("sensor    at fault" in done.stdout and "Mend: " in done.stdout, f"a lost sensor: {done.stdout}")
    end(mirror)


def lights_without_a_bus(house):
    house.settings.write_text(SETTINGS)
    house.bus.end()
    mirror = house.light()
    eventually(mirror.log.read_text, lambda text: "drawing with" in text and "system bus cannot be reached" in text,
               "it is dark, or silent, without a bus")
    house.bus.start()
    house.lit()
    end(mirror)


def end(mirror):
    mirror.send_signal(signal.SIGTERM)
    status = mirror.wait(LIMIT)
    expect(status == 0, f"SIGTERM ends it with {status}: {mirror.log.read_text()}")


def account_of_another():
    """One that is not root, with a group to stand for cheval's."""
    user = pwd.getpwnam("games")
    return {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}, grp.getgrgid(user.pw_gid).gr_name


def run(house, member):
    house.bus.start()
    nobody = house.ctl("status")
    expect(nobody.returncode == 1 and "no mirror is running" in nobody.stderr and "Mend: " in nobody.stderr, f"without a mirror: {nobody}")
    mirror = house.light()
    says_how_it_is(house)
    changes_the_clothes(house)
    survives_wrong_calls(house)
    survives_a_flood(house)
    if member is not None:
        denies_strangers(house, member)
    refuses_a_second(house)
    reads_settings_again(house, mirror)
    outlives_its_bus(house)
    # What is killed leaves nothing behind.
    mirror.kill()
    mirror.wait()
    eventually(lambda: house.ctl("status").returncode, lambda status: status == 1, "a killed mirror still answers")
    mirror = house.light()
    house.lit()
    end(mirror)
    expect("no mirror is running" in house.ctl("status").stderr, "an ended mirror still answers")
    tells_a_fault_by_its_exit_status(house)
    lights_without_a_bus(house)


def main():
    chevald, chevalctl, policy = sys.argv[1:]
    text = pathlib.Path(policy).read_text()
    member = None
    if os.geteuid() == 0:
        member, group = account_of_another()
        text = text.replace('group="cheval"', f'group="{group}"')
    else:
        # The policy names accounts that this one is not.
        text = text.replace('user="root"', f'user="{pwd.getpwuid(os.geteuid()).pw_name}"')
    with tempfile.TemporaryDirectory(prefix="cheval_status_") as name:
        folder = pathlib.Path(name)
        # Others must come as far as the bus, to be turned away there.
        folder.chmod(0o755)
        house = House(folder, chevald, chevalctl, text)
        try:
            run(house, member)
        except (Failure, subprocess.TimeoutExpired) as failure:
            for mirror in house.mirrors:
                print(mirror.log.read_text())
            return str(failure)
        finally:
            house.end()
    return None


if __name__ == "__main__":
    fault = main()
    sys.exit(f"failed: {fault}" if fault else 0)
