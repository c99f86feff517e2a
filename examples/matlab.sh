#!/bin/sh
# From a MATLAB file to a diagnosis: examples/matlab.sh [LOG [URDF]]
#
# LOG has the times t [s], positions q [rad] and efforts tau [N m], samples by joints, alone or as a structure:
#
#     log.t = t; log.q = q; log.tau = tau; log.joint_names = {'shoulder_pan_joint', ...};
#     save('log.mat', 'log')
#
# With joint_names no mapping is needed to know the joints.
set -eu
here=$(dirname "$0")
log=${1:-$here/logs/matlab.mat}
robot=${2:-$here/../urdf/ur5.urdf}

armident info "$log" --robot "$robot" --write-mapping matlab_mapping.toml
armident diagnose "$robot" "$log" --mapping matlab_mapping.toml --report matlab_report.html
