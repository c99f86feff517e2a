"""One recording, written by NumPy, SciPy, h5py, hdf5storage and rosbags. Run: python others.py FOLDER

Two joints, 60 samples, times from 0 in steps of 5 ms; `sample` makes the numbers, which the tests repeat.
Made with Python 3.11, numpy 2.4.6, scipy 1.17.1, rosbags 0.11.9, h5py 3.16.0: bag.db3, bz2.bag,
none.bag, compressed.mat, version73.mat and turned.npz lie beside this file.
"""

import math
import sys
from pathlib import Path

import h5py
import hdf5storage
import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.io import savemat

SAMPLES, STEP_NS, START_NS = 60, 5_000_000, 1_700_000_000_000_000_000
JOINTS = ["shoulder", "elbow"]

DYNAMIC = """std_msgs/Header header
string[] joint_names
control_msgs/InterfaceValue[] interface_values
"""
INTERFACE = """string[] interface_names
float64[] values
"""
CONTROLLER = """std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint reference
trajectory_msgs/JointTrajectoryPoint feedback
trajectory_msgs/JointTrajectoryPoint error
trajectory_msgs/JointTrajectoryPoint output
"""


def sample(k):
    """Position, velocity and effort of both joints."""
    t = k * STEP_NS / 1e9
    return [math.sin(t), math.cos(2 * t)], [math.cos(t), -2 * math.sin(2 * t)], [3 * t, -0.5 - t]


def arrays():
    columns = [np.array([sample(k)[q] for k in range(SAMPLES)]) for q in range(3)]
    return np.arange(SAMPLES) * STEP_NS / 1e9, *columns


def write_arrays(folder):
    t, q, dq, tau = arrays()
    np.savez(folder / "matrices.npz", t=t, q=q, dq=dq, tau=tau, joint_names=np.array(JOINTS), note="x")
    np.savez_compressed(folder / "turned.npz", time=t, qpos=q.T, qvel=np.asfortranarray(dq), tau=tau, dt=0.005)
    columns = {"t": t}
    for j, name in enumerate(JOINTS):
        columns |= {f"{name}/position": q[:, j], f"{name}/velocity": dq[:, j], f"{name}/effort": tau[:, j]}
    np.savez(folder / "columns.npz", **columns)
    for name, compressed in [("plain", False), ("compressed", True)]:
        variables = {"t": t, "q": q, "dq": dq, "tau": tau, "joint_names": np.array(JOINTS, dtype=object)}
        savemat(folder / f"{name}.mat", variables, do_compression=compressed)
    write_73(folder / "version73.mat", t, q, dq, tau)
    savemat(folder / "structure.mat", {"log": {"time": t, "q": q.T, "dq": dq.T, "tau": tau.T}, "gain": 3.0})


def write_73(path, t, q, dq, tau):
    """A structure as MATLAB writes it for version 7.3: columns first, letters of UTF-16, cells by reference, chunks of zlib."""
    with h5py.File(path, "w", userblock_size=512, libver="earliest") as file:
        log = file.create_group("log")
        log.attrs["MATLAB_class"] = np.bytes_("struct")
        for name, values in [("t", t[:, None]), ("q", q), ("dq", dq), ("tau", tau)]:
            turned = np.ascontiguousarray(values.T)
            array = log.create_dataset(name, data=turned, chunks=(turned.shape[0], 25), compression="gzip")
            array.attrs["MATLAB_class"] = np.bytes_("double")
        cells = log.create_dataset("joint_names", (len(JOINTS), 1), dtype=h5py.ref_dtype)
        cells.attrs["MATLAB_class"] = np.bytes_("cell")
        hidden = file.create_group("#refs#")
        for j, name in enumerate(JOINTS):
            letters = hidden.create_dataset("ab"[j], data=np.array([[ord(letter)] for letter in name], dtype=np.uint16))
            letters.attrs["MATLAB_class"] = np.bytes_("char")
            cells[j, 0] = letters.ref
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    path.write_bytes(header + path.read_bytes()[len(header) :])


def write_hdf5(folder):
    """HDF5 with groups, single precision, and what hdf5storage makes of a dict."""
    t, q, dq, tau = arrays()
    with h5py.File(folder / "groups.h5", "w") as file:
        file["time"] = t
        file["observations/qpos"], file["observations/qvel"], file["observations/effort"] = q, dq, tau
        file["observations/names"] = JOINTS
        file.attrs["sim"] = False
    variables = {"t": t[:, None], "q": q, "dq": dq, "tau": tau, "joint_names": np.array(JOINTS, dtype=object)}
    hdf5storage.savemat(str(folder / "storage.mat"), variables, format="7.3")


def write_bag(writer, store, names, encoded, topics):
    header, stamp = names["std_msgs/msg/Header"], names["builtin_interfaces/msg/Time"]
    point, duration = names["trajectory_msgs/msg/JointTrajectoryPoint"], names["builtin_interfaces/msg/Duration"]
    connections = {}
    for topic, kind in topics.items():
        connections[topic] = writer.add_connection(topic, kind, typestore=store)
    empty = np.zeros(0)
    for k in range(SAMPLES):
        ns = START_NS + k * STEP_NS
        lists = [np.array(each) for each in sample(k)]
        extra = {"seq": k} if encoded == "ros1" else {}
        head = header(stamp=stamp(sec=ns // 10**9, nanosec=ns % 10**9), frame_id="base", **extra)
        for topic, kind in topics.items():
            if kind.endswith("/JointState"):
                message = names[kind](header=head, name=JOINTS, position=lists[0], velocity=lists[1], effort=lists[2])
            elif kind.endswith("/DynamicJointState"):
                interface = names["control_msgs/msg/InterfaceValue"]
                values = [
                    interface(interface_names=["position", "velocity", "effort"], values=np.array([x[j] for x in lists]))
                    for j in range(2)
                ]
                message = names[kind](header=head, joint_names=JOINTS, interface_values=values)
            elif kind.endswith("/JointTrajectoryControllerState"):

                def at(*lists):
                    q, v, tau = lists
                    zero = duration(sec=0, nanosec=0)
                    return point(positions=q, velocities=v, accelerations=empty, effort=tau, time_from_start=zero)

                wrong = [each + 7 for each in lists]
                message = names[kind](
                    header=head, joint_names=JOINTS, reference=at(*wrong), feedback=at(*lists), error=at(*wrong),
                    output=at(*wrong),
                )
            else:
                message = names[kind](data="hello")
            serialise = store.serialize_ros1 if encoded == "ros1" else store.serialize_cdr
            writer.write(connections[topic], ns, serialise(message, kind))


def write_bags(folder):
    store = get_typestore(Stores.ROS2_HUMBLE)
    for text, name in [
        (INTERFACE, "control_msgs/msg/InterfaceValue"),
        (DYNAMIC, "control_msgs/msg/DynamicJointState"),
        (CONTROLLER, "control_msgs/msg/JointTrajectoryControllerState"),
    ]:
        store.register(get_types_from_msg(text, name))
    topics = {
        "/joint_states": "sensor_msgs/msg/JointState",
        "/dynamic_joint_states": "control_msgs/msg/DynamicJointState",
        "/controller_state": "control_msgs/msg/JointTrajectoryControllerState",
        "/chatter": "std_msgs/msg/String",
    }
    for plugin in [StoragePlugin.SQLITE3, StoragePlugin.MCAP]:
        with Writer2(folder / f"bag_{plugin.name.lower()}", version=9, storage_plugin=plugin) as writer:
            write_bag(writer, store, store.types, "cdr", topics)
    store = get_typestore(Stores.ROS1_NOETIC)
    topics = {"/joint_states": "sensor_msgs/msg/JointState", "/chatter": "std_msgs/msg/String"}
    for compression in [None, Writer1.CompressionFormat.BZ2, Writer1.CompressionFormat.LZ4]:
        name = "none" if compression is None else compression.name.lower()
        writer = Writer1(folder / f"{name}.bag")
        if compression is not None:
            writer.set_compression(compression)
        with writer:
            write_bag(writer, store, store.types, "ros1", topics)


def main():
    folder = Path(sys.argv[1])
    write_arrays(folder)
    write_hdf5(folder)
    write_bags(folder)


main()
