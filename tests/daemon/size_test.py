#!/usr/bin/env python3
"""chevalctl replay --size says what is wrong with a size, or that a view has its own.

    size_test.py CHEVALCTL
"""
import subprocess
import sys

CASES = {
    "10x10": "120 to 4320",
    "270x10": "160 to 7680",
    "4321x1920": "120 to 4320",
    "270": "like 1080x1920",
    "270x480x": "like 1080x1920",
    "-270x480": "like 1080x1920",
    "99999999999x480": "like 1080x1920",
}


def main():
    faults = 0
    calls = [([f"--size={size}"], expected) for size, expected in CASES.items()]
    calls.append((["--view", "tracking", "--size=1280x960"], "twice the sensor's picture"))
    for options, expected in calls:
        ended = subprocess.run([sys.argv[1], "replay", "no-recording", *options], timeout=120,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if ended.returncode != 2 or expected not in ended.stdout:
            print(f"failed: {' '.join(options)} ended with {ended.returncode} and said: {ended.stdout}", file=sys.stderr)
            faults += 1
    return faults


if __name__ == "__main__":
    sys.exit(1 if main() else 0)
