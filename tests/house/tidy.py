#!/usr/bin/env python3
"""clang-tidy over what changed, once for each state of a file.

    tests/house/tidy.py --build DIR [--base COMMIT | --all] [--budget SECONDS] [--tool clang-tidy-14]

What changed is what differs from --base in the working tree; without it, from where the branch left its upstream, or
else from the last day's work. A changed header is checked through one source that includes it. A source that was found
clean is not looked at again until it, a header of ours that it includes, its compiler flags or .clang-tidy change: its
stamp is in build/tidy/. What does not fit into the budget is counted and left for next time. Exits 1 on a finding.
"""

import argparse
import concurrent.futures
import functools
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
# Headers that the build has precompiled are read as they are written.
PRECOMPILED = re.compile(r"-Winvalid-pch|-fpch-preprocess|-include \S*/cmake_pch\.hxx")
# What the compiler of the build takes and clang does not know must not end the check.
EXTRA = ("--extra-arg=-Wno-unknown-warning-option",)
# Where there is no branch to compare with, this many commits are "the last work".
RECENT_COMMITS = 5


def git(*arguments):
    result = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True)
    return result.stdout.strip() if result.returncode == 0 else None


def base_commit(asked):
    if asked:
        commit = git("rev-parse", "--verify", "--quiet", f"{asked}^{{commit}}")
        if not commit:
            sys.exit(f"tidy: there is no commit '{asked}'.\n  Mend: fetch it, or name another with CHEVAL_BASE.")
        return git("merge-base", commit, "HEAD") or commit
    upstream = git("merge-base", "@{upstream}", "HEAD")
    if upstream and upstream != git("rev-parse", "HEAD"):
        return upstream
    commits = git("rev-list", "--first-parent", f"--max-count={RECENT_COMMITS + 1}", "HEAD").split()
    return commits[-1]


def changed_files(base):
    """Paths that differ from `base`, those changed last first."""
    now = git("diff", "--name-only", "--diff-filter=d", "HEAD") or ""
    committed = git("log", "--first-parent", "--name-only", "--diff-filter=d", "--format=", f"{base}..HEAD") or ""
    return list(dict.fromkeys(now.split("\n") + committed.split("\n")))


@functools.lru_cache(maxsize=None)
def includes_of(path):
    try:
        text = (ROOT / path).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ()
    return tuple(header for header in INCLUDE.findall(text) if (ROOT / header).is_file())


def closure(path):
    """The file and every header of ours below it."""
    seen = {path}
    queue = [path]
    while queue:
        for header in includes_of(queue.pop()):
            if header not in seen:
                seen.add(header)
                queue.append(header)
    return seen


def compile_commands(build):
    entries = json.loads((build / "compile_commands.json").read_text())
    commands = {}
    for entry in entries:
        file = pathlib.Path(entry["file"])
        file = file if file.is_absolute() else pathlib.Path(entry["directory"]) / file
        if file.is_relative_to(ROOT) and not file.is_relative_to(build.resolve()):
            command = entry.get("command") or " ".join(entry["arguments"])
            commands.setdefault(file.relative_to(ROOT).as_posix(), PRECOMPILED.sub("", command))
    return commands


def write_commands(commands, build, folder):
    """compile_commands.json for the tool: it cannot read what another compiler precompiled."""
    entries = [{"directory": str(build.resolve()), "file": str(ROOT / path), "command": command}
               for path, command in commands.items()]
    (folder / "compile_commands.json").write_text(json.dumps(entries))


def select(changed, commands):
    """Sources to check: the changed ones, and for each changed header that none of them includes, one that does."""
    chosen = [path for path in changed if path in commands]
    covered = set().union(*(closure(path) for path in chosen)) if chosen else set()
    for header in changed:
        if not header.endswith(".h") or header in covered:
            continue
        own = header[:-2] + ".cpp"
        users = [own] if own in commands else sorted(
            (path for path in commands if header in closure(path)), key=lambda path: (path.startswith("tests/"), path))
        if users:
            chosen.append(users[0])
            covered |= closure(users[0])
    # The programs before their tests: where time runs out, what runs in shops has been looked at.
    return sorted(dict.fromkeys(chosen), key=lambda path: path.startswith("tests/"))


def stamp_of(path, command, tool):
    key = hashlib.sha256()
    for part in (tool, command, (ROOT / ".clang-tidy").read_text()):
        key.update(part.encode() + b"\0")
    for file in sorted(closure(path)):
        key.update(file.encode() + b"\0" + (ROOT / file).read_bytes())
    return key.hexdigest()


def main():
    parser = argparse.ArgumentParser(description="clang-tidy over what changed, once for each state of a file.")
    parser.add_argument("--build", type=pathlib.Path, required=True, help="folder with compile_commands.json")
    parser.add_argument("--base", help="compare with this commit")
    parser.add_argument("--all", action="store_true", help="check every source, without a budget")
    parser.add_argument("--budget", type=float, default=300.0, help="seconds after which no check is started")
    parser.add_argument("--tool", default="clang-tidy-14")
    parser.add_argument("--list", action="store_true", help="name what would be checked, and check nothing")
    arguments = parser.parse_args()

    commands = compile_commands(arguments.build)
    chosen = sorted(commands) if arguments.all else select(changed_files(base_commit(arguments.base)), commands)
    if arguments.list:
        print("\n".join(chosen))
        return 0
    version = subprocess.run([arguments.tool, "--version"], check=True, capture_output=True, text=True).stdout
    stamps = ROOT / "build" / "tidy"
    stamps.mkdir(parents=True, exist_ok=True)
    write_commands(commands, arguments.build, stamps)
    keys = {path: stamp_of(path, commands[path], version) for path in chosen}
    waiting = [path for path in chosen if not (stamps / keys[path]).exists()]
    deadline = None if arguments.all else time.monotonic() + arguments.budget

    def check(path):
        if deadline is not None and time.monotonic() > deadline:
            return None
        result = subprocess.run([arguments.tool, "-p", str(stamps), "--quiet", *EXTRA, str(ROOT / path)],
                                capture_output=True, text=True)
        if result.returncode == 0:
            (stamps / keys[path]).touch()
            return True
        print(f"{result.stdout.strip()}\n{result.stderr.strip()}\n", flush=True)
        return False

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        results = list(pool.map(check, waiting))
    bad, left = results.count(False), results.count(None)
    print(f"clang-tidy: {len(chosen)} sources to check, {len(chosen) - len(waiting)} of them known to be clean, "
          f"{results.count(True)} found clean, {bad} with findings" +
          (f", {left} left for want of time (next run, or --tidy=all)" if left else ""))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
