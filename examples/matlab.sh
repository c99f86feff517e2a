#!/bin/sh
# From a MATLAB file to a diagnosis: examples/matlab.sh [LOG [URDF]]
#
# LOG has the times t [s], positions q [rad] and efforts tau [N m], samples by joints, alone or as a structure:
#
#     log.t = t; log.q = q; log.tau = tau; log.joint_names = {'shoulder_pan_joint', ...};
#     save('log.mat', 'log')
#
# With joint_names no mapping is needed; without it, add --robot and --write-mapping as in rtde.sh.
set -eu
here=$(dirname "$0")
log=${1:-$here/logs/matlab.mat}
robot=${2:-$here/../urdf/ur5.urdf}

armident info "$log"
armident diagnose "$robot" "$log" --report matlab_report.html
