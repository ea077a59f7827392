#!/usr/bin/env python3
"""tidy.py looks at what changed, at nothing twice, and stops where its time is up."""

import contextlib
import io
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import tidy  # noqa: E402


class Tidy(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name).resolve()
        patch = mock.patch.object(tidy, "ROOT", self.root)
        patch.start()
        self.addCleanup(patch.stop)
        tidy.includes_of.cache_clear()
        self.git("init", "-q")
        self.git("config", "user.email", "tests@example.org")
        self.git("config", "user.name", "tests")
        self.write(".clang-tidy", "Checks: '*'\n")
        self.write("hal/clock.h", "#pragma once\n")
        self.write("hal/frame.h", '#pragma once\n#include "hal/clock.h"\n')
        self.write("hal/clock.cpp", '#include "hal/clock.h"\n')
        self.write("hal/camera.cpp", '#include "hal/frame.h"\n')
        self.write("tests/hal/camera_test.cpp", '#include "hal/frame.h"\n')
        # Stands for clang-tidy: notes what it was asked to look at, and finds fault with what says so.
        self.tool = self.write("tool", """#!/bin/sh
            [ "$1" = --version ] && echo 1 && exit
            for file; do :; done
            echo "$file" >>"$(dirname "$0")/asked"
            ! grep fault "$file"
            """)
        self.tool.chmod(0o755)
        self.write(".gitignore", "/build/\n/asked\n")
        build = self.root / "build" / "asan"
        build.mkdir(parents=True)
        sources = ("hal/clock.cpp", "hal/camera.cpp", "tests/hal/camera_test.cpp", "build/asan/made.cpp")
        (build / "compile_commands.json").write_text(json.dumps(
            [{"directory": str(build), "file": str(self.root / source), "command": f"c++ {source}"} for source in sources]))
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "first")

    def git(self, *arguments):
        subprocess.run(["git", "-C", str(self.root), *arguments], check=True, capture_output=True)

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file

    def run_tidy(self, *arguments):
        """Returns the exit status, and the files that the tool was asked to look at."""
        asked = self.root / "asked"
        asked.unlink(missing_ok=True)
        tidy.includes_of.cache_clear()
        command = ["tidy", "--build", str(self.root / "build/asan"), "--tool", str(self.tool), *arguments]
        with mock.patch.object(sys, "argv", command), contextlib.redirect_stdout(io.StringIO()) as said:
            status = tidy.main()
        self.said = said.getvalue()
        lines = asked.read_text().split() if asked.exists() else []
        return status, sorted(pathlib.Path(line).relative_to(self.root).as_posix() for line in lines)

    def test_looks_at_the_source_that_changed_and_at_no_other(self):
        self.write("hal/clock.cpp", '#include "hal/clock.h"\nint changed;\n')
        self.assertEqual(self.run_tidy("--base", "HEAD"), (0, ["hal/clock.cpp"]))

    def test_looks_at_a_changed_header_through_one_source_that_is_not_a_test(self):
        self.write("hal/frame.h", '#pragma once\n#include "hal/clock.h"\nint changed();\n')
        self.assertEqual(self.run_tidy("--base", "HEAD"), (0, ["hal/camera.cpp"]))

    def test_sees_commits_since_the_base(self):
        self.write("hal/camera.cpp", '#include "hal/frame.h"\nint changed;\n')
        self.git("commit", "-q", "-a", "-m", "second")
        self.assertEqual(self.run_tidy("--base", "HEAD~1"), (0, ["hal/camera.cpp"]))
        self.assertEqual(self.run_tidy("--base", "HEAD"), (0, []))

    def test_does_not_look_twice_until_the_source_or_a_header_below_it_changes(self):
        everything = ["hal/camera.cpp", "hal/clock.cpp", "tests/hal/camera_test.cpp"]
        self.assertEqual(self.run_tidy("--all"), (0, everything))
        self.assertEqual(self.run_tidy("--all"), (0, []))
        self.write("hal/frame.h", '#pragma once\n#include "hal/clock.h"\nint changed();\n')
        self.assertEqual(self.run_tidy("--all"), (0, ["hal/camera.cpp", "tests/hal/camera_test.cpp"]))
        self.write(".clang-tidy", "Checks: 'bugprone-*'\n")
        self.assertEqual(self.run_tidy("--all"), (0, everything))

    def test_fails_on_a_finding_and_finds_it_again(self):
        self.write("hal/clock.cpp", "// a fault\n")
        for _ in range(2):
            self.assertEqual(self.run_tidy("--base", "HEAD"), (1, ["hal/clock.cpp"]))

    def test_says_what_is_left_when_the_time_is_up(self):
        self.write("hal/clock.cpp", "int changed;\n")
        self.assertEqual(self.run_tidy("--base", "HEAD", "--budget", "-1"), (0, []))
        self.assertIn("1 left for want of time", self.said)

    def test_refuses_a_base_that_does_not_exist(self):
        with self.assertRaises(SystemExit) as refusal:
            self.run_tidy("--base", "no-such-commit")
        self.assertIn("no-such-commit", str(refusal.exception))


if __name__ == "__main__":
    unittest.main()
