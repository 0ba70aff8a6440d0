"""ROS 2 nodes: a scene, a recorder, a replay, studies and a page in the browser; the only room that imports rclpy.

* `entry`: the executables, and nodes as processes (`started`, `node_command`); it needs no ROS until one runs.
* `sim_node`, `recorder_node`, `replay_node`, `uq_node`, `watch_node`: the nodes, with their tables `PARAMETERS`.
* `graph`: `Graph`, the other nodes as the command line sees them; `messages`: types of messages, and data from them.
* `launching`: what the launch files start; `demo`: the demonstration.

Inside the room: `base_node` (the base of all nodes), `outlet` (publishers of messages that are bytes), `pacing`
(messages on the wall clock, a thread), `node_parameters` (parameters as data), `simulation_loop`, `studies` (the work
of sim_node and uq_node, without ROS).
sim_node is three files: wiring in `sim_node`, commands and runs in `simulation_loop`, time in `pacing`.
"""
