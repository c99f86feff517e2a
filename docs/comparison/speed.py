"""Kernels of one sample and of motions beside Pinocchio's: speed.py [--runs 7] [--write]

Compiles Pinocchio's algorithms (C++, -O3 -march=native; 2 minutes and 4 GB, once), then runs them and
`cargo bench -p armident-dynamics` in turns, and prints the table of docs/book/src/speed.md, or writes it there. A
figure is the median over the runs of medians; a ratio is the median of the ratios within a run. Needs a Python
with pin and cmeel-eigen (pip install "pin<5" cmeel-eigen), and g++.
"""

import argparse
import datetime
import pathlib
import re
import statistics
import subprocess
import tempfile

import numpy as np
import pinocchio as pin

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PAGE = ROOT / "docs/book/src/speed.md"
FOLDER = pathlib.Path(tempfile.gettempdir()) / "armident_speed"
BEGIN, END = "<!-- kernels -->\n", "<!-- end of kernels -->\n"
ARMS = {"panda": "Panda, 7 joints", "ur5": "UR5, 6 joints"}
ROWS = {
    "inverse_dynamics_single": "inverse dynamics (RNEA)",
    "inverse_dynamics_motion": "inverse dynamics, batch",
    "inertia_matrix_single": "inertia matrix",
    "inertia_matrix_motion": "inertia matrix, batch",
    "standard_regressor_single": "regressor",
    "standard_regressor_motion": "regressor, batch",
}
SAMPLES = 256  # of a motion in the bench
UNITS = {"ns": 1.0, "µs": 1e3, "ms": 1e6}


def turned(axis):
    """Rotation that takes z to an axis of the URDF."""
    z = {"RX": [0, 1, 0, 0, 0, 1, 1, 0, 0], "RY": [0, 0, 1, 1, 0, 0, 0, 1, 0], "RZ": [1, 0, 0, 0, 1, 0, 0, 0, 1]}[axis]
    return pin.SE3(np.array(z, dtype=float).reshape(3, 3), np.zeros(3))


def written(arm):
    """The arm as the C++ program reads it: each joint about z, its place, mass, centre and inertia."""
    model = pin.buildModelFromUrdf(str(ROOT / f"urdf/{arm}.urdf"))
    lines, before = [f"{arm} {model.njoints - 1}"], pin.SE3.Identity()
    for j in range(1, model.njoints):
        own = turned(model.joints[j].shortname()[-2:])
        place = before.inverse() * model.jointPlacements[j] * own
        body = own.inverse().act(model.inertias[j])
        numbers = [*place.rotation.flatten(), *place.translation, body.mass, *body.lever, *body.inertia.flatten()]
        lines.append(" ".join(repr(float(x)) for x in numbers))
        before = own
    path = FOLDER / f"{arm}.txt"
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def compiled():
    program, prefix = FOLDER / "pinocchio", pathlib.Path(pin.__file__).parents[4]
    if not program.exists():
        boost = ["MPL_LIMIT_LIST_SIZE=30", "MPL_LIMIT_VECTOR_SIZE=30", "MPL_CFG_NO_PREPROCESSED_HEADERS"]
        subprocess.check_call(
            ["g++", "-std=c++17", "-O3", "-DNDEBUG", "-march=native", *(f"-DBOOST_{b}" for b in boost)]
            + ["-DBOOST_FUSION_INVOKE_MAX_ARITY=12", "-isystem", f"{prefix}/include", "-isystem"]
            + [f"{prefix}/include/eigen3", str(HERE / "pinocchio.cpp"), "-o", str(program)]
        )
    return str(program)


def bench():
    """Path of the compiled bench."""
    made = subprocess.run(
        ["cargo", "bench", "-p", "armident-dynamics", "--bench", "kernels", "--no-run"],
        cwd=ROOT, check=True, capture_output=True, text=True,
    )
    return re.findall(r"\(([^)]*kernels-[^)]*)\)", made.stderr)[-1]


def ours(program):
    """Nanoseconds a sample, by bench and arm."""
    out = subprocess.run([program, "--bench"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    found, name = {}, None
    for line in out.splitlines():
        if head := re.match(r"[├╰]─ (\w+)", line):
            name = head[1]
        elif row := re.match(r"[│ ]  [├╰]─ (\w+)", line):
            value, unit = line.lstrip("│").split("│")[2].split()  # median
            found[name, row[1]] = float(value) * UNITS[unit] / (SAMPLES if name.endswith("motion") else 1)
    return found


def theirs(program, arms):
    out = subprocess.run([program, *arms], check=True, capture_output=True, text=True).stdout
    return {(name, arm): float(ns) for name, arm, ns in (line.split() for line in out.splitlines())}


def table(runs):
    processor = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())[1]
    today = datetime.date.today()
    lines = [f"{processor}, {today}, medians of {len(runs)} runs in turns, one core.\n"]
    for arm, title in ARMS.items():
        lines.append(f"| {title} | armident | Pinocchio {pin.__version__} | ratio |\n| --- | ---: | ---: | ---: |")
        for row, text in ROWS.items():
            own = [run[0][row, arm] for run in runs]
            peer = [run[1][row.rsplit("_", 1)[0], arm] for run in runs]
            ratio = statistics.median(p / o for p, o in zip(peer, own))
            own, peer = statistics.median(own), statistics.median(peer)
            lines.append(f"| {text} | {own:.0f} ns | {peer:.0f} ns | {ratio:.1f} |")
        lines.append("")
    return "\n".join(lines)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--runs", type=int, default=7)
    arguments.add_argument("--write", action="store_true")
    given = arguments.parse_args()
    FOLDER.mkdir(exist_ok=True)
    arms, peer, own = [written(arm) for arm in ARMS], compiled(), bench()
    runs = [(ours(own), theirs(peer, arms)) for _ in range(given.runs)]
    found = table(runs)
    print(found)
    if given.write:
        before, rest = PAGE.read_text().split(BEGIN)
        PAGE.write_text(before + BEGIN + found + END + rest.split(END)[1])


if __name__ == "__main__":
    main()
