#!/usr/bin/env python3
"""Asks bash for what it offers after each beginning of a command line, and holds it against --help.

    completion_test.py COMPLETION PROGRAM…

Passes when every subcommand and every option that --help lists, at every level, is offered there; options with a few values
offer those; and without a mirror nothing is offered, or said, for its outfits.
"""
import os
import pathlib
import re
import subprocess
import sys

LIMIT = 60.0  # Seconds for one call; reached only where it hangs.


def entries(text, heading):
    """The lines under a heading of --help, each with those that go on with it."""
    found = re.search(rf"^{heading}:\n((?: .*\n)+)", text, re.MULTILINE)
    return re.sub(r"\n {10,}", " ", found.group(1)).splitlines() if found else []


def help_of(program, path):
    return subprocess.run([program, *path, "--help"], capture_output=True, text=True, check=True, timeout=LIMIT).stdout


def offered(completion, program, words):
    """What bash offers for the last of `words`."""
    script = f'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); ' \
             '_cheval "$1" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"; printf "%s\\n" "${COMPREPLY[@]}"'
    done = subprocess.run(["bash", "-c", script, "bash", completion, program, *words], capture_output=True, text=True, timeout=LIMIT,
                          env=dict(os.environ, DBUS_SYSTEM_BUS_ADDRESS="unix:path=/nonexistent/bus"))
    if done.returncode != 0 or done.stderr:
        raise AssertionError(f"{words}: status {done.returncode}, {done.stderr!r}")
    return {line for line in done.stdout.splitlines() if line}


def check(completion, program, path, inherited, faults):
    text = help_of(program, path)
    where = " ".join([pathlib.Path(program).name, *path])
    subcommands = {line.split()[0] for line in entries(text, "Subcommands")}
    options = set(inherited)
    for line in entries(text, "Options"):
        names = line.split()[0].split(",")
        options.update(names)
        values = re.match(r"  \S+ [A-Z]+:\{([^}]*)\}", line)
        if values:
            for name in names:
                if offered(completion, program, [*path, name, ""]) != set(values.group(1).split(",")):
                    faults.append(f"{where} {name}: its values are not offered")
    if not options:
        faults.append(f"{where}: --help lists no option")
    missing = options - offered(completion, program, [*path, "-"])
    if missing:
        faults.append(f"{where}: not offered: {sorted(missing)}")
    if subcommands and offered(completion, program, [*path, ""]) != subcommands:
        faults.append(f"{where}: subcommands are {sorted(subcommands)}, offered are {sorted(offered(completion, program, [*path, '']))}")
    count = 1
    for name in sorted(subcommands):
        count += check(completion, program, [*path, name], options, faults)
    return count


def main():
    completion, programs = sys.argv[1], sys.argv[2:]
    faults = []
    levels = 0
    for program in programs:
        levels += check(completion, program, [], (), faults)
    # A program with no subcommand at all would pass by itself.
    if levels < len(programs) + 5:
        faults.append(f"only {levels} levels of subcommands were found")
    control = programs[0]
    if offered(completion, control, ["outfit", "set", ""]):
        faults.append("outfits are offered although no mirror runs")
    if offered(completion, control, ["re"]) != {"record", "replay", "reload"}:
        faults.append("a beginning of a subcommand is not completed")
    folder = str(pathlib.Path(completion).parent)
    if f"{folder}/README.md" not in offered(completion, control, ["replay", f"{folder}/READ"]):
        faults.append("files are not offered where one is due")
    return "\n".join(faults) or None


if __name__ == "__main__":
    fault = main()
    sys.exit(f"failed: {fault}" if fault else 0)
