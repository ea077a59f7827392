#!/usr/bin/env python3
"""Print what the measurement of the body reaches against its goals, as a table in Markdown, and draw two pictures.

    tests/fitting/body/figures.py [--build DIR] [--visits N] [--wide N] [--threads N] [--until SECONDS] [--noise X]
                                  [--keep DIR] [--json FILE]

Recordings that are not ours (CHEVAL_DATA, else ../shared/data) are replayed by `chevalctl replay` and scored by the
score.py beside them; the simulated kiosk's people, whose girths are known, are measured by `body_visits` in tight and
in loose clothes, and some in wide coats, of whom nothing should be told. `body_plots` draws convergence.png and
error-by-stature.png into --keep (default: figures-body in the build folder), where tracks and visits are kept too. 400
visits are about 70 minutes of one processor.
Build first: cmake --build --preset release --target chevalctl body_visits body_plots.

The exit status is 0 whatever is met, for this is a report, and 1 where a part of it could not be made.
"""

import argparse
import json
import math
import os
import pathlib
import subprocess
import sys

SOURCE = pathlib.Path(__file__).resolve().parents[3]
NORMAL95 = 1.959964
GIRTHS = ("chest_girth", "waist_girth", "hip_girth")
LENGTHS = ("shoulder_breadth", "arm_length", "inside_leg")
# Mean absolute errors in millimetres that the recorded shoppers are held to.
SHOPPER_GOALS = {"stature": 12.0, **dict.fromkeys(LENGTHS, 15.0), **dict.fromkeys(GIRTHS, 20.0), "neck_girth": None}
GIRTH_GOALS = {"tight": 15.0, "loose": 25.0}
SINGLE_LETTER_GOALS = {"tight": 0.70, "loose": 0.30}


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


def quantile(values, share):
    values = sorted(values)
    place = share * (len(values) - 1)
    lower = int(place)
    upper = min(lower + 1, len(values) - 1)
    return values[lower] + (place - lower) * (values[upper] - values[lower])


def run(command):
    """The finished process; its complaint goes to standard error where it failed."""
    done = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    if done.returncode != 0:
        print(f"{' '.join(map(str, command))}: exit status {done.returncode}\n{done.stderr.strip()}", file=sys.stderr)
    return done


def shopper_rows(chevalctl, data, folder):
    """Rows for the sequences of shared/data/shoppers."""
    split = data / "shoppers"
    sequences = sorted(path.parent for path in split.glob("*/truth.json"))
    if not sequences:
        print(f"no sequences in {split}: left out", file=sys.stderr)
        return [], True
    for sequence in sequences:
        if run([*chevalctl, "replay", sequence, "--tracks", folder / f"{sequence.name}.jsonl"]).returncode != 0:
            return [], False
    summary = folder / "score.json"
    if run([sys.executable, "-B", data / "score.py", "--split", split, "--predictions", folder, "--json",
            summary]).returncode != 0:
        return [], False
    summaries = json.loads(summary.read_text(encoding="utf-8"))
    score = summaries.get("all") or next(iter(summaries.values()))
    rows = []
    for name, goal in SHOPPER_GOALS.items():
        told = score["measurements"].get(name)
        words = "" if goal is None else f"<= {goal:.0f} mm, all told"
        if told is None:
            rows.append(row(f"shoppers: {name}", words, "not told", f"0 of {len(sequences)}", "",
                            None if goal is None else False))
            continue
        error, bias = 10.0 * told["mean_abs"], 10.0 * told["bias"]
        rows.append(row(f"shoppers: {name}", words, f"{error:.1f} mm", f"{told['n']} of {len(sequences)}",
                        f"bias {bias:+.1f} mm", None if goal is None else error <= goal and
                        told["n"] == len(sequences)))
    return rows, True


def errors_of(visits, name):
    """(measured - true, standard uncertainty) in metres of the visits that tell the dimension at their end."""
    told = [(visit["truth"][name], visit["moments"]["end"]["values"][name]) for visit in visits
            if name in visit["moments"].get("end", {}).get("values", {})]
    return [(measured - truth, uncertainty) for truth, (measured, uncertainty) in told]


def dimension_row(clothing, visits, name, goal):
    errors = errors_of(visits, name)
    what = f"{clothing}: {name}"
    words = "" if goal is None else f"<= {goal:.0f} mm"
    if not errors:
        return row(what, words, "not told", f"0 of {len(visits)}", "", None if goal is None else False)
    mean = 1000.0 * sum(abs(error) for error, _ in errors) / len(errors)
    bias = 1000.0 * sum(error for error, _ in errors) / len(errors)
    most = 1000.0 * quantile([abs(error) for error, _ in errors], 0.9)
    return row(what, words, f"{mean:.1f} mm", f"{len(errors)} of {len(visits)}",
               f"bias {bias:+.1f} mm, 90 % under {most:.0f} mm", None if goal is None else mean <= goal)


def coverage_row(what, errors):
    hits = sum(abs(error) <= NORMAL95 * uncertainty for error, uncertainty in errors)
    return rate_row(what, "90 to 97 %", hits, len(errors), bool(errors) and 0.90 <= hits / len(errors) <= 0.97)


def convergence_row(clothing, visits):
    seconds = [visit["converged"] for visit in visits if visit["converged"] is not None]
    what = f"{clothing}: steady after, 95 %"
    if not seconds:
        return row(what, "<= 2 s of facing", "never", f"0 of {len(visits)}", "", False)
    late = quantile(seconds, 0.95)
    return row(what, "<= 2 s of facing", f"{late:.2f} s", f"{len(seconds)} of {len(visits)}",
               f"median {quantile(seconds, 0.5):.2f} s", late <= 2.0)


def advice_rows(clothing, visits):
    """Rows for the advice about sizes. A visit's "advice", where it has one, is a list of {"chart", "true": the letter
    that a tape would give, "letters": those named, none for a refusal}."""
    advice = [one for visit in visits for one in visit.get("advice", [])]
    if not advice:
        return []
    named = [one for one in advice if one["letters"]]
    right = sum(one["true"] in one["letters"] for one in named)
    single = sum(len(one["letters"]) == 1 for one in named)
    refused = len(advice) - len(named)
    goal = SINGLE_LETTER_GOALS[clothing]
    return [
        rate_row(f"{clothing}: true size among those named", ">= 95 %", right, len(named),
                 bool(named) and right >= 0.95 * len(named)),
        rate_row(f"{clothing}: one size named", f">= {100 * goal:.0f} %", single, len(named),
                 bool(named) and single >= goal * len(named)),
        rate_row(f"{clothing}: no size named", "<= 20 %", refused, len(advice), refused <= 0.20 * len(advice)),
    ]


def simulator_rows(clothing, visits):
    rows = [dimension_row(clothing, visits, name, GIRTH_GOALS[clothing]) for name in GIRTHS]
    rows += [dimension_row(clothing, visits, name, None) for name in ("stature", *LENGTHS, "neck_girth")]
    rows.append(coverage_row(f"{clothing}: girths within 1.96 uncertainties",
                             [error for name in GIRTHS for error in errors_of(visits, name)]))
    rows.append(coverage_row(f"{clothing}: other lengths within 1.96 uncertainties",
                             [error for name in ("stature", *LENGTHS) for error in errors_of(visits, name)]))
    rows.append(convergence_row(clothing, visits))
    return rows + advice_rows(clothing, visits)


def wide_rows(visits):
    """Who wears a wide coat is to be told so."""
    doubts = [visit["moments"]["end"]["doubt"] for visit in visits if "end" in visit["moments"]]
    return [rate_row("wide coats: doubted for their clothes", "", doubts.count("loose clothes"), len(doubts))]


def visits_of(program, clothing, count, arguments, folder):
    """What body_visits wrote, or None where it failed."""
    report = folder / f"{clothing}.json"
    command = [program, "--clothing", clothing, "--visits", str(count), "--threads", str(arguments.threads),
               "--noise", str(arguments.noise), "--json", report]
    if arguments.until:
        command += ["--until", str(arguments.until)]
    done = run(command)
    if done.returncode != 0:
        return None
    (folder / f"{clothing}.txt").write_text(done.stdout, encoding="utf-8")
    return json.loads(report.read_text(encoding="utf-8"))


def print_table(rows):
    words = {True: "yes", False: "**no**", None: ""}
    print("| what | goal | reached | told | bounds | met |\n|---|---|---|---|---|---|")
    for one in rows:
        print(f"| {one['what']} | {one['goal']} | {one['reached']} | {one['count']} | {one['bounds']} | "
              f"{words[one['met']]} |")
    goals = [one for one in rows if one["met"] is not None]
    print(f"\n{sum(one['met'] for one in goals)} of {len(goals)} goals met")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=SOURCE / "build/release")
    parser.add_argument("--visits", type=int, default=200, help="of the simulated kiosk, in each kind of clothes")
    parser.add_argument("--wide", type=int, default=20, help="visits in wide coats")
    parser.add_argument("--noise", type=float, default=1.0, help="of the simulated sensor, in times of the usual")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--until", type=float, default=0.0, help="end each visit after so many seconds of facing")
    parser.add_argument("--keep", type=pathlib.Path, help="folder of pictures, tracks and visits")
    parser.add_argument("--json", type=pathlib.Path, help="also write the table to this file")
    arguments = parser.parse_args()
    data = pathlib.Path(os.environ.get("CHEVAL_DATA") or SOURCE.parent / "shared/data").resolve()
    build = arguments.build.resolve()
    folder = (arguments.keep or build / "figures-body").resolve()
    folder.mkdir(parents=True, exist_ok=True)
    rows, made = shopper_rows([build / "bin/chevalctl", "--config", SOURCE / "config"], data, folder)
    program = build / "tests/fitting/body/body_visits"
    reports = []
    for clothing in GIRTH_GOALS:
        visits = visits_of(program, clothing, arguments.visits, arguments, folder)
        if visits is None:
            made = False
            continue
        rows += simulator_rows(clothing, visits)
        reports.append(folder / f"{clothing}.json")
    if arguments.wide:
        visits = visits_of(program, "wide", arguments.wide, arguments, folder)
        made = visits is not None and made
        rows += wide_rows(visits or [])
    if reports:
        made = run([build / "tests/fitting/body/body_plots", folder, *reports]).returncode == 0 and made
    print_table(rows)
    print(f"\nPictures: {folder}/convergence.png and error-by-stature.png")
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0 if made else 1


if __name__ == "__main__":
    sys.exit(main())
