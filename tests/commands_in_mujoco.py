"""MuJoCo moves an arm under commands, with properties that its URDF does not contain.

    record FOLDER URDF    writes FOLDER/run_<k>.csv (t, <joint>/command, <joint>/position) and prints the properties as JSON
    replay FOLDER MJCF    moves the arm of MJCF under the commands of the last run, and prints RMS errors of positions by joint
                          as JSON: of the command itself, and of the motion

MuJoCo reads the URDF by itself; controllers, armature, damping and friction are set in its own model.
"""

import csv
import json
import sys
from pathlib import Path

import mujoco
import numpy as np

RUNS = 4
SECONDS = 20.0
RATE_HZ = 100
STEP_S = 1e-3
ENCODER_RAD = 2 * np.pi / 2**16
DELAY_STEPS = 24


def properties(n):
    """Of each joint, from the base."""
    random = np.random.default_rng(1992)
    stiffness = 800.0 / (1.0 + np.arange(n)) ** 1.5
    return {
        "stiffness": stiffness,
        "damping": stiffness * random.uniform(0.03, 0.06, n),
        "armature": 0.4 * stiffness / stiffness[0],
        # two joints without dry friction
        "frictionloss": stiffness * 0.008 * (np.arange(n) % 3 != 1),
        "delay_s": DELAY_STEPS * STEP_S,
    }


def hidden_arm(urdf):
    spec = mujoco.MjSpec.from_file(str(urdf))
    spec.option.timestep = STEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    own = properties(len(spec.joints))
    for joint, stiffness in zip(spec.joints, own["stiffness"]):
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
        actuator = spec.add_actuator()
        actuator.target = joint.name
        actuator.trntype = mujoco.mjtTrn.mjTRN_JOINT
        actuator.set_to_position(kp=stiffness)
    model = spec.compile()
    model.dof_armature[:] = own["armature"]
    # its shape depends on the version of MuJoCo
    model.dof_damping[:] = own["damping"] if model.dof_damping.ndim == 1 else own["damping"][:, None]
    model.dof_frictionloss[:] = own["frictionloss"]
    # friction of MuJoCo is soft: as stiff as its step allows
    model.dof_solref[:] = [2 * STEP_S, 1.0]
    model.dof_solimp[:] = [0.99, 0.999, 0.001, 0.5, 2]
    return model, own


def move(model, time_s, commands, start, delay_steps):
    """Positions at the stamps of the commands, which lie on lines between them."""
    data = mujoco.MjData(model)
    data.qpos[:] = start
    # before the first command an actuator with a delay has that one in its memory, not 0
    for k, command in enumerate(commands[0]):
        if model.actuator_delay[k] > 0.0:
            memory = np.full((model.actuator_history[k][0], 1), command)
            mujoco.mj_initCtrlHistory(model, data, k, None, memory)
    positions = []
    steps = round((time_s[1] - time_s[0]) / model.opt.timestep)
    fine_s = np.arange(steps * len(time_s)) * model.opt.timestep
    fine = np.stack([np.interp(fine_s - delay_steps * STEP_S, time_s, c) for c in commands.T], axis=1)
    for k, command in enumerate(fine):
        if k % steps == 0:
            positions.append(data.qpos.copy())
        data.ctrl[:] = command
        mujoco.mj_step(model, data)
    return np.array(positions)


def draw_commands(time_s, n, random):
    columns = []
    for joint in range(n):
        centre = random.uniform(-0.6, 0.6)
        command = np.full_like(time_s, centre)
        for _ in range(3):
            frequency_hz = np.exp(random.uniform(np.log(0.05), np.log(0.5)))
            command += 0.25 * np.sin(2 * np.pi * (frequency_hz * time_s + random.uniform()))
        columns.append(command)
    return np.stack(columns, axis=1)


def write(path, time_s, names, columns):
    with open(path, "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["t", *(f"{joint}/{what}" for joint in names for what in columns)])
        for k, t in enumerate(time_s):
            rows.writerow([f"{t:.4f}", *(f"{columns[what][k, j]:.9f}" for j in range(len(names)) for what in columns)])


def read(path):
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    values = np.array(rows, dtype=float)
    names = [name.removesuffix("/command") for name in header if name.endswith("/command")]
    of = lambda what: np.stack([values[:, header.index(f"{joint}/{what}")] for joint in names], axis=1)
    return names, values[:, 0], of("command"), of("position")


def record(folder, urdf):
    model, own = hidden_arm(urdf)
    names = [model.joint(j).name for j in range(model.njnt)]
    random = np.random.default_rng(101)
    time_s = np.arange(round(SECONDS * RATE_HZ)) / RATE_HZ
    for k in range(RUNS):
        commands = draw_commands(time_s, len(names), random)
        positions = move(model, time_s, commands, commands[0], DELAY_STEPS)
        recorded = np.round(positions / ENCODER_RAD) * ENCODER_RAD
        write(folder / f"run_{k}.csv", time_s, names, {"command": commands, "position": recorded})
    print(json.dumps({name: np.asarray(value).tolist() for name, value in own.items()} | {"joints": names}))


def replay(folder, mjcf):
    names, time_s, commands, positions = read(folder / f"run_{RUNS - 1}.csv")
    model = mujoco.MjModel.from_xml_path(str(mjcf))
    model.opt.timestep = STEP_S
    assert [model.joint(j).name for j in range(model.njnt)] == names
    found = move(model, time_s, commands, positions[0], 0)
    rms = lambda error: np.sqrt(np.mean(error**2, axis=0)).tolist()
    print(json.dumps({"command": rms(commands - positions), "model": rms(found - positions)}))


{"record": record, "replay": replay}[sys.argv[1]](Path(sys.argv[2]), Path(sys.argv[3]))
