"""ROS 2 nodes: a scene, a recorder, a replay, studies and a page in the browser; the only room that imports rclpy.

* `entry`: the executables, and nodes as processes; it needs no ROS until one runs.
* `sim_node`: the node of a scene: its wiring, in front of the simulation loop and the pacing.
* `simulation_loop`: commands and runs of the node of a scene, without ROS.
* `pacing`: messages on the wall clock, in a thread.
* `recorder_node`: the recorder, and what it records.
* `replay_node`: the replay, and the messages of a log as they are due.
* `uq_node`: the node of studies: its wiring, in front of the studies.
* `studies`: goals, progress and results of studies, without ROS.
* `watch_node`: the page in the browser of a run that goes on.
* `node_parameters`: parameters of nodes as data, and their checks.
* `base_node`: the base of all nodes, and their executor.
* `outlet`: publishers of messages that are bytes.
* `messages`: types of messages, data from them, and their quality of service.
* `graph`: the other nodes as the command line sees them.
* `launching`: what the launch files start.
* `demo`: the demonstration.
"""
