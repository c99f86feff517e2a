"""Numbers that judge `ConsistencyProblem`: the same problems by CVXPY with Clarabel.

Reads `consistency_inputs.json` (written by `cargo run -p armident-ident --example
consistency_judge_inputs`) and writes `consistency.json` beside it, one object per case:

    stage_1    smallest |R (E theta - estimate)| over real links and effects, and E theta there
    weighted   minimiser of 1/2 |R (E theta - estimate)|^2 + weight d(theta): links, effects
    nearest    minimiser of d within E theta = estimate, null when there is none: links, effects

with d the entropic divergence from the links given plus t - log t - 1 for every effect that must
not be negative, t in units of its scale. R has 1 / error on the diagonal and half of that above it.

Made with Python 3.11.7, CVXPY 1.9.3, Clarabel 0.11.1, NumPy 2.4.6. Run: python consistency.py
"""

import json
from pathlib import Path

import cvxpy as cp
import numpy as np

HERE = Path(__file__).parent
TIGHT = {"tol_gap_abs": 1e-12, "tol_gap_rel": 1e-12, "tol_feas": 1e-11, "max_iter": 500}


def pseudo_inertia(p):
    """[[1/2 tr(I) 1 - I, mc], [mc', m]] of m, mc, Ixx, Ixy, Ixz, Iyy, Iyz, Izz."""
    m, c, (xx, xy, xz, yy, yz, zz) = p[0], np.array(p[1:4]), p[4:]
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    j = np.zeros((4, 4))
    j[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    j[:3, 3] = j[3, :3] = c
    j[3, 3] = m
    return j


def parameters(j):
    """Inverse of `pseudo_inertia`, as a list of expressions."""
    trace = j[0, 0] + j[1, 1] + j[2, 2]
    return [j[3, 3], j[0, 3], j[1, 3], j[2, 3], trace - j[0, 0], -j[0, 1], -j[0, 2],
            trace - j[1, 1], -j[1, 2], trace - j[2, 2]]


def solve(problem):
    problem.solve(solver=cp.CLARABEL, **TIGHT)
    return problem.status


def judge(case):
    errors = np.array(case["standard_errors"])
    size = len(errors)
    root = np.diag(1 / errors) + np.diag(0.5 / errors[1:], 1)
    e = np.zeros((size, 10 * len(case["links"]) + len(case["scales"])))
    for i, j, value in case["map"]:
        e[i, j] = value

    cholesky = [np.linalg.cholesky(pseudo_inertia(p)) for p in case["links"]]
    scaled = [cp.Variable((4, 4), PSD=True) for _ in cholesky]
    theta = [q for l, x in zip(cholesky, scaled) for q in parameters(l @ x @ l.T)]
    constraints, divergence = [], 0
    for x in scaled:
        divergence += cp.trace(x) - cp.log_det(x) - 4
    for scale in case["scales"]:
        t = cp.Variable()
        theta.append(t if scale is None else scale * t)
        if scale is not None:
            constraints.append(t >= 0)
            divergence += t - cp.log(t) - 1
    theta = cp.hstack(theta)
    estimated = e @ theta
    left = root @ (estimated - np.array(case["estimate"]))

    answer = {}
    problem = cp.Problem(cp.Minimize(cp.sum_squares(left)), constraints)
    status = solve(problem)
    answer["stage_1"] = {
        "status": status,
        "distance": float(np.linalg.norm(left.value)),
        "estimated": estimated.value.tolist(),
        # how large the links have become: an infimum that is not attained shows here
        "size": float(sum(np.trace(x.value) for x in scaled) / (4 * len(scaled))),
    }

    objective = 0.5 * cp.sum_squares(left) + case["weight"] * divergence
    status = solve(cp.Problem(cp.Minimize(objective), constraints))
    answer["weighted"] = {"status": status, "objective": float(objective.value),
                          "theta": theta.value.tolist()}

    problem = cp.Problem(cp.Minimize(divergence), constraints + [left == 0])
    status = solve(problem)
    answer["nearest"] = None
    if status in ("optimal", "optimal_inaccurate"):
        answer["nearest"] = {"status": status, "divergence": float(divergence.value),
                             "theta": theta.value.tolist()}
    return answer


cases = json.loads((HERE / "consistency_inputs.json").read_text())
answers = []
for case in cases:
    answer = judge(case)
    answers.append(answer)
    nearest = answer["nearest"] and (answer["nearest"]["status"], answer["nearest"]["divergence"])
    print(case["arm"], {k: v for k, v in answer["stage_1"].items() if k != "estimated"},
          answer["weighted"]["status"], answer["weighted"]["objective"], nearest)
(HERE / "consistency.json").write_text(json.dumps(answers) + "\n")
