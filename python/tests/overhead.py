"""Times of functions over those of their commands, in turn: what a call costs beside its work.

    python python/tests/overhead.py target/release/armident
"""

import resource
import statistics
import subprocess
import sys
import time

import armident

URDF, TRAIN, HOLDOUT = "urdf/ur5.urdf", "examples/ur5/train.csv", "examples/ur5/holdout.csv"
#: Function, arguments of the command, repetitions.
WORKS = {
    "check": (lambda: armident.check(URDF, TRAIN), [URDF, TRAIN], 15),
    "identify": (lambda: armident.identify(URDF, TRAIN, holdout=HOLDOUT), [URDF, TRAIN, "--holdout", HOLDOUT], 15),
    "diagnose": (lambda: armident.diagnose(URDF, TRAIN, holdout=HOLDOUT), [URDF, TRAIN, "--holdout", HOLDOUT], 5),
}


def measured(work, of):
    """Elapsed and processor time of work [s]."""

    def processor_s():
        usage = resource.getrusage(of)
        return usage.ru_utime + usage.ru_stime

    elapsed, processor = time.perf_counter(), processor_s()
    work()
    return time.perf_counter() - elapsed, processor_s() - processor


def main():
    program = sys.argv[1]
    armident.show_progress(False)
    for name, (function, arguments, repetitions) in WORKS.items():
        command = [program, name, *arguments, "--json", "/dev/null"]
        call = lambda: function().to_dict()
        run = lambda: subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        call(), run()
        pairs = [
            (measured(call, resource.RUSAGE_SELF), measured(run, resource.RUSAGE_CHILDREN)) for _ in range(repetitions)
        ]
        ratios = [[python[k] / command[k] for python, command in pairs] for k in range(2)]
        elapsed, processor = (statistics.median(ratio) for ratio in ratios)
        python_s = statistics.median(python[0] for python, _ in pairs)
        print(f"{name}: {python_s:.2f} s, {elapsed:.3f} of the command's time, {processor:.3f} of its processor time", flush=True)


if __name__ == "__main__":
    main()
