#!/usr/bin/env python3
"""Writes docs/studies/excitation.md: motions of `armident excite` for twelve arms, checked by Pinocchio.

    docs/studies/excitation.py [--seeds 2] [--budget 10] [--arms ur5,panda]

Needs a Python with `pin` and `numpy`, and the program (ARMIDENT, else target/release/armident). With --arms the table is
printed and no file is written.
"""

import argparse
import csv
import datetime
import json
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pinocchio

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("ARMIDENT", str(ROOT / "target/release/armident"))
ARMS = [
    "cylindrical", "iiwa14", "irb140", "kinova_gen3", "panda", "puma560",
    "scara", "stanford", "tx40", "ur10", "ur5", "xarm7",
]  # fmt: skip
# effort noise of every joint [N m or N]; the ratio of actual to predicted errors does not depend on it
NOISE = 0.5
# samples of the dense check between two of the 100 Hz of the motion: 10 kHz
DENSE = 100
RECORDINGS = 3


def armident(*args, cwd):
    ran = subprocess.run([PROGRAM, *map(str, args)], cwd=cwd, capture_output=True, text=True)
    if ran.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, args))}: {ran.stderr}")
    return ran.stdout


def read_motion(path, joints):
    with open(path) as file:
        rows = list(csv.reader(file))
    head, data = rows[0], np.array(rows[1:], dtype=float)
    column = lambda name: data[:, head.index(name)]
    kinds = ("position", "velocity", "acceleration")
    return data[:, 0], [np.stack([column(f"{j}/{kind}") for j in joints]) for kind in kinds]


def dense(time, motion):
    """The quintic through position, velocity and acceleration of neighbouring samples, at 10 kHz."""
    q, v, a = motion
    h = time[1] - time[0]
    x = np.arange(DENSE) / DENSE
    p = lambda *c: np.polynomial.polynomial.polyval(x, c)
    base = [
        p(1, 0, 0, -10, 15, -6), p(0, 1, 0, -6, 8, -3), p(0, 0, 0.5, -1.5, 1.5, -0.5),
        p(0, 0, 0, 10, -15, 6), p(0, 0, 0, -4, 7, -3), p(0, 0, 0, 0.5, -1, 0.5),
    ]  # fmt: skip
    values = [q[:, :-1], h * v[:, :-1], h * h * a[:, :-1], q[:, 1:], h * v[:, 1:], h * h * a[:, 1:]]
    position = sum(value[:, :, None] * b for value, b in zip(values, base)).reshape(len(q), -1)
    step = h / DENSE
    velocity = np.gradient(position, step, axis=1)
    acceleration = np.gradient(velocity, step, axis=1)
    return position, velocity, acceleration


def efforts(urdf, joints, motion):
    model = pinocchio.buildModelFromUrdf(str(urdf))
    data = model.createData()
    ids = [model.getJointId(j) for j in joints]
    position, velocity, acceleration = motion
    found = np.empty_like(position)
    q, v, a = pinocchio.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    for t in range(position.shape[1]):
        for k, i in enumerate(ids):
            joint = model.joints[i]
            if joint.nq == 2:
                q[joint.idx_q : joint.idx_q + 2] = np.cos(position[k, t]), np.sin(position[k, t])
            else:
                q[joint.idx_q] = position[k, t]
            v[joint.idx_v], a[joint.idx_v] = velocity[k, t], acceleration[k, t]
        torque = pinocchio.rnea(model, data, q, v, a)
        found[:, t] = [torque[model.joints[i].idx_v] for i in ids]
    return found


def study(arm, seed, budget, folder):
    urdf = ROOT / f"urdf/{arm}.urdf"
    armident("excite", urdf, "-o", "names", "--only", "slow_reversals", "--json", "names.json", "-q", cwd=folder)
    names = [row["joint"] for row in json.loads((folder / "names.json").read_text())["limits"]]
    limits = "".join(f'["{name}"]\nnoise = {NOISE}\n' for name in names)
    (folder / "limits.toml").write_text(limits)
    armident(
        "excite", urdf, "-o", "suite", "--limits", "limits.toml", "--only", "train", "--budget", budget,
        "--seed", seed, "--json", "suite.json", "-q", cwd=folder,
    )  # fmt: skip
    suite = json.loads((folder / "suite.json").read_text())
    time, motion = read_motion(folder / "suite/train.csv", names)
    q, v, a = dense(time, motion)
    torque = efforts(urdf, names, (q, v, a))
    shares = {"position": 0.0, "speed": 0.0, "acceleration": 0.0, "effort": 0.0}
    for k, limit in enumerate(suite["limits"]):
        middle, half = 0.5 * (limit["lower"] + limit["upper"]), 0.5 * (limit["upper"] - limit["lower"])
        of = {
            "position": np.abs(q[k] - middle).max() / half,
            "speed": np.abs(v[k]).max() / limit["velocity"],
            # the second difference at the ends of the grid is one-sided
            "acceleration": np.abs(a[k][2:-2]).max() / limit["acceleration"],
            "effort": np.abs(torque[k][2:-2]).max() / limit["effort"] if limit["effort"] else 0.0,
        }
        shares = {key: max(shares[key], of[key]) for key in shares}
    train = next(m for m in suite["motions"] if m["name"] == "train")
    predicted = {
        e["name"]: (e["value"], e["from_train"]) for e in suite["errors"] if e["value"] is not None
    }
    squares = []
    for run in range(RECORDINGS):
        armident(
            "simulate", urdf, "suite/train.csv", "-o", "run.csv", "--torque-noise", NOISE, "--encoder-bits", 24,
            "--seed", 100 * seed + run, "-q", cwd=folder,
        )  # fmt: skip
        found = armident(
            "identify", urdf, "run.csv", "--prior", "none", "--method", "ols", "--raw-estimate", "--json", "-",
            "-q", cwd=folder,
        )  # fmt: skip
        for constant in json.loads(found)["constants"]:
            value, error = predicted[constant["label"]]
            squares.append(((constant["value"] - value) / error) ** 2)
    return {
        "arm": arm,
        "joints": len(names),
        "shares": shares,
        "condition": train["condition"],
        "random": suite["random_condition"],
        "spread": float(np.sqrt(np.mean(squares))),
    }


def table(rows):
    lines = [
        "| arm | joints | motions | inside all limits | largest share of a limit: position, speed, acceleration, effort | "
        "condition number | median of random motions | ratio | actual / predicted standard error |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for arm in dict.fromkeys(row["arm"] for row in rows):
        of = [row for row in rows if row["arm"] == arm]
        # a millionth for the interpolation
        inside = sum(max(row["shares"].values()) <= 1 + 1e-6 for row in of)
        most = [max(row["shares"][key] for row in of) for key in of[0]["shares"]]
        condition, random = (float(np.median([row[key] for row in of])) for key in ("condition", "random"))
        spread = float(np.median([row["spread"] for row in of]))
        shares = ", ".join(f"{share:.3f}" for share in most)
        lines.append(
            f"| {arm} | {of[0]['joints']} | {len(of)} | {inside} | {shares} | {condition:.0f} | {random:.0f} | "
            f"{random / condition:.1f} | {spread:.2f} |"
        )
    inside = sum(max(row["shares"].values()) <= 1 + 1e-6 for row in rows)
    ratio = np.median([row["random"] / row["condition"] for row in rows])
    spread = np.median([row["spread"] for row in rows])
    lines += ["", f"Inside all limits: {inside} of {len(rows)}. Medians: {ratio:.1f} times better conditioned than random "
              f"motions; actual standard errors {spread:.2f} times the predicted."]  # fmt: skip
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--budget", type=float, default=10.0)
    parser.add_argument("--arms")
    given = parser.parse_args()
    rows = []
    for arm in given.arms.split(",") if given.arms else ARMS:
        for seed in range(1, given.seeds + 1):
            with tempfile.TemporaryDirectory() as folder:
                rows.append(study(arm, seed, given.budget, Path(folder)))
                print(rows[-1], flush=True)
    text = table(rows)
    if given.arms:
        print(text)
        return
    version = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True).stdout.strip()
    page = f"""# Motions of `excite`

{version}, {datetime.date.today()}. Made by `docs/studies/excitation.py --seeds {given.seeds} --budget {given.budget:g}`:
the training motion (20 s) of each arm and seed, {given.budget:g} s of search on two cores.

Limits are checked at 10 kHz between the 100 Hz of the written motion (quintic interpolation), efforts by Pinocchio from the
URDF; shares are of what the design may use (90 % of range and speed, 80 % of effort). The condition number is that of the
regressor of minimal constants, viscous and Coulomb friction and offsets, with columns of unit length; random motions are the
median of 21 inside the same limits. Actual standard errors are the root mean square error of ordinary least squares over all
constants and {RECORDINGS} simulated recordings (encoder of 24 bits, positions differentiated), over the predicted ones.

{text}"""
    (ROOT / "docs/studies/excitation.md").write_text(page)


if __name__ == "__main__":
    main()
