"""Loads exported arms with Pinocchio, MuJoCo, Drake and OpenUSD and compares efforts, inertia matrices and losses.

Arguments: a folder, and names of arms in it: <name>.urdf, <name>.xml, <name>.sdf, <name>.usda, <name>.py and
<name>.states.json (written by peers.rs: states with the efforts of the rigid body and the inertia matrix). Prints a line per
arm and program, and a line `skipped: ...` for Drake or OpenUSD where it is not installed; a difference beyond 1e-6 of the
largest number is an error. USD has single precision, and its limit is 1e-5. `--mujoco NAME` compares one file with MuJoCo.

Isaac Lab is not on PyPI without its simulator: its file is run with a stand-in that knows the arguments of
`ActuatorBaseCfg` (documentation of Isaac Lab 2.3), and the values are compared.
"""

import importlib.util
import json
import re
import sys
import types
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


def by_drake(path, truth):
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(0.0)
    (instance,) = Parser(plant).AddModels(str(path))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    joints = [plant.GetJointByName(name, instance) for name in truth["joints"]]
    assert plant.num_velocities() == len(joints) == plant.num_actuators()
    place = [joint.velocity_start() for joint in joints]
    rotor = [plant.GetJointActuatorByName(name).default_rotor_inertia() for name in truth["joints"]]
    expected = np.array([value(truth, "rotor_inertia", j) for j in truth["joints"]])
    compare("rotor inertia", rotor, expected)
    damping = [joint.default_damping_vector()[0] for joint in joints]
    compare("damping", damping, np.array([value(truth, "viscous_friction", j) for j in truth["joints"]]))
    worst = 0.0
    for state in truth["states"]:
        q, v, a = (np.zeros(len(joints)) for _ in range(3))
        q[place], v[place], a[place] = state["q"], state["v"], state["a"]
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        # damping and gravity are among the forces of elements
        from pydrake.multibody.tree import MultibodyForces

        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        found = plant.CalcInverseDynamics(context, a, forces)[place]
        effort = np.array(state["effort"]) + np.array(damping) * state["v"] + expected * state["a"]
        worst = max(worst, compare("effort", found, effort))
        inertia = plant.CalcMassMatrix(context)[np.ix_(place, place)]
        n = len(joints)
        rigid = np.reshape(state["inertia"], (n, n)) + np.diag(expected)
        worst = max(worst, compare("inertia", inertia, rigid))
    return worst


def by_usd(path, truth):
    from pxr import Gf, Sdf, Usd, UsdPhysics

    # the file of the robot as an importer leaves it, below the overlay
    model = pinocchio.buildModelFromUrdf(str(path.with_suffix(".urdf")))
    alone = Usd.Stage.Open(str(path))
    robot = alone.GetDefaultPrim().GetName()
    base = Usd.Stage.CreateInMemory()
    base.DefinePrim(f"/{robot}", "Xform")
    for frame in model.frames:
        if frame.type == pinocchio.FrameType.BODY:
            body = base.DefinePrim(f"/{robot}/{frame.name}", "Xform")
            UsdPhysics.MassAPI.Apply(body).CreateMassAttr(77.0)
    kinds = {}
    for index, name in zip(range(1, model.njoints), truth["joints"]):
        linear = "P" in model.joints[index].shortname().replace("JointModelR", "")[:11]
        kinds[name] = "linear" if linear else "angular"
        base.DefinePrim(f"/{robot}/joints/{name}", "PhysicsPrismaticJoint" if linear else "PhysicsRevoluteJoint")
    below = path.with_suffix(".base.usda")
    base.GetRootLayer().Export(str(below))
    above = Sdf.Layer.CreateAnonymous(".usda")
    above.subLayerPaths = [str(path), str(below)]
    stage = Usd.Stage.Open(above)
    worst = 0.0
    for index, name in zip(range(1, model.njoints), truth["joints"]):
        link = next(f.name for f in model.frames if f.type == pinocchio.FrameType.BODY and f.parentJoint == index)
        mass = UsdPhysics.MassAPI(stage.GetPrimAtPath(f"/{robot}/{link}"))
        expected = model.inertias[index]
        compare_single("mass", mass.GetMassAttr().Get(), expected.mass)
        compare_single("centre of mass", np.array(mass.GetCenterOfMassAttr().Get()), expected.lever)
        turn = Gf.Matrix3d(mass.GetPrincipalAxesAttr().Get())
        # rows of Gf are columns here
        turn = np.array(turn).T
        inertia = turn @ np.diag(mass.GetDiagonalInertiaAttr().Get()) @ turn.T
        worst = max(worst, compare_single("inertia", inertia, expected.inertia))
        joint = stage.GetPrimAtPath(f"/{robot}/joints/{name}")
        assert joint.IsDefined() and f"PhysxJointAxisAPI:{kinds[name]}" in joint.GetMetadata("apiSchemas").GetAppliedItems()
        for attribute, effect, unit in [
            ("armature", "rotor_inertia", 1.0),
            ("staticFrictionEffort", "coulomb_friction", 1.0),
            ("dynamicFrictionEffort", "coulomb_friction", 1.0),
            ("viscousFrictionCoefficient", "viscous_friction", np.pi / 180 if kinds[name] == "angular" else 1.0),
        ]:
            found = joint.GetAttribute(f"physxJointAxis:{kinds[name]}:{attribute}").Get()
            worst = max(worst, compare_single(attribute, found, value(truth, effect, name) * unit))
    return worst


def compare_single(what, found, expected):
    """Numbers of single precision."""
    size = max(1e-9, np.abs(expected).max())
    error = np.abs(np.asarray(found) - expected).max() / size
    assert error < 1e-5, f"{what}: relative difference {error:.1e}\n{found}\n{expected}"
    return error


class ImplicitActuatorCfg:
    """Stand-in: the arguments of Isaac Lab's class, none of which may be unknown."""

    KNOWN = {
        *("joint_names_expr", "effort_limit_sim", "velocity_limit_sim", "stiffness", "damping", "armature"),
        *("friction", "dynamic_friction", "viscous_friction"),
    }

    def __init__(self, **arguments):
        assert set(arguments) <= self.KNOWN, set(arguments) - self.KNOWN
        assert {"joint_names_expr", "stiffness", "damping"} <= set(arguments)
        self.__dict__.update(arguments)

    def of(self, argument, joint):
        """The value of a joint, as Isaac Lab finds it: names are regular expressions."""
        given = getattr(self, argument)
        if not isinstance(given, dict):
            return given
        (found,) = [number for name, number in given.items() if re.fullmatch(name, joint)]
        return found


def by_isaac_lab(path, truth):
    package = types.ModuleType("isaaclab.actuators")
    package.ImplicitActuatorCfg = ImplicitActuatorCfg
    sys.modules |= {"isaaclab": types.ModuleType("isaaclab"), "isaaclab.actuators": package}
    spec = importlib.util.spec_from_file_location("actuators", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (arm,) = module.ACTUATORS.values()
    worst = 0.0
    for joint in truth["joints"]:
        assert sum(bool(re.fullmatch(name, joint)) for name in arm.joint_names_expr) == 1
        for argument, effect in [
            ("armature", "rotor_inertia"),
            ("friction", "coulomb_friction"),
            ("dynamic_friction", "coulomb_friction"),
            ("viscous_friction", "viscous_friction"),
        ]:
            expected = np.array(value(truth, effect, joint))
            worst = max(worst, compare(argument, arm.of(argument, joint), expected))
    return worst


def main():
    folder = Path(sys.argv[1])
    if sys.argv[2] == "--mujoco":
        # a file of MuJoCo, with the states that were computed for it
        name = sys.argv[3]
        by_mujoco(folder / f"{name}.xml", json.loads((folder / f"{name}.states.json").read_text()))
        return
    programs = [
        ("Pinocchio", by_pinocchio, "urdf"),
        ("MuJoCo", by_mujoco, "xml"),
        ("a stand-in of Isaac Lab", by_isaac_lab, "py"),
    ]
    for name, run, end, package in [("Drake", by_drake, "sdf", "pydrake"), ("OpenUSD", by_usd, "usda", "pxr")]:
        if importlib.util.find_spec(package):
            programs.append((name, run, end))
        else:
            print(f"skipped: {name}")
    for name in sys.argv[2:]:
        truth = json.loads((folder / f"{name}.states.json").read_text())
        for program, run, end in programs:
            worst = run(folder / f"{name}.{end}", truth)
            print(f"{name}: {program} agrees to {worst:.1e}")


main()
