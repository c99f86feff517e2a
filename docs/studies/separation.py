#!/usr/bin/env python3
"""Writes docs/studies/separation.md: look-alikes before and after the motion of `armident excite --for`.

    docs/studies/separation.py [--seeds 10]

Needs the program (ARMIDENT, else target/release/armident) and nothing else.
"""

import argparse
import datetime
import json
import math
import os
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("ARMIDENT", str(ROOT / "target/release/armident"))
URDF = ROOT / "urdf/planar_3r.urdf"
BUDGET_S = 3
# middle [rad], amplitude [rad] and frequency [Hz] of each joint on the first recording
ONE_JOINT = [(0.2, 0.0, 1.0), (0.4, 0.8, 0.4), (0.3, 0.0, 1.0)]
SLOW = [(0.2, 0.3, 0.15), (0.4, 0.25, 0.21), (0.3, 0.3, 0.13)]
CASES = [
    ("torque_scale", "joint_2", "1.15", "one joint swings", ONE_JOINT),
    ("rotor_inertia", "joint_2", "0.3", "one joint swings", ONE_JOINT),
    ("quadratic_drag", "joint_2", "1", "slow swings of all joints", SLOW),
]


def armident(*args, cwd):
    ran = subprocess.run([PROGRAM, *map(str, args)], cwd=cwd, capture_output=True, text=True)
    if ran.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, args))}: {ran.stderr}")
    return ran.stdout


def write_swings(path, swings, seconds=12, rate_hz=100):
    with open(path, "w") as file:
        file.write("t," + ",".join(f"joint_{k + 1}/position" for k in range(len(swings))) + "\n")
        for k in range(seconds * rate_hz + 1):
            t = k / rate_hz
            rise = 0.5 - 0.5 * math.cos(math.pi * min(t, seconds - t, 1.0))
            values = (c + rise * a * math.sin(2 * math.pi * f * t) for c, a, f in swings)
            file.write(f"{t:.3f}," + ",".join(f"{value:.9f}" for value in values) + "\n")


def simulate(motion, out, effect, seed, cwd):
    armident(
        "simulate", URDF, motion, "-o", out, "--torque-noise", 0.1, "--encoder-bits", 20, "--seed", seed,
        "--effect", effect, "-q", cwd=cwd,
    )  # fmt: skip


def diagnose(recordings, cwd):
    armident("diagnose", URDF, *recordings, "--json", "d.json", "-q", cwd=cwd)
    return json.loads((cwd / "d.json").read_text())["findings"]


def state(findings, truth):
    """`A or B`, the right name alone, another name alone, or nothing."""
    if not findings:
        return "nothing"
    if any(finding["alternatives"] for finding in findings):
        return "open"
    names = [(finding["effect"], finding["joints"]) for finding in findings]
    return "right" if names == [truth] else "wrong"


def study(effect, joint, value, swings, seed, folder):
    truth = (effect, [joint])
    placed = f"{effect}:{joint}={value}"
    write_swings(folder / "first.csv", swings)
    simulate("first.csv", "a.csv", placed, seed, folder)
    before = state(diagnose(["a.csv"], folder), truth)
    if before != "open":
        return before, None, None
    armident(
        "excite", URDF, "-o", "next", "--for", "d.json", "--seconds", 10, "--budget", BUDGET_S, "--seed", seed, "-q",
        cwd=folder,
    )  # fmt: skip
    simulate("next/separation.csv", "b.csv", placed, 100 + seed, folder)
    simulate("first.csv", "c.csv", placed, 200 + seed, folder)
    after = state(diagnose(["a.csv", "b.csv"], folder), truth)
    repeated = state(diagnose(["a.csv", "c.csv"], folder), truth)
    return before, after, repeated


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=10)
    given = parser.parse_args()
    lines = [
        "| effect | first recording | open | decided by the proposed motion | rightly | decided by the first motion again | "
        "rightly |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for effect, joint, value, words, swings in CASES:
        found = []
        for seed in range(1, given.seeds + 1):
            with tempfile.TemporaryDirectory() as folder:
                found.append(study(effect, joint, value, swings, seed, Path(folder)))
                print(effect, seed, found[-1], flush=True)
        still_open = [(after, again) for before, after, again in found if before == "open"]
        count = lambda k, *states: sum(row[k] in states for row in still_open)
        lines.append(
            f"| {effect} | {words} | {len(still_open)} of {len(found)} | {count(0, 'right', 'wrong')} | {count(0, 'right')} | "
            f"{count(1, 'right', 'wrong')} | {count(1, 'right')} |"
        )
    version = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True).stdout.strip()
    table = "\n".join(lines)
    page = f"""# Look-alikes before and after a motion of `excite --for`

{version}, {datetime.date.today()}. Made by `docs/studies/separation.py --seeds {given.seeds}`: a simulated arm of three joints
with one effect (efforts with noise of 0.1 N m, encoders of 20 bits). *Open*: the diagnosis of the first recording has a finding
with alternatives. Then `armident excite --for`, {BUDGET_S} s of search, 10 s of motion, and the diagnosis of both recordings;
as a control, the first motion recorded again. *Decided*: findings without alternatives; *rightly*: the true effect alone.

{table}
"""
    (ROOT / "docs/studies/separation.md").write_text(page)


if __name__ == "__main__":
    main()
