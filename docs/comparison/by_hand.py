"""The UR10 identified with Pinocchio and NumPy: by_hand.py URDF TRAIN.csv HOLDOUT.csv PREDICTED.csv"""

import csv
import sys

import numpy as np
import pinocchio as pin
from scipy.signal import butter, filtfilt

CUTOFF_HZ = 8.0

urdf, train, holdout, predicted = sys.argv[1:]
model = pin.buildModelFromUrdf(urdf)
data = model.createData()
names = list(model.names)[1:]


def read(path):
    table = np.genfromtxt(path, delimiter=",", names=True, deletechars="")
    q = np.column_stack([table[f"{n}/position"] for n in names])
    tau = np.column_stack([table[f"{n}/effort"] for n in names])
    step = np.median(np.diff(table["t"]))
    b, a = butter(4, CUTOFF_HZ * 2 * step)
    q, tau = filtfilt(b, a, q, axis=0), filtfilt(b, a, tau, axis=0)
    v = np.gradient(q, step, axis=0)
    return table["t"], q, v, np.gradient(v, step, axis=0), tau


def regressor(q, v, a):
    """Rows by joint: 10 numbers a link, then viscous, Coulomb, offset and rotor of each joint."""
    n = len(names)
    rows = np.zeros((n, len(q), 14 * n))
    for k in range(len(q)):
        rows[:, k, : 10 * n] = pin.computeJointTorqueRegressor(model, data, q[k], v[k], a[k])
    for j in range(n):
        own = np.column_stack([v[:, j], np.sign(v[:, j]), np.ones(len(q)), a[:, j]])
        rows[j, :, 10 * n + 4 * j : 10 * n + 4 * j + 4] = own
    return rows


_, q, v, a, tau = read(train)
edge = slice(25, -25)  # where filters begin
rows = regressor(q, v, a)[:, edge]
weights = np.ones(len(names))
for _ in range(2):  # then by the noise of each joint
    stacked = np.concatenate([w * r for w, r in zip(weights, rows)])
    target = np.concatenate([w * tau[edge, j] for j, w in enumerate(weights)])
    x = np.linalg.lstsq(stacked, target, rcond=1e-6)[0]
    weights = [1 / np.std(tau[edge, j] - rows[j] @ x) for j in range(len(names))]

t, q, v, a, _ = read(holdout)
effort = np.einsum("jkp,p->kj", regressor(q, v, a), x)
with open(predicted, "w", newline="") as file:
    writer = csv.writer(file)
    writer.writerow(["t", *(f"{n}/effort" for n in names)])
    writer.writerows(np.column_stack([t, effort]).tolist())
print(f"{len(x)} parameters, rank {np.linalg.matrix_rank(stacked, tol=1e-6 * np.linalg.norm(stacked, 2))}")
