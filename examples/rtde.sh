#!/bin/sh
# From a log of UR's RTDE to a diagnosis: examples/rtde.sh [LOG [URDF]]
#
# LOG is what `record.py` of the RTDE client library wrote. Its joints are numbered: --robot gives them the names of the arm,
# and --write-mapping keeps the guess. Read the mapping before you trust it: `actual_current_0` is in A, `joint_torque_0` in N m.
set -eu
here=$(dirname "$0")
log=${1:-$here/logs/rtde.csv}
robot=${2:-$here/../urdf/ur5.urdf}

armident info "$log" --robot "$robot" --write-mapping rtde_mapping.toml
armident diagnose "$robot" "$log" --mapping rtde_mapping.toml --report rtde_report.html
