#!/usr/bin/env python3
"""house_check.py finds each fault that it is there to find, and nothing else."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
import house_check  # noqa: E402


class House(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        subprocess.run(["git", "init", "-q", str(self.root)], check=True)

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        subprocess.run(["git", "-C", str(self.root), "add", path], check=True)

    def edge(self, path, header):
        """The faults of one file that includes one header."""
        self.write(path, f"#pragma once\n#include {header}\n")
        faults = list(house_check.check_edges(self.root))
        (self.root / path).unlink()
        return faults

    def test_every_door_to_the_right_is_shut(self):
        for path, header in (
            ("hal/openni/camera.h", '"fitting/mesh.h"'),
            ("hal/replay/camera.h", '"hal/sim/world.h"'),
            ("hal/sim/world.h", '"fitting/body/body.h"'),
            ("hal/sim/world.h", '"render/renderer.h"'),
            ("hal/frame.h", '"hal/depth_camera.h"'),
            ("hal/frame.h", '"fitting/mesh.h"'),
            ("fitting/mesh.h", '"fitting/body/body.h"'),
            ("fitting/tracking/tracker.cpp", '"hal/depth_camera.h"'),
            ("fitting/tracking/tracker.cpp", '"render/hud_state.h"'),
            ("fitting/tracking/tracker.cpp", '"config/settings.h"'),
            ("fitting/garment/garment.cpp", '"fitting/bake/bake.h"'),
            ("fitting/bake/bake.cpp", '"hal/display.h"'),
            ("render/renderer.cpp", '"fitting/body/body.h"'),
            ("render/renderer.cpp", '"daemon/mirror.h"'),
            ("render/hud_state.h", '"render/renderer.h"'),
            ("config/settings.h", '"daemon/mirror.h"'),
            ("config/settings.h", '"fitting/outfit.h"'),
            ("daemon/mirror.cpp", '"fitting/bake/bake.h"'),
            ("daemon/mirror.cpp", '"tests/support/random.h"'),
            ("daemon/mirror.cpp", '"mirror.h"'),
            ("fitting/tracking/tracker.cpp", "<httplib.h>"),
            ("daemon/mirror.cpp", "<libusb.h>"),
            ("hal/openni/camera.cpp", "<libusb-1.0/libusb.h>"),
            ("daemon/mirror.cpp", "<GLES3/gl3.h>"),
            ("daemon/mirror.cpp", "<toml++/toml.h>"),
            ("fitting/tracking/tracker.cpp", "<opencv2/video.hpp>"),
        ):
            with self.subTest(path=path, header=header):
                self.assertEqual(len(self.edge(path, header)), 1)

    def test_the_doors_of_the_design_are_open(self):
        for path, header in (
            ("hal/replay/camera.h", '"hal/png/png.h"'),
            ("hal/sim/world.h", '"fitting/body.h"'),
            ("fitting/mesh.h", '"fitting/skeleton.h"'),
            ("fitting/tracking/tracker.cpp", '"hal/frame.h"'),
            ("fitting/tracking/tracker.cpp", "<opencv2/imgproc.hpp>"),
            ("fitting/layering/fitter.cpp", '"fitting/body/cage_template.h"'),
            ("fitting/bake/bake.cpp", '"render/renderer.h"'),
            ("fitting/bake/bake.cpp", '"hal/png/png.h"'),
            ("render/renderer.cpp", '"fitting/mesh.h"'),
            ("render/renderer.cpp", "<GLES3/gl3.h>"),
            ("config/settings.h", '"hal/expected.h"'),
            ("daemon/mirror.cpp", '"render/renderer.h"'),
            ("daemon/cheval_bake.cpp", '"fitting/bake/bake.h"'),
            ("hal/preview/server.cpp", "<httplib.h>"),
            ("hal/usb/usb_watcher.cpp", "<libusb.h>"),
            ("tests/daemon/mirror_test.cpp", '"tests/support/random.h"'),
        ):
            with self.subTest(path=path, header=header):
                self.assertEqual(self.edge(path, header), [])

    def test_a_header_without_pragma_once_is_a_fault(self):
        self.write("hal/clock.h", "struct Clock;\n")
        self.assertEqual(len(list(house_check.check_edges(self.root))), 1)

    def test_words_that_tell_of_elsewhere_are_faults(self):
        for line in ("// see /wo" + "rk/notes", "x = '/ho" + "me/me'", 'open("/t' + 'mp/x")', "// TO" + "DO: later",
                     "// as iss" + "ue 7 says", "// fixes " + "#12.", "GTEST_" + "SKIP();", "sleep" + "_for(1s);"):
            with self.subTest(line=line):
                self.write("hal/clock.cpp", f"// One line that is fine.\n{line}\n")
                faults = list(house_check.check_words(self.root))
                self.assertEqual(len(faults), 1)
                self.assertTrue(faults[0].startswith("hal/clock.cpp:2: "))

    def test_words_of_the_field_are_no_faults(self):
        self.write("hal/clock.cpp", "// ${dir}/work/x, build/tmp, #fff, #pragma, an issue of trust, &#39;\n#include <x>\n")
        self.assertEqual(list(house_check.check_words(self.root)), [])

    def test_a_folder_without_a_readme_is_a_fault(self):
        self.write("README.md", "x")
        self.write("hal/README.md", "x")
        self.write("hal/clock.h", "x")
        self.write("tests/README.md", "x")
        self.write("tests/hal/clock_test.cpp", "x")
        self.write(".ci/run", "x")
        self.assertEqual(list(house_check.check_readmes(self.root)), [])
        self.write("hal/replay/camera.h", "x")
        self.write("tests/bench/frame.cpp", "x")
        faults = list(house_check.check_readmes(self.root))
        self.assertEqual([fault.split(":")[0] for fault in faults], ["hal/replay/README.md", "tests/bench/README.md"])

    def test_the_list_of_packages_has_known_groups_and_names_each_once(self):
        self.write("config/packages.txt", "# a comment\n\nrun   libegl1  # drawing\nbuild g++\n")
        self.assertEqual(list(house_check.check_packages(self.root)), [])
        self.write("config/packages.txt", "run libegl1\ntests g++\nbuild libegl1\nbuild\nbuild a b\n")
        faults = list(house_check.check_packages(self.root))
        self.assertEqual([fault.split(":")[1] for fault in faults], ["2", "3", "4", "5"])


if __name__ == "__main__":
    unittest.main()
