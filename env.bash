# Sets up a bash shell for the ROS 2 in .venv after `make setup`:  source env.bash
# Paths of another ROS installation leave this shell, because mixing two breaks both.

bearing_twin_root="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
if [ -n "${AMENT_PREFIX_PATH:-}" ]; then
  unset AMENT_PREFIX_PATH COLCON_PREFIX_PATH CMAKE_PREFIX_PATH PYTHONPATH LD_LIBRARY_PATH _ROS_WHEELS_BOOTSTRAP_COMPLETE
fi
unset RMW_IMPLEMENTATION
source "$bearing_twin_root/.venv/bin/activate"
export AMENT_PREFIX_PATH="$VIRTUAL_ENV" ROS_DISTRO=jazzy
# For C++: headers and CMake packages of the messages, and their libraries. install/ puts its own before these.
export CMAKE_PREFIX_PATH="$VIRTUAL_ENV${CMAKE_PREFIX_PATH:+:$CMAKE_PREFIX_PATH}"
export LD_LIBRARY_PATH="$VIRTUAL_ENV/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
export ROS_AUTOMATIC_DISCOVERY_RANGE="${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}"
if [ -f "$bearing_twin_root/install/local_setup.bash" ]; then
  source "$bearing_twin_root/install/local_setup.bash"
fi
unset bearing_twin_root
