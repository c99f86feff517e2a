"""One UR10 recording, four ways to a model: compare.py UR10_RECORDING.csv [--armident PATH] [--python PATH]

Fits the first 12 s, predicts the next 6, and prints a table in Markdown: wall time and RMS error of the
efforts kept back, both low-passed at 8 Hz (Butterworth, 4th order, forward and backward, ends left out).
PATH of --python is a Python with figaroh and pin (pip install figaroh); this script needs NumPy and SciPy.
"""

import argparse
import csv
import pathlib
import subprocess
import tempfile
import time

import numpy as np
from scipy.signal import butter, filtfilt

HERE = pathlib.Path(__file__).resolve().parent
URDF = str(HERE.parent.parent / "urdf/ur10.urdf")
RUNS = 5


def split(path, folder):
    with open(path, newline="") as file:
        header, *rows = list(csv.reader(file))
    for name, start, end in (("train", 0.0, 12.0), ("holdout", 12.0, 18.0)):
        with open(folder / f"{name}.csv", "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(header)
            writer.writerows(row for row in rows if start <= float(row[0]) < end)


def table(path):
    return np.genfromtxt(path, delimiter=",", names=True, deletechars="")


def errors(folder, predicted):
    measured, said = table(folder / "holdout.csv"), table(folder / predicted)
    names = [n for n in measured.dtype.names if n.endswith("/effort")]
    step = np.median(np.diff(measured["t"]))
    b, a = butter(4, 8.0 * 2 * step)
    inside = slice(25, -25)
    of = lambda log, n: filtfilt(b, a, log[n])[inside]
    return [np.sqrt(np.mean((of(measured, n) - of(said, n)) ** 2)) for n in names], names


def timed(folder, *commands):
    """Median wall time of a few runs, after one to warm up."""
    times = []
    for run in range(RUNS + 1):
        start = time.perf_counter()
        for command in commands:
            done = subprocess.run([str(c) for c in command], cwd=folder, capture_output=True, text=True)
            if done.returncode:
                raise SystemExit(f"{command}:\n{done.stderr}")
        times.append(time.perf_counter() - start)
    return float(np.median(times[1:]))


def code_lines(name):
    text = (HERE / name).read_text().splitlines()
    return sum(1 for line in text if line.strip() and not line.strip().startswith(("#", '"""')))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("recording")
    parser.add_argument("--armident", default=HERE.parent.parent / "target/release/armident")
    parser.add_argument("--python", default="python3")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        split(args.recording, folder)
        armident = pathlib.Path(args.armident).resolve()
        # not resolved: a virtual environment is known by its link
        python = pathlib.Path(args.python).absolute() if "/" in args.python else args.python
        files = (URDF, "train.csv", "holdout.csv")
        identify = [armident, "identify", URDF, "train.csv", "--cutoff-hz", "8", "--save-model", "m.json", "-q"]
        predict = [armident, "predict", "m.json", "holdout.csv", "-o", "identify.csv", "-q"]
        diagnose = [armident, "diagnose", URDF, "train.csv", "--save-model", "d.json", "-q"]
        predict_d = [armident, "predict", "d.json", "holdout.csv", "-o", "diagnose.csv", "-q"]
        hand = [python, "-W", "ignore", HERE / "by_hand.py", *files, "hand.csv"]
        figaroh = [python, "-W", "ignore", HERE / "figaroh_ur10.py", *files]
        ways = [
            ("armident identify, predict", 0, "identify.csv", (identify, predict)),
            ("armident diagnose, predict", 0, "diagnose.csv", (diagnose, predict_d)),
            ("Pinocchio and NumPy", code_lines("by_hand.py"), "hand.csv", (hand,)),
            (
                "FIGAROH, least squares",
                code_lines("figaroh_ur10.py") + code_lines("figaroh_ur10.yaml"),
                "figaroh_ols.csv",
                ([*figaroh, "figaroh_ols.csv", "ols"],),
            ),
            (
                "FIGAROH, weighted",
                code_lines("figaroh_ur10.py") + code_lines("figaroh_ur10.yaml"),
                "figaroh_wls.csv",
                ([*figaroh, "figaroh_wls.csv", "wls"],),
            ),
        ]
        head = None
        for name, lines, predicted, commands in ways:
            seconds = timed(folder, *commands)
            rms, joints = errors(folder, predicted)
            if head is None:
                head = ["way", "lines to write", "wall time [s]", *(j.split("/")[0] for j in joints)]
                print("| " + " | ".join(head) + " |")
                print("| --- |" + " ---: |" * (len(head) - 1))
            cells = [name, str(lines), f"{seconds:.1f}", *(f"{e:.3g}" for e in rms)]
            print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
