"""One run of the UR5 in the layouts of seven programs. Run: python examples/logs/make_logs.py

Each file has every second sample of examples/ur5/train.csv, with the names, units and stamps that its program writes:

    ros2_bag/      ROS 2: two files of MCAP with metadata.yaml, /joint_states beside /tf_static
    ros2_sqlite/   ROS 2 with SQLite, a file of one piece with its metadata
    ros1.bag       ROS 1, compressed by bz2
    lerobot/       LeRobot 3: Parquet and meta/info.json, two episodes
    rtde.csv       UR RTDE: columns of record.py, joints numbered, separated by spaces
    matlab.mat     MATLAB 7: a structure with t, q, qd and tau
    sage/          SAGE of Isaac Sim: lists of all joints in each field
    numpy.npz      NumPy: arrays of samples by joints

The files lie in the repository; this script made them with Python 3.11, mcap 1.6.0, mcap-ros2-support 0.6.0, numpy 2.4.6,
pyarrow 26.0.1, rosbags 0.11.9 and scipy 1.17.1.
"""

import csv
import json
import math
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from mcap.writer import CompressionType
from mcap_ros2.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore
from scipy.io import savemat

HERE = Path(__file__).parent
START_NS = 1_700_000_000_000_000_000

JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def run():
    """Times [s], names, positions [rad] and efforts [N m]."""
    with open(HERE.parent / "ur5" / "train.csv") as file:
        rows = list(csv.reader(file))
    names = [column.rsplit("/", 1)[0] for column in rows[0][1::2]]
    numbers = np.array(rows[1::2], dtype=float)
    q, tau = (np.ascontiguousarray(numbers[:, first::2]) for first in (1, 2))
    return numbers[:, 0], names, q, tau


def stamp(t):
    ns = START_NS + round(t * 1e9)
    return ns, {"sec": ns // 10**9, "nanosec": ns % 10**9}


def ros2_bag(t, names, q, tau):
    folder = HERE / "ros2_bag"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    pieces = [range(0, len(t) // 2), range(len(t) // 2, len(t))]
    files = [f"ros2_bag_{k}.mcap" for k in range(len(pieces))]
    for file, rows in zip(files, pieces):
        with open(folder / file, "wb") as stream:
            writer = McapWriter(stream, compression=CompressionType.ZSTD)
            states = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
            other = writer.register_msgdef("std_msgs/msg/String", "string data\n")
            for k in rows:
                ns, at = stamp(t[k])
                message = {
                    "header": {"stamp": at, "frame_id": "base_link"},
                    "name": names,
                    "position": q[k].tolist(),
                    "velocity": [],
                    "effort": tau[k].tolist(),
                }
                writer.write_message("/joint_states", states, message, log_time=ns, publish_time=ns)
                if k == rows[0]:
                    writer.write_message("/robot_description", other, {"data": "<robot/>"}, log_time=ns, publish_time=ns)
            writer.finish()
    topics = [("/joint_states", "sensor_msgs/msg/JointState", len(t)), ("/robot_description", "std_msgs/msg/String", 2)]
    lines = ["rosbag2_bagfile_information:", "  version: 9", "  storage_identifier: mcap", "  duration:"]
    lines += [f"    nanoseconds: {round((t[-1] - t[0]) * 1e9)}", "  starting_time:"]
    lines += [f"    nanoseconds_since_epoch: {START_NS}", f"  message_count: {len(t) + 2}", "  topics_with_message_count:"]
    for name, kind, count in topics:
        lines += ["    - topic_metadata:", f"        name: {name}", f"        type: {kind}"]
        lines += ["        serialization_format: cdr", "        offered_qos_profiles: []", f"      message_count: {count}"]
    lines += ['  compression_format: ""', '  compression_mode: ""', "  relative_file_paths:"]
    lines += [f"    - {file}" for file in files] + ["  ros_distro: jazzy"]
    (folder / "metadata.yaml").write_text("\n".join(lines) + "\n")


def joint_states(writer, store, encoded, t, names, q, tau):
    types = store.types
    kind = "sensor_msgs/msg/JointState"
    connection = writer.add_connection("/joint_states", kind, typestore=store)
    for k in range(len(t)):
        ns, at = stamp(t[k])
        extra = {"seq": k} if encoded == "ros1" else {}
        head = types["std_msgs/msg/Header"](
            stamp=types["builtin_interfaces/msg/Time"](**at), frame_id="base_link", **extra
        )
        message = types[kind](header=head, name=names, position=q[k], velocity=np.zeros(0), effort=tau[k])
        serialise = store.serialize_ros1 if encoded == "ros1" else store.serialize_cdr
        writer.write(connection, ns, serialise(message, kind))


def bags(*recorded):
    folder = HERE / "ros2_sqlite"
    shutil.rmtree(folder, ignore_errors=True)
    with Writer2(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        joint_states(writer, get_typestore(Stores.ROS2_HUMBLE), "cdr", *recorded)
    file = HERE / "ros1.bag"
    file.unlink(missing_ok=True)
    writer = Writer1(file)
    writer.set_compression(Writer1.CompressionFormat.BZ2)
    with writer:
        joint_states(writer, get_typestore(Stores.ROS1_NOETIC), "ros1", *recorded)


def lerobot(t, names, q, tau):
    folder = HERE / "lerobot"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "data" / "chunk-000").mkdir(parents=True)
    (folder / "meta").mkdir()
    half = len(t) // 2
    episode = np.repeat([0, 1], [half, len(t) - half])
    within = np.concatenate([t[:half] - t[0], t[half:] - t[half]])
    width = len(names)
    lists = lambda rows: pa.FixedSizeListArray.from_arrays(pa.array(rows.ravel(), pa.float64()), width)  # noqa: E731
    table = {
        "observation.state": lists(q),
        "observation.effort": lists(tau),
        "timestamp": pa.array(within, pa.float32()),
        "frame_index": np.concatenate([np.arange(half), np.arange(len(t) - half)]),
        "episode_index": episode,
        "index": np.arange(len(t)),
        "task_index": np.zeros(len(t), dtype=np.int64),
    }
    pq.write_table(pa.table(table), folder / "data" / "chunk-000" / "file-000.parquet", compression="snappy")
    feature = {"dtype": "float64", "shape": [width]}
    info = {
        "codebase_version": "v3.0",
        "robot_type": "ur5",
        "fps": round(1 / float(np.diff(t).mean())),
        "total_episodes": 2,
        "total_frames": len(t),
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "features": {
            "observation.state": feature | {"names": [f"{name}.pos" for name in names]},
            "observation.effort": feature | {"names": [f"{name}.effort" for name in names]},
            "timestamp": {"dtype": "float32", "shape": [1], "names": None},
            "episode_index": {"dtype": "int64", "shape": [1], "names": None},
        },
    }
    (folder / "meta" / "info.json").write_text(json.dumps(info, indent=2) + "\n")


def rtde(t, names, q, tau):
    joints = range(len(names))
    header = ["timestamp", *(f"actual_q_{j}" for j in joints), *(f"joint_torque_{j}" for j in joints), "robot_mode"]
    rows = [" ".join(header)]
    for k in range(len(t)):
        numbers = [f"{1000 + t[k]:.3f}", *(f"{x:.6f}" for x in q[k]), *(f"{x:.4f}" for x in tau[k]), "7"]
        rows.append(" ".join(numbers))
    (HERE / "rtde.csv").write_text("\n".join(rows) + "\n")


def matlab(t, names, q, tau):
    log = {"t": t, "q": q, "tau": tau, "joint_names": np.array(names, dtype=object)}
    savemat(HERE / "matlab.mat", {"log": log, "rate_hz": 50.0}, do_compression=True)


def sage(t, names, q, tau):
    folder = HERE / "sage"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    (folder / "joint_list.txt").write_text("\n".join(names) + "\n")
    dq = np.gradient(q, t, axis=0)
    rows = ["type,timestamp,positions,velocities,torques"]
    for k in range(len(t)):
        lists = [json.dumps([round(float(x), digits) for x in values[k]]) for values, digits in [(q, 6), (dq, 4), (tau, 4)]]
        rows.append(",".join(["STATE_MOTOR", str(round(t[k] * 1e6)), *(f'"{each}"' for each in lists)]))
    (folder / "state_motor.csv").write_text("\n".join(rows) + "\n")


def main():
    recorded = t, names, q, tau = run()
    assert math.isclose(t[1] - t[0], 0.02) and len(names) == 6
    ros2_bag(*recorded)
    bags(*recorded)
    lerobot(*recorded)
    rtde(*recorded)
    matlab(*recorded)
    sage(*recorded)
    np.savez_compressed(HERE / "numpy.npz", t=t, q=q, tau=tau, joint_names=np.array(names))


main()
