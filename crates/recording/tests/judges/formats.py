"""Recordings by other people's writers: joint_states.mcap (mcap-ros2-support), joint_states.parquet, decimals.parquet and the
folder lerobot (pyarrow). Run: python formats.py

MCAP: topic /joint_states with two joints whose order changes and a gripper that publishes by itself,
velocities only of the arm, a clock stamp; topic /tf_static of another message; zstd chunks.
Parquet: the same samples, time as a timestamp column, effort with an empty value, a column of text.
Folder: the layout of LeRobot 3, two episodes in one file, lists of fixed and of free length.

The numbers are those of `sample` below, which the tests repeat.
Made with Python 3.11, mcap 1.6.0, mcap-ros2-support 0.6.0, pyarrow 26.0.1.
"""

import json
import math
from decimal import Decimal
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
from mcap.writer import CompressionType
from mcap_ros2.writer import Writer

HERE = Path(__file__).parent
SAMPLES, START_NS, STEP_NS = 120, 1_700_000_000_250_000_000, 5_000_000

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
STRING = "string data\n"


def sample(k):
    """Position, velocity and effort of shoulder and elbow at sample k."""
    t = k * STEP_NS / 1e9
    return [math.sin(t), math.cos(2 * t)], [math.cos(t), -2 * math.sin(2 * t)], [3 * t, -0.5]


def stamp(ns):
    return {"sec": ns // 1_000_000_000, "nanosec": ns % 1_000_000_000}


def write_mcap():
    with open(HERE / "joint_states.mcap", "wb") as file:
        with Writer(file, compression=CompressionType.ZSTD) as writer:
            joints = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
            text = writer.register_msgdef("std_msgs/msg/String", STRING)
            writer.write_message("/chatter", text, {"data": "hello"}, log_time=START_NS)
            for k in range(SAMPLES):
                ns = START_NS + k * STEP_NS
                names, lists = ["shoulder", "elbow"], sample(k)
                if k % 3 == 1:
                    names, lists = names[::-1], [each[::-1] for each in lists]
                message = {
                    "header": {"stamp": stamp(ns), "frame_id": "base"},
                    "name": names,
                    "position": lists[0],
                    "velocity": lists[1],
                    "effort": lists[2],
                }
                writer.write_message("/joint_states", joints, message, log_time=ns)
                if k % 10 == 0:
                    message = {
                        "header": {"stamp": stamp(ns), "frame_id": ""},
                        "name": ["finger"],
                        "position": [0.01],
                        "velocity": [],
                        "effort": [],
                    }
                    writer.write_message("/joint_states", joints, message, log_time=ns)


def write_parquet():
    rows = [sample(k) for k in range(SAMPLES)]
    efforts = [row[2][0] for row in rows]
    efforts[7] = None
    table = pa.table({
        "t": pa.array([START_NS + k * STEP_NS for k in range(SAMPLES)], pa.timestamp("ns")),
        "shoulder/position": [row[0][0] for row in rows],
        "elbow/position": pa.array([row[0][1] for row in rows], pa.float32()),
        "shoulder/effort": efforts,
        "remark": ["text"] * SAMPLES,
    })
    pq.write_table(table, HERE / "joint_states.parquet", compression="zstd")


def write_decimals():
    """Decimals in 32 and 64 bits, as databases write them."""
    rows = [sample(k) for k in range(SAMPLES)]
    decimal = lambda value, places: Decimal(f"{value:.{places}f}")
    table = pa.table({
        "t": pa.array([decimal(k * STEP_NS / 1e9, 3) for k in range(SAMPLES)], pa.decimal128(9, 3)),
        "shoulder/position": pa.array([decimal(row[0][0], 7) for row in rows], pa.decimal128(9, 7)),
        "shoulder/effort": pa.array([decimal(row[2][0], 12) for row in rows], pa.decimal128(18, 12)),
    })
    pq.write_table(table, HERE / "decimals.parquet", store_decimal_as_integer=True, compression="zstd")


def write_lerobot():
    folder = HERE / "lerobot"
    features = {
        "observation.state": {"dtype": "float64", "shape": [2], "names": ["shoulder.pos", "elbow.pos"]},
        "observation.effort": {"dtype": "float64", "shape": [2], "names": {"motors": ["shoulder", "elbow"]}},
        "action": {"dtype": "float64", "shape": [2], "names": ["shoulder.pos", "elbow.pos"]},
    }
    info = {"codebase_version": "v3.0", "fps": 200, "features": features}
    data = folder / "data" / "chunk-000"
    data.mkdir(parents=True, exist_ok=True)
    (folder / "meta").mkdir(exist_ok=True)
    (folder / "meta" / "info.json").write_text(json.dumps(info, indent=2) + "\n")
    rows = [sample(k) for k in range(SAMPLES)]
    half = SAMPLES // 2
    table = pa.table({
        "observation.state": pa.array([row[0] for row in rows], pa.list_(pa.float64(), 2)),
        "observation.effort": pa.array([row[2] for row in rows], pa.list_(pa.float64())),
        "action": pa.array([[9.0, 9.0]] * SAMPLES, pa.list_(pa.float64(), 2)),
        "timestamp": pa.array([k % half * STEP_NS / 1e9 for k in range(SAMPLES)], pa.float32()),
        "frame_index": [k % half for k in range(SAMPLES)],
        "episode_index": [k // half for k in range(SAMPLES)],
    })
    pq.write_table(table, data / "file-000.parquet")


if __name__ == "__main__":
    write_mcap()
    write_parquet()
    write_decimals()
    write_lerobot()
