#!/usr/bin/env python3
"""Print what the tracker reaches against its goals, in one table.

    tests/fitting/tracking/figures.py [--build DIR] [--visits N] [--threads N] [--keep DIR] [--json FILE]

Recordings that are not ours (CHEVAL_DATA, else ../shared/data) are replayed by `chevalctl replay` and scored by the
score.py beside them; lone hands are read by `chevalctl hands`; the simulated kiosk is judged by `tracking_visits`.
Build first: cmake --build --preset release --target chevalctl tracking_visits.

The exit status is 0 whatever is met, for this is a report, and 1 where a part of it could not be made.
"""

import argparse
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[3]
NORMAL95 = 1.959964
LIMBS = (("elbow", "hand"), ("knee", "foot"))
SWAP_MM = 150.0


def wilson(hits, count):
    """Bounds of a rate in per cent, 95 %."""
    if count == 0:
        return ""
    p, z = hits / count, NORMAL95
    middle = (p + z * z / (2 * count)) / (1 + z * z / count)
    half = z * math.sqrt(p * (1 - p) / count + z * z / (4 * count * count)) / (1 + z * z / count)
    return f"{100 * max(0.0, middle - half):.1f} to {100 * min(1.0, middle + half):.1f} %"


def row(what, goal, reached, count, bounds="", met=None):
    return dict(what=what, goal=goal, reached=reached, count=count, bounds=bounds, met=met)


def rate_row(what, goal, hits, count, met=None):
    reached = f"{100 * hits / count:.1f} %" if count else "-"
    return row(what, goal, reached, str(count), wilson(hits, count), met if count else None)


def run(command, **options):
    """The finished process; its complaint goes to standard error where it failed."""
    done = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False, **options)
    if done.returncode != 0:
        print(f"{' '.join(map(str, command))}: exit status {done.returncode}\n{done.stderr.strip()}", file=sys.stderr)
    return done


def swapped_frames(truth_file, tracks_file):
    """Frames in which exchanging a pair of limbs would lower the error of its joints by 150 mm on average."""
    truth = json.loads(truth_file.read_text(encoding="utf-8"))
    tracks = {}
    for line in tracks_file.read_text(encoding="utf-8").splitlines():
        entry = json.loads(line)
        if "frame" in entry:
            tracks[entry["frame"]] = entry.get("joints") or {}
    swapped = []
    for frame in truth["truth"]:
        joints = tracks.get(frame["frame"], {})
        for limb in LIMBS:
            names = [(f"{side}_{joint}", f"{other}_{joint}")
                     for joint in limb for side, other in (("left", "right"), ("right", "left"))]
            if not all(frame["visible"][own] and joints.get(own) for own, _ in names):
                continue
            gain = sum(math.dist(joints[own][:3], frame["joints"][own]) -
                       math.dist(joints[other][:3], frame["joints"][own]) for own, other in names)
            if gain / len(names) >= SWAP_MM:
                swapped.append(frame["frame"])
                break
    return swapped, len(truth["truth"])


def shopper_rows(chevalctl, data, folder):
    """Rows for the sequences of shared/data/shoppers, or of what else lies there."""
    split = data / "shoppers"
    sequences = sorted(path.parent for path in split.glob("*/truth.json"))
    if not sequences:
        print(f"no sequences in {split}: left out", file=sys.stderr)
        return [], True
    swaps, frames = [], 0
    for sequence in sequences:
        tracks = folder / f"{sequence.name}.jsonl"
        if run([*chevalctl, "replay", sequence, "--tracks", tracks]).returncode != 0:
            return [], False
        found, count = swapped_frames(sequence / "truth.json", tracks)
        swaps += [f"{sequence.name} {frame}" for frame in found]
        frames += count
    summary = folder / "score.json"
    scored = run([sys.executable, "-B", data / "score.py", "--skip", "8", "--split", split, "--predictions", folder,
                  "--json", summary])
    if scored.returncode != 0:
        return [], False
    (folder / "score.txt").write_text(scored.stdout, encoding="utf-8")
    summaries = json.loads(summary.read_text(encoding="utf-8"))
    score = summaries.get("all") or next(iter(summaries.values()))
    within = round(score["within"] * score["n"] / 100)
    claimed, hidden = score["hidden_joints_claimed"]
    rows = [
        row("shoppers: visible joints, mean error", "<= 35 mm", f"{score['mean']:.1f} mm",
            f"{score['n']} joints in frames", f"{score['missed']} missed", score["mean"] <= 35.0),
        rate_row("shoppers: visible joints within 100 mm", ">= 97 %", within, score["n"], score["within"] >= 97.0),
        row("shoppers: left and right exchanged", "never", f"{len(swaps)} frames", f"{frames} frames",
            ", ".join(swaps[:3]), not swaps),
        rate_row("shoppers: hidden joints with confidence >= 0.5", "<= 15 %", claimed, hidden,
                 hidden == 0 or claimed <= 0.15 * hidden),
    ]
    hands = score["hands"].get("raised")
    if hands:
        rows.append(row("shoppers: raised hands, balanced accuracy", ">= 97 %, <= 3 % unknown",
                        f"{hands['balanced']:.1f} %, {hands['unknown']:.1f} % unknown",
                        f"{hands.get('n_open', 0)} open, {hands.get('n_closed', 0)} closed", "",
                        hands["balanced"] >= 97.0 and hands["unknown"] <= 3.0))
    for kind, events in score.get("events", {}).items():
        rows.append(row(f"shoppers: {kind}s", "all found, none invented",
                        f"{events['found']} of {events['true']}, {events['false_alarms']} invented",
                        f"{events['true']} {kind}s", f"{events['neutral']} in neutral spans",
                        events["found"] == events["true"] and events["false_alarms"] == 0))
    return rows, True


def hand_rows(chevalctl, data):
    """Rows for the lone hands of a real sensor; what each shows stands in the table of their README."""
    folder = data / "real-hands"
    if not (folder / "README.md").exists():
        print(f"no {folder}/README.md: left out", file=sys.stderr)
        return [], True
    if not re.search(r"^\s+hands\b", run([*chevalctl, "--help"]).stdout, re.MULTILINE):
        print("chevalctl has no command hands: left out", file=sys.stderr)
        return [], True
    truth = {}
    for line in (folder / "README.md").read_text(encoding="utf-8").splitlines():
        cells = [cell.strip().strip("`") for cell in line.strip().strip("|").split("|")]
        if len(cells) == 4 and cells[0].endswith(".png"):
            truth[cells[0]] = cells[2]
    done = run([*chevalctl, "hands", folder])
    if done.returncode != 0:
        return [], False
    read = {}
    for line in done.stdout.splitlines():
        match = re.match(r"(\S+)\s+(open|closed|unknown)\b", line)
        if match:
            read[pathlib.PurePath(match[1]).name] = match[2]
    palms = [name for name, state in truth.items() if state == "open"]
    others = [name for name, state in truth.items() if state != "open"]
    opened = sum(read.get(name) == "open" for name in palms)
    wrong = sum(read.get(name) == "open" for name in others)
    return [rate_row("real open palms read as open", ">= 95 %", opened, len(palms), opened >= 0.95 * len(palms)),
            rate_row("real hands of other shapes read as open", "none", wrong, len(others), wrong == 0)], True


def simulator_rows(build, arguments, folder):
    program = build / "tests/fitting/tracking/tracking_visits"
    if not program.exists():
        print(f"no {program}: left out", file=sys.stderr)
        return [], False
    report = folder / "visits.json"
    command = [program, "--json", report, "--misses", "--details", "--threads", str(arguments.threads)]
    if arguments.visits:
        command += ["--visits", str(arguments.visits)]
    done = run(command)
    if done.returncode != 0:
        return [], False
    (folder / "visits.txt").write_text(done.stdout, encoding="utf-8")
    return [dict(entry, what="simulator: " + entry["what"]) for entry in json.loads(report.read_text())], True


def print_table(rows):
    titles = dict(what="what", goal="goal", reached="reached", count="of", bounds="95 % bounds", met="met")
    words = {True: "yes", False: "NO", None: ""}
    lines = [titles] + [dict(entry, met=words[entry["met"]]) for entry in rows]
    keys = list(titles)
    widths = {key: max(len(line[key]) for line in lines) for key in keys}
    for line in lines:
        print("  ".join(line[key].ljust(widths[key]) for key in keys).rstrip())
    goals = [entry for entry in rows if entry["met"] is not None]
    print(f"\n{sum(entry['met'] for entry in goals)} of {len(goals)} goals met")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=SOURCE / "build/release")
    parser.add_argument("--visits", type=int, default=0, help="of the simulated kiosk (default: a whole run)")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--keep", type=pathlib.Path, help="keep tracks, scores and misses in this folder")
    parser.add_argument("--json", type=pathlib.Path, help="also write the table to this file")
    arguments = parser.parse_args()
    data = pathlib.Path(os.environ.get("CHEVAL_DATA") or SOURCE.parent / "shared/data").resolve()
    build = arguments.build.resolve()
    chevalctl = [build / "bin/chevalctl", "--config", SOURCE / "config"]
    with tempfile.TemporaryDirectory() as scratch:
        folder = (arguments.keep or pathlib.Path(scratch)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        parts = [shopper_rows(chevalctl, data, folder), hand_rows(chevalctl, data),
                 simulator_rows(build, arguments, folder)]
    rows = [entry for part, _ in parts for entry in part]
    print_table(rows)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0 if all(made for _, made in parts) else 1


if __name__ == "__main__":
    sys.exit(main())
