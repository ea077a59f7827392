#!/usr/bin/env python3
"""Checks of the house that no compiler makes: who may include whom, what no file may say, which folder has a README,
whether the list of packages is one.

    tests/house/house_check.py [--root DIR] edges|words|readmes|packages…

Prints one line a fault, "file:line: what is wrong", and exits 1 if there is any.
"""

import argparse
import pathlib
import re
import subprocess
import sys

ROOMS = ("config", "daemon", "fitting", "hal", "render", "tests")
SOURCES = (".h", ".cpp", ".c")

# The plain types that cross walls, from left to right.
HAL_PLAIN = frozenset(f"hal/{name}.h" for name in ("clock", "expected", "image", "frame", "event"))
FITTING_PLAIN = frozenset(
    f"fitting/{name}.h"
    for name in ("skeleton", "users", "hands", "body", "advice", "mesh", "material", "outfit"))
RENDER_PLAIN = frozenset(("render/hud_state.h",))
PLAIN = HAL_PLAIN | FITTING_PLAIN | RENDER_PLAIN

# What wraps a library is in a folder that names it, or in the one room that it was chosen for.
LIBRARY_HOMES = (
    (re.compile(r"OpenNI\.h|OniCAPI\.h"), ("hal/openni/",)),
    (re.compile(r"Driver/OniDriver.*"), ("hal/sim/openni/",)),
    (re.compile(r"gpiod\.(h|hpp)"), ("hal/gpiod/",)),
    (re.compile(r"libusb(-1\.0/libusb)?\.h"), ("hal/usb/",)),
    (re.compile(r"httplib\.h"), ("hal/preview/",)),
    (re.compile(r"xf86drm(Mode)?\.h|gbm\.h"), ("hal/kms/", "render/")),
    (re.compile(r"spng\.h"), ("hal/png/",)),
    (re.compile(r"(EGL|GLES[23]|GL)/.*"), ("render/",)),
    (re.compile(r"toml\+\+.*|toml\.hpp"), ("config/",)),
    (re.compile(r"CLI/.*"), ("daemon/", "fitting/bake/")),
    (re.compile(r"(sdbus-c\+\+|systemd)/.*"), ("daemon/",)),
    (re.compile(r"opencv2/(?!core|imgproc|ml).*"), ()),
)

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]')


def rooms_allowed(path):
    """A predicate: may the file at `path` include the header of ours named by its argument?"""
    if path.startswith("tests/"):
        return lambda header: True
    if path in PLAIN:
        left = HAL_PLAIN
        if path.startswith(("fitting/", "render/")):
            left = left | FITTING_PLAIN
        if path.startswith("render/"):
            left = left | RENDER_PLAIN
        return lambda header: header in left
    if path.startswith("hal/sim/"):
        return lambda header: header.startswith("hal/") or header in FITTING_PLAIN
    if path.startswith("hal/"):
        return lambda header: header.startswith("hal/") and not header.startswith("hal/sim/")
    if path.startswith("fitting/bake/"):
        # hal/png is a file format and no device: what is made offline is written with it.
        return lambda header: header.startswith(("fitting/", "render/", "hal/png/")) or header in HAL_PLAIN
    if path.startswith("fitting/garment/"):
        # A garment's texture is a PNG within its file.
        return lambda header: header in HAL_PLAIN | {"hal/png/png.h"} or (
            header.startswith("fitting/") and not header.startswith("fitting/bake/"))
    if path.startswith("fitting/"):
        return lambda header: header in HAL_PLAIN or (
            header.startswith("fitting/") and not header.startswith("fitting/bake/"))
    if path.startswith("render/"):
        return lambda header: header.startswith("render/") or header in HAL_PLAIN | FITTING_PLAIN
    if path.startswith("config/"):
        return lambda header: header.startswith("config/") or header in HAL_PLAIN
    # The offline program is a front door of fitting/bake; everything else in daemon/ runs in the shop.
    if path.startswith("daemon/cheval_bake"):
        return lambda header: header.startswith(ROOMS) and not header.startswith("tests/")
    return lambda header: header.startswith(ROOMS) and not header.startswith(("tests/", "fitting/bake/"))


def check_edges(root):
    for room in ROOMS:
        for file in sorted((root / room).rglob("*")):
            if file.suffix not in SOURCES or not file.is_file():
                continue
            path = file.relative_to(root).as_posix()
            allowed = rooms_allowed(path)
            for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
                found = INCLUDE.match(line)
                if not found:
                    continue
                bracket, header = found.groups()
                if bracket == "<":
                    for library, homes in LIBRARY_HOMES:
                        if library.fullmatch(header) and not path.startswith(("tests/",) + homes):
                            yield f"{path}:{number}: <{header}> belongs in {' or '.join(homes) or 'no room'} alone"
                elif header.split("/")[0] not in ROOMS:
                    yield f'{path}:{number}: "{header}" must be named from the root, as in "hal/frame.h"'
                elif not allowed(header):
                    yield f'{path}:{number}: {path.rsplit("/", 1)[0]}/ may not see "{header}"'
            if file.suffix == ".h" and "#pragma once" not in file.read_text(encoding="utf-8"):
                yield f"{path}:1: a header begins with #pragma once"


# Each pattern is written so that it does not match itself.
WORDS = (
    (re.compile(r"(?<![\w.$}])/(?:work|home|root|Users)/\w"), "a path of one machine"),
    (re.compile(r"(?<![\w.$}/])/(?:var/)?tmp\b"), "a path of one machine (ask for a temporary folder)"),
    (re.compile(r"\b(?:TO" + r"DO|FIX" + r"ME|XX" + r"X)\b"), "a plan; do it, or leave it out"),
    (re.compile(r"\b(?:[Ii]ssues?|[Ff]ix(?:es|ed)?|[Cc]loses?|[Ss]ee|PR|MR)\s+#\d|\b[Ii]ssues?\s\d"), "a tracker's number; say the thing itself"),
    (re.compile(r"\bGTEST_" + r"SKIP\b"), "a test that does not run; register it through cheval_data_test"),
    (re.compile(r"\bsleep" + r"_(?:for|until)\b"), "a wait that nothing can end; use the clock's waitUntil"),
)
TEXT = (".h", ".cpp", ".c", ".md", ".txt", ".cmake", ".py", ".toml", ".sh", ".js", ".html", ".css", ".in", ".def", "")


def tracked(root):
    listing = subprocess.run(["git", "-C", str(root), "ls-files", "-z"], check=True, capture_output=True)
    return [name for name in listing.stdout.decode().split("\0") if name]


def check_words(root):
    for path in tracked(root):
        file = root / path
        if file.suffix not in TEXT or not file.is_file() or file.name == "LICENSE":
            continue
        try:
            text = file.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        for number, line in enumerate(text.splitlines(), 1):
            for pattern, reason in WORDS:
                found = pattern.search(line)
                if found:
                    yield f"{path}:{number}: '{found.group(0).strip()}' is {reason}"


def check_readmes(root):
    files = [pathlib.PurePosixPath(path) for path in tracked(root)]
    folders = {parent for path in files for parent in path.parents}
    for folder in sorted(folders, key=str):
        if any(part.startswith(".") for part in folder.parts):
            continue
        # tests/ mirrors the tree: what tests/fitting/body holds is said by fitting/body's README and that of tests/.
        if folder.parts[:1] == ("tests",) and len(folder.parts) > 1 and folder.relative_to("tests") in folders:
            continue
        if folder / "README.md" not in files:
            yield f"{folder}/README.md:1: missing; one paragraph: what lives here, what it may include, what never belongs here"


GROUPS = ("run", "build", "test")


def check_packages(root):
    path = "config/packages.txt"
    seen = {}
    for number, line in enumerate((root / path).read_text(encoding="utf-8").splitlines(), 1):
        words = line.split("#")[0].split()
        if not words:
            continue
        if len(words) != 2 or words[0] not in GROUPS or not re.fullmatch(r"[a-z0-9][a-z0-9.+-]+", words[1]):
            yield f"{path}:{number}: '{line}' is not: GROUP PACKAGE # reason, with a GROUP of {', '.join(GROUPS)}"
        elif words[1] in seen:
            yield f"{path}:{number}: {words[1]} stands in line {seen[words[1]]} too"
        else:
            seen[words[1]] = number


CHECKS = {"edges": check_edges, "words": check_words, "readmes": check_readmes, "packages": check_packages}


def main():
    parser = argparse.ArgumentParser(description="Checks of the house that no compiler makes.")
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[2])
    parser.add_argument("checks", nargs="+", choices=sorted(CHECKS))
    arguments = parser.parse_args()
    faults = [fault for name in arguments.checks for fault in CHECKS[name](arguments.root)]
    for fault in faults:
        print(fault, file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
