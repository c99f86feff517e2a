#!/bin/sh
# From a bag of ROS 2 to a diagnosis: examples/ros2_bag.sh [BAG [URDF]]
#
# BAG is the folder that `ros2 bag record /joint_states` wrote, or one file of it. Bags in SQLite (.db3, the default before
# ROS 2 Jazzy) need a program built with `--features all-formats`. The names in the bag are those of the URDF: no mapping.
set -eu
here=$(dirname "$0")
bag=${1:-$here/logs/ros2_bag}
robot=${2:-$here/../urdf/ur5.urdf}

armident info "$bag"
armident diagnose "$robot" "$bag" --report ros2_report.html
