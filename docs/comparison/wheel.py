"""The Python package beside the program: wheel.py PROGRAM [WHEEL] [--runs 15]

Run by the Python that has the package, with the program built from the same tree:

    cargo build --release --features all-formats
    pip wheel . --no-deps -w dist && pip install dist/armident-*.whl
    python docs/comparison/wheel.py target/release/armident dist/armident-*.whl

Prints the size of the wheel, the time to import the package in a fresh interpreter (less that of NumPy, which it imports), and
the time of `identify` and `diagnose` on the bundled recording by the program, files read and JSON written, and by the package, in
turns. Times are the least of the runs: what else the machine does only adds to them.
"""

import argparse
import pathlib
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
URDF, TRAIN, HOLDOUT = (
    str(ROOT / path) for path in ("urdf/ur5.urdf", "examples/ur5/train.csv", "examples/ur5/holdout.csv")
)


def seconds(command):
    start = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - start


def imported(module, runs):
    code = f"import time; t = time.perf_counter(); import {module}; print(time.perf_counter() - t)"
    if module != "numpy":
        code = "import numpy; " + code
    return [float(subprocess.check_output([sys.executable, "-c", code])) for _ in range(runs)]


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("program")
    arguments.add_argument("wheel", nargs="?")
    arguments.add_argument("--runs", type=int, default=15)
    given = arguments.parse_args()
    import armident

    if given.wheel:
        print(f"wheel: {pathlib.Path(given.wheel).stat().st_size / 1e6:.1f} MB")
    times = imported("armident", given.runs)
    print(f"import: {1e3 * min(times):.0f} ms (median {1e3 * statistics.median(times):.0f} ms), beside NumPy's own")
    for name in ("identify", "diagnose"):
        command = [given.program, name, URDF, TRAIN, "--holdout", HOLDOUT, "--quiet", "--json", "-"]
        call = getattr(armident, name)
        by_program, by_package = [], []
        for _ in range(given.runs):
            by_program.append(seconds(command))
            start = time.perf_counter()
            call(URDF, TRAIN, holdout=HOLDOUT).to_json()
            by_package.append(time.perf_counter() - start)
        program, package = min(by_program), min(by_package)
        share = 100 * (package - program) / program
        print(f"{name}: program {program:.3f} s, package {package:.3f} s, {share:+.1f} %")


main()
