"""Files that are wrong inside, written by the programs of their formats. Run: python bad.py

Of each format one with text in the place of numbers (`dtype`), one whose joints differ in number (`ragged`), and one with more
missing values than are interpolated (`nan`); two joints, 12 samples. The messages on them are in a snapshot of
tests/bad_input.rs. Made with Python 3.11, h5py 3.16.0, mcap-ros2-support 0.6.0, numpy 2.4.6, pyarrow 26.0.1, scipy 1.17.1.
"""

import json
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from mcap_ros2.writer import Writer
from scipy.io import savemat

HERE = Path(__file__).parent / "bad"
N = 12
T = np.arange(N) * 0.01
Q = np.stack([np.sin(T), np.cos(T)], axis=1)
TAU = Q * 3
HOLES = TAU.copy()
HOLES[3:9, 1] = np.nan
WORDS = np.array([["up", "down"]] * N)

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


def arrays(name, write):
    write(f"{name}_dtype", {"t": T, "q": Q, "tau": WORDS})
    write(f"{name}_ragged", {"t": T, "q": Q, "tau": TAU[:7]})
    write(f"{name}_nan", {"t": T, "q": Q, "tau": HOLES})


def hdf5(name, arrays):
    with h5py.File(HERE / f"{name}.h5", "w") as file:
        for key, values in arrays.items():
            file[key] = values.astype("S4") if values.dtype.kind == "U" else values


def npz(name, arrays):
    np.savez_compressed(HERE / f"{name}.npz", **arrays)


def mat(name, arrays):
    savemat(HERE / f"{name}.mat", {key: x.astype(object) if x.dtype.kind == "U" else x for key, x in arrays.items()})


def parquet():
    columns = {"t": T, "a/position": Q[:, 0], "a/effort": TAU[:, 0]}
    pq.write_table(pa.table(columns | {"a/effort": ["up"] * N}), HERE / "parquet_dtype.parquet")
    pq.write_table(pa.table(columns | {"a/effort": HOLES[:, 1]}), HERE / "parquet_nan.parquet")
    lists = [row.tolist() for row in Q]
    lists[5] = [0.1]
    pq.write_table(pa.table({"timestamp": T, "observation.state": lists}), HERE / "parquet_ragged.parquet")


def mcap(name, kind, text, message):
    with open(HERE / f"mcap_{name}.mcap", "wb") as stream:
        writer = Writer(stream)
        schema = writer.register_msgdef(kind, text)
        for k in range(N):
            ns = 1_700_000_000_000_000_000 + k * 10_000_000
            writer.write_message("/joint_states", schema, message(k, ns), log_time=ns, publish_time=ns)
        writer.finish()


def state(k, ns, effort):
    stamp = {"sec": ns // 10**9, "nanosec": ns % 10**9}
    header = {"stamp": stamp, "frame_id": ""}
    return {"header": header, "name": ["a", "b"], "position": Q[k].tolist(), "velocity": [], "effort": effort}


def main():
    HERE.mkdir(exist_ok=True)
    arrays("npz", npz)
    arrays("mat", mat)
    arrays("hdf5", hdf5)
    parquet()
    mcap("dtype", "std_msgs/msg/Float64MultiArray", "float64[] data\n", lambda k, ns: {"data": Q[k].tolist()})
    mcap("ragged", "sensor_msgs/msg/JointState", JOINT_STATE, lambda k, ns: state(k, ns, TAU[k, : 1 + (k != 5)].tolist()))
    mcap("nan", "sensor_msgs/msg/JointState", JOINT_STATE, lambda k, ns: state(k, ns, HOLES[k].tolist()))
    rows = [f'STATE_MOTOR,{k},"{json.dumps(Q[k].tolist())}","{json.dumps(TAU[k].tolist())}"' for k in range(N)]
    head = "type,timestamp,positions,torques"
    for name, row in [
        ("dtype", 'STATE_MOTOR,5,"[""up"", 1]","[1, 2]"'),
        ("ragged", 'STATE_MOTOR,5,"[1.0]","[1, 2]"'),
        ("nan", 'STATE_MOTOR,5,"[NaN, NaN]","[1, 2]"'),
    ]:
        (HERE / f"sage_{name}.csv").write_text("\n".join([head, *rows[:5], row, *rows[6:]]) + "\n")
    rows = [f"{k},0,base,a,b,{Q[k, 0]},{Q[k, 1]},0,0,{TAU[k, 0]},{TAU[k, 1]}" for k in range(N)]
    for name, row in [
        ("dtype", "5,0,base,a,b,up,1,0,0,1,2"),
        ("ragged", "5,0,base,a,b,1,0,0,1,2"),
        ("nan", "5,0,base,a,b,nan,nan,nan,nan,nan,nan"),
    ]:
        (HERE / f"echo_{name}.csv").write_text("\n".join([*rows[:5], row, *rows[6:]]) + "\n")


main()
