"""Loads exported arms with Pinocchio and MuJoCo and compares efforts and inertia matrices.

Arguments: a folder, and names of arms in it: <name>.urdf, <name>.xml and <name>.states.json (written by
peers.rs: states with the efforts of the rigid body and the inertia matrix). Prints a line per arm and
program; a difference beyond 1e-6 of the largest number is an error.
"""

import json
import sys
from pathlib import Path

import mujoco
import numpy as np
import pinocchio

TOLERANCE = 1e-6


def compare(what, found, expected):
    size = max(1e-9, np.abs(expected).max())
    error = np.abs(np.asarray(found) - expected).max() / size
    assert error < TOLERANCE, f"{what}: relative difference {error:.1e}\n{found}\n{expected}"
    return error


def value(truth, effect, joint):
    return sum(e["value"] for e in truth["effects"] if (e["effect"], e["joint"]) == (effect, joint))


def by_pinocchio(path, truth):
    model = pinocchio.buildModelFromUrdf(str(path))
    data = model.createData()
    assert list(model.names)[1:] == truth["joints"], list(model.names)
    # a continuous joint has two coordinates, (cos, sin)
    worst = 0.0
    for state in truth["states"]:
        q = pinocchio.neutral(model)
        for index, angle in zip(range(1, model.njoints), state["q"]):
            joint = model.joints[index]
            if joint.nq == 2:
                q[joint.idx_q : joint.idx_q + 2] = np.cos(angle), np.sin(angle)
            else:
                q[joint.idx_q] = angle
        v, a = np.array(state["v"]), np.array(state["a"])
        effort = pinocchio.rnea(model, data, q, v, a)
        worst = max(worst, compare("effort", effort, np.array(state["effort"])))
        inertia = pinocchio.crba(model, data, q)
        inertia = np.triu(inertia) + np.triu(inertia, 1).T
        n = len(v)
        worst = max(worst, compare("inertia", inertia, np.reshape(state["inertia"], (n, n))))
    damping = [value(truth, "viscous_friction", j) for j in truth["joints"]]
    compare("damping", model.damping if hasattr(model, "damping") else damping, np.array(damping))
    return worst


def by_mujoco(path, truth):
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    names = [model.joint(i).name for i in range(model.njnt)]
    assert names == truth["joints"], names
    assert model.nu == model.nv
    losses = np.array([value(truth, "coulomb_friction", j) for j in names])
    compare("frictionloss", model.dof_frictionloss, losses)
    armature = np.array([value(truth, "rotor_inertia", j) for j in names])
    damping = np.array([value(truth, "viscous_friction", j) for j in names])
    # dry friction and limits are constraints of the simulator: the efforts are compared without them
    model.dof_frictionloss[:] = 0.0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    worst = 0.0
    for state in truth["states"]:
        data.qpos[:], data.qvel[:], data.qacc[:] = state["q"], state["v"], state["a"]
        mujoco.mj_inverse(model, data)
        v, a = np.array(state["v"]), np.array(state["a"])
        effort = np.array(state["effort"]) + damping * v + armature * a
        worst = max(worst, compare("effort", data.qfrc_inverse, effort))
        n = len(v)
        inertia = np.zeros((n, n))
        try:
            mujoco.mj_fullM(model, inertia, data.qM)
        except (AttributeError, TypeError):  # since 4.0
            mujoco.mj_fullM(model, data, inertia)
        expected = np.reshape(state["inertia"], (n, n)) + np.diag(armature)
        worst = max(worst, compare("inertia", inertia, expected))
    return worst


def main():
    folder = Path(sys.argv[1])
    for name in sys.argv[2:]:
        truth = json.loads((folder / f"{name}.states.json").read_text())
        for program, run, end in [
            ("Pinocchio", by_pinocchio, "urdf"),
            ("MuJoCo", by_mujoco, "xml"),
        ]:
            worst = run(folder / f"{name}.{end}", truth)
            print(f"{name}: {program} agrees to {worst:.1e}")


main()
