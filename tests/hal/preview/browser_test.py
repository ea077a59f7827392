#!/usr/bin/env python3
"""Looks at the mirror's page as a visitor does, in headless Chromium.

    browser_test.py --server 'COMMAND …' [--expect-status-change] [--wears REGEX] [--screenshot FILE]

COMMAND starts a mirror with the preview display, prints its address (http://127.0.0.1:PORT/) on a line of its standard output
and ends with status 0 when it gets SIGTERM. The test passes when the page shows a picture that changes by
itself, Next and the arrow keys reach the mirror, the picture differs after Next (see --differ), the status line is live, and
the browser's console holds no error. Needs Debian's chromium and chromium-driver, and nothing beyond Python's standard library.
"""
import argparse
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request

LIMIT = 60.0  # Seconds for each thing to come about; reached only where it does not.

# Draws the picture as it is now on a grid of 36 by 64 cells, each the mean of its pixels.
GRID = """
const image = document.getElementById('picture');
const canvas = document.createElement('canvas');
canvas.width = 36; canvas.height = 64;
const context = canvas.getContext('2d', {willReadFrequently: true});
context.imageSmoothingQuality = 'high';
context.drawImage(image, 0, 0, 36, 64);
return Array.from(context.getImageData(0, 0, 36, 64).data).filter((_, i) => i % 4 !== 3);
"""


class Failure(Exception):
    pass


class Driver:
    """The few WebDriver commands that are needed."""

    def __init__(self, folder):
        chromium, chromedriver = shutil.which("chromium"), shutil.which("chromedriver")
        if not chromium or not chromedriver:
            raise Failure("chromium and chromedriver are needed (Debian: chromium, chromium-driver)")
        self.process = subprocess.Popen(
            [chromedriver, "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True)
        self.session = None
        port = wait_for_line(self.process, r"started successfully on port (\d+)")
        self.base = f"http://127.0.0.1:{port}"
        arguments = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
                     "--disable-background-networking", "--disable-component-update", "--disable-sync",
                     "--disable-dev-shm-usage", "--window-size=900,1200", f"--user-data-dir={folder}"]
        answer = self.call("POST", "/session", {"capabilities": {"alwaysMatch": {
            "browserName": "chrome", "goog:chromeOptions": {"binary": chromium, "args": arguments},
            "goog:loggingPrefs": {"browser": "ALL"}}}})
        self.session = answer["sessionId"]

    def call(self, method, path, body=None):
        if self.session:
            path = f"/session/{self.session}{path}"
        data = None if method != "POST" else json.dumps(body or {}).encode()
        request = urllib.request.Request(self.base + path, data=data, method=method)
        request.add_header("Content-Type", "application/json")
        try:
            with urllib.request.urlopen(request, timeout=LIMIT) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise Failure(f"{method} {path}: {error.read().decode(errors='replace')[:500]}") from error

    def run(self, script):
        return self.call("POST", "/execute/sync", {"script": script, "args": []})

    def next_frame(self):
        self.call("POST", "/execute/async", {"script": "requestAnimationFrame(arguments[0]);", "args": []})

    def click(self, selector):
        found = self.call("POST", "/element", {"using": "css selector", "value": selector})
        self.call("POST", f"/element/{next(iter(found.values()))}/click")

    def key(self, code):
        self.call("POST", "/actions", {"actions": [{"type": "key", "id": "keys", "actions": [
            {"type": "keyDown", "value": code}, {"type": "keyUp", "value": code}]}]})

    def close(self):
        try:
            if self.session:
                self.call("DELETE", "")
        except (Failure, OSError):
            pass
        finally:
            stop(self.process)


def stop(process):
    """Ends a process that this test started, and what it started."""
    try:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait(timeout=LIMIT)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    except ProcessLookupError:
        process.wait()


def wait_for_line(process, pattern):
    """The first group of the first line of the process's output that matches. Goes on reading, so that it is never blocked."""
    found, done = [], threading.Event()

    def read():
        for line in process.stdout:
            match = None if found else re.search(pattern, line)
            if match:
                found.append(match.group(1))
                done.set()
        done.set()

    threading.Thread(target=read, daemon=True).start()
    if not done.wait(LIMIT) or not found:
        raise Failure(f"{process.args[0]} printed nothing like {pattern!r} within {LIMIT:.0f} s")
    return found[0]


def until(driver, what, condition):
    """Asks once a frame of the page until it holds. The limit fails the test; how long it takes does not matter."""
    end = time.monotonic() + LIMIT
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise Failure(f"never came about: {what}")
        driver.next_frame()


def difference(one, other):
    """Mean absolute difference of two grids, 0 … 255."""
    return sum(abs(a - b) for a, b in zip(one, other)) / len(one)


def central(grid):
    """The middle of the picture, where the shopper stands."""
    return [grid[(y * 36 + x) * 3 + c] for y in range(16, 52) for x in range(10, 26) for c in range(3)]


def look(driver, address, arguments):
    driver.call("POST", "/url", {"url": address})
    until(driver, "the picture is there", lambda: driver.run("return document.getElementById('picture').naturalWidth > 0"))
    until(driver, "the status line says Live", lambda: driver.run("return document.getElementById('line').dataset.state") == "live")

    first = driver.run(GRID)
    if max(first) - min(first) < 10:
        raise Failure("the picture is of one colour")
    until(driver, "the picture changes by itself", lambda: difference(first, driver.run(GRID)) > 0.05)

    def mirror():
        return driver.run("const r = new XMLHttpRequest(); r.open('GET', '/status.json', false); r.send(); return JSON.parse(r.responseText);")

    def worn():
        found = re.search(arguments.wears, mirror()["status"])
        return found and found.group(1)

    clothes = until(driver, "somebody wears something", worn) if arguments.wears else None
    before = mirror()
    if arguments.expect_status_change:
        until(driver, "the page shows the mirror's status", lambda: driver.run("return document.getElementById('status').textContent"))
    # How much the middle changes by itself, as a measure for what Next changes.
    samples = [central(driver.run(GRID)) for _ in range(20)]
    still = max(difference(samples[0], sample) for sample in samples)
    driver.click("button[data-button=next]")
    until(driver, "the mirror takes Next", lambda: mirror()["buttons"] == before["buttons"] + 1)
    if arguments.expect_status_change:
        until(driver, "the status line changes with Next", lambda: mirror()["status"] != before["status"])
    if arguments.wears:
        until(driver, f"after Next something else than {clothes} is worn", lambda: worn() not in (None, clothes))
    until(driver, f"the picture differs after Next by more than {arguments.differ} (by itself: {still:.1f})",
          lambda: min(difference(central(driver.run(GRID)), sample) for sample in samples) > arguments.differ)

    for code, name in (("\ue014", "right"), ("\ue012", "left"), ("\ue013", "up")):
        count = mirror()["buttons"]
        driver.key(code)
        until(driver, f"the mirror takes the {name} arrow key", lambda: mirror()["buttons"] > count)

    if arguments.screenshot:
        import base64
        with open(arguments.screenshot, "wb") as file:
            file.write(base64.b64decode(driver.call("GET", "/screenshot")))
    errors = [entry for entry in driver.call("POST", "/se/log", {"type": "browser"}) if entry["level"] in ("SEVERE", "WARNING")]
    if errors:
        raise Failure("the browser's console is not clean: " + json.dumps(errors, indent=1))
    print(f"passed: presented {mirror()['presented']}, changes by itself {still:.2f}, buttons {mirror()['buttons']}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", required=True, help="command that starts the mirror and prints its address")
    parser.add_argument("--differ", type=float, default=1.5, help="least mean change of the picture's middle by Next, 0 … 255")
    parser.add_argument("--expect-status-change", action="store_true", help="Next must change the status text")
    parser.add_argument("--wears", help="pattern of the status while clothes are worn, its group their name: Next must change it")
    parser.add_argument("--screenshot", help="leave a PNG of the page here")
    arguments = parser.parse_args()
    server = subprocess.Popen(shlex.split(arguments.server), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                              start_new_session=True)
    driver = None
    with tempfile.TemporaryDirectory(prefix="cheval_browser_", ignore_cleanup_errors=True) as folder:
        try:
            address = wait_for_line(server, r"(http://127\.0\.0\.1:\d+/)")
            driver = Driver(folder)
            look(driver, address, arguments)
        except Failure as failure:
            print(f"failed: {failure}", file=sys.stderr)
            return 1
        finally:
            if driver:
                driver.close()
            stop(server)
    if server.returncode != 0:
        print(f"failed: the mirror ended with status {server.returncode}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
