#!/usr/bin/env python3
"""Runs `chevald --once --report` as a person does, on a small display, and looks at what it leaves.

    once_test.py CHEVALD

Passes when it exits with 0 and leaves a contact sheet, an animated picture and the frame budget.
"""
import pathlib
import subprocess
import sys
import tempfile

LIMIT = 500.0  # Seconds; reached only where something hangs.

SETTINGS = """
[sensor]
source = "sim"
[simulation]
visit_s = 6.0
[display]
kind = "headless"
width = 270
height = 480
"""

# Each with the bytes that a file of its kind begins with.
FILES = {"contact-sheet.png": b"\x89PNG\r\n\x1a\n", "visit.webp": b"RIFF", "frame-budget.md": b"#"}


def main():
    with tempfile.TemporaryDirectory(prefix="cheval_once_") as name:
        folder = pathlib.Path(name)
        (folder / "cheval.toml").write_text(SETTINGS)
        report = folder / "report"
        ended = subprocess.run([sys.argv[1], "--config", folder, "--once", "--report", report], timeout=LIMIT,
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        print(ended.stdout)
        if ended.returncode != 0:
            return f"it ended with status {ended.returncode}"
        for file, beginning in FILES.items():
            path = report / file
            if not path.is_file() or not path.read_bytes().startswith(beginning):
                return f"it left no good {file}"
    return None


if __name__ == "__main__":
    fault = main()
    sys.exit(f"failed: {fault}" if fault else 0)
