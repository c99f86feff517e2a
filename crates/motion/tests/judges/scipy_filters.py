"""Numbers that judge `ZeroPhaseLowPass`: scipy.signal.butter and sosfiltfilt.

Writes beside itself one CSV per signal (first column the input, then one column per order and
cutoff, named `<order>/<cutoff as a share of the sample rate>`) and `design.csv` (second-order
sections and noise-equivalent bandwidths of |H|^4).

Made with Python 3.11.7, SciPy 1.17.1, NumPy 2.4.6. Run: python scipy_filters.py
"""

from pathlib import Path

import numpy as np
from scipy.integrate import quad
from scipy.signal import butter, freqz_sos, sosfiltfilt

ORDERS = [2, 3, 4]
CUTOFFS = [0.002, 0.02, 0.1, 0.25, 0.45]
HERE = Path(__file__).parent

k = np.arange(64)
SIGNALS = {
    "step": np.where(k < 20, 0.0, 1.0),
    "sine": 0.7 + np.sin(2 * np.pi * 0.031 * k + 0.4),
    "ramp": -3.0 + 0.25 * k,
    "noise": np.random.default_rng(7).standard_normal(64),
    # no longer than the default padding of 15, so the padding is n - 1
    "short": np.array([0.1, 0.4, -0.3, 0.9, 1.1, 0.2, -0.8]),
}


def filtered(order, cutoff, x):
    """sosfiltfilt with its default padding, reduced for signals that are too short for it."""
    sos = butter(order, cutoff, fs=1.0, output="sos")
    taps = 2 * len(sos) + 1 - min((sos[:, 2] == 0).sum(), (sos[:, 5] == 0).sum())
    padlen = None if len(x) > 3 * taps else len(x) - 1
    return sosfiltfilt(sos, x, padlen=padlen)


for name, x in SIGNALS.items():
    cases = [(order, cutoff) for order in ORDERS for cutoff in CUTOFFS]
    columns = [x] + [filtered(order, cutoff, x) for order, cutoff in cases]
    with open(HERE / f"{name}.csv", "w") as out:
        out.write(",".join(["input"] + [f"{order}/{cutoff}" for order, cutoff in cases]) + "\n")
        for row in zip(*columns):
            out.write(",".join(repr(float(value)) for value in row) + "\n")

with open(HERE / "design.csv", "w") as out:
    out.write("order,cutoff,bandwidth,section,b0,b1,b2,a0,a1,a2\n")
    for order in ORDERS:
        for cutoff in CUTOFFS:
            sos = butter(order, cutoff, fs=1.0, output="sos")

            def power(f):
                return abs(freqz_sos(sos, [f], fs=1.0)[1][0]) ** 4

            edges = [0.0, cutoff, min(2 * cutoff, 0.5), min(8 * cutoff, 0.5), 0.5]
            bandwidth = sum(quad(power, a, b, epsabs=1e-14, epsrel=1e-12)[0] for a, b in zip(edges, edges[1:]))
            for section, row in enumerate(sos):
                values = ",".join(repr(float(value)) for value in row)
                out.write(f"{order},{cutoff},{bandwidth!r},{section},{values}\n")
