#!/usr/bin/env python3
"""Installs the build into a scratch folder and has systemd's own tools look at what belongs to them.

    units_test.py --build FOLDER --cmake CMAKE

Passes when systemd-analyze verify finds nothing to say of the unit (with and without the example drop-ins), its sandbox
leaves less exposed than the limit, sysusers and tmpfiles make what the unit needs, and every path follows the prefix.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
LIMIT = 100.0  # Seconds for each command; reached only where it hangs.
EXPOSURE = 15  # Tenths, as systemd-analyze security counts; 0 is nothing and 100 everything.

ARGUMENTS = argparse.ArgumentParser()
ARGUMENTS.add_argument("--build", required=True, type=pathlib.Path)
ARGUMENTS.add_argument("--cmake", default="cmake")


def run(*command, **more):
    return subprocess.run([str(word) for word in command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=LIMIT, check=False, **more)


class Units(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory(prefix="cheval_units_")
        self.addCleanup(self.scratch.cleanup)
        self.folder = pathlib.Path(self.scratch.name)

    def install(self, prefix, stage=""):
        done = run(options.cmake, "--install", options.build, "--prefix", prefix, env={**os.environ, "DESTDIR": str(stage)})
        self.assertEqual(done.returncode, 0, done.stdout)
        return pathlib.Path(f"{stage}{prefix}")

    def installed_unit(self):
        return self.install(self.folder / "usr") / "lib/systemd/system/cheval.service"

    def add_drop_in(self, unit, text):
        folder = unit.with_name("cheval.service.d")
        folder.mkdir(exist_ok=True)
        (folder / "drop-in.conf").write_text(text)

    def test_unit_has_no_fault(self):
        done = run("systemd-analyze", "verify", self.installed_unit())
        self.assertEqual((done.returncode, done.stdout), (0, ""))

    def test_verify_would_tell_a_fault(self):
        # It exits with 0 all the same, which is why the test above looks at what it says.
        unit = self.installed_unit()
        self.add_drop_in(unit, "[Service]\nWatchdogSecs=10\n")
        self.assertIn("WatchdogSecs", run("systemd-analyze", "verify", unit).stdout)

    def test_examples_have_no_fault(self):
        unit = self.installed_unit()
        examples = sorted((self.folder / "usr/share/doc/cheval/examples").glob("*.conf"))
        self.assertTrue(examples)
        for example in examples:
            with self.subTest(example=example.name):
                self.add_drop_in(unit, example.read_text())
                done = run("systemd-analyze", "verify", unit)
                self.assertEqual((done.returncode, done.stdout), (0, ""))

    def exposure(self, unit):
        done = run("systemd-analyze", "security", "--offline=true", f"--threshold={EXPOSURE}", "--no-pager", unit)
        print(done.stdout.splitlines()[-1])
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_sandbox_leaves_little_exposed(self):
        self.exposure(self.installed_unit())

    def test_sandbox_leaves_little_exposed_with_the_preview(self):
        unit = self.installed_unit()
        self.add_drop_in(unit, (self.folder / "usr/share/doc/cheval/examples/preview.conf").read_text())
        self.exposure(unit)

    def test_paths_follow_the_prefix(self):
        stage = self.folder / "stage"
        for prefix in ("/usr", "/opt/mirror"):
            with self.subTest(prefix=prefix):
                place = self.install(prefix, stage)
                text = (place / "lib/systemd/system/cheval.service").read_text()
                self.assertIn(f"ExecStart={prefix}/bin/chevald\n", text)
                self.assertIn(f"Documentation=file://{prefix}/share/doc/cheval/systemd.md\n", text)
                for file in ("bin/chevald", "share/doc/cheval/systemd.md", "lib/sysusers.d/cheval.conf",
                             "lib/tmpfiles.d/cheval.conf", "lib/udev/rules.d/60-cheval.rules"):
                    self.assertTrue((place / file).is_file(), file)
        self.assertNotIn("/usr/bin/chevald", text)

    def test_sysusers_and_tmpfiles_make_what_the_unit_needs(self):
        (self.folder / "etc").mkdir()
        self.install("/usr", self.folder)
        for tool in (("systemd-sysusers",), ("systemd-tmpfiles", "--create")):
            # Twice: every boot finds what the one before made.
            for _ in range(2):
                done = run(*tool, f"--root={self.folder}", "cheval.conf")
                self.assertEqual(done.returncode, 0, done.stdout)
        users = {line.split(":")[0]: line.split(":") for line in (self.folder / "etc/passwd").read_text().splitlines()}
        groups = {line.split(":")[0]: line.split(":") for line in (self.folder / "etc/group").read_text().splitlines()}
        self.assertEqual(users["cheval"][3], groups["cheval"][2])
        self.assertIn("nologin", users["cheval"][6])
        for group in ("plugdev", "gpio", "video", "render"):
            self.assertEqual(groups[group][3], "cheval", group)
        self.assertEqual((self.folder / "etc/cheval/cheval.toml.d").stat().st_mode & 0o777, 0o755)

    def test_catalog_explains_each_message(self):
        ids = set(re.findall(r'"([0-9a-f]{32})"', (SOURCE / "daemon/message_ids.h").read_text()))
        self.assertTrue(ids)
        (self.folder / "var/lib/systemd/catalog").mkdir(parents=True)
        self.install("/usr", self.folder)
        done = run("journalctl", f"--root={self.folder}", "--update-catalog")
        self.assertEqual((done.returncode, done.stdout), (0, ""))
        listed = run("journalctl", f"--root={self.folder}", "--no-pager", "--list-catalog").stdout
        self.assertEqual({line.split()[0] for line in listed.splitlines()}, ids)

    def test_tools_would_tell_a_fault_in_their_files(self):
        (self.folder / "etc").mkdir()
        self.install("/usr", self.folder)
        for kind, tool in (("sysusers.d", ("systemd-sysusers",)), ("tmpfiles.d", ("systemd-tmpfiles", "--create"))):
            file = self.folder / "usr/lib" / kind / "cheval.conf"
            file.write_text(file.read_text() + "q? nonsense\n")
            self.assertNotEqual(run(*tool, f"--root={self.folder}", "cheval.conf").returncode, 0, kind)


if __name__ == "__main__":
    options, rest = ARGUMENTS.parse_known_args()
    unittest.main(argv=[sys.argv[0], *rest], verbosity=2)
