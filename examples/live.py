"""Starts a bearing as a ROS 2 node, listens to the wrench on one of its balls, and draws what came."""

import subprocess

import matplotlib.pyplot as plt
import rclpy
from geometry_msgs.msg import WrenchStamped

NODE = ["bearing_twin", "node", "start", "sim_node", "-p", "scene:=bearing_6203_loose", "-p", "discovery:=0.0"]
MESSAGES = 100  # at 100 a second

rclpy.init()
listener = rclpy.create_node("listener")
wrenches = []
listener.create_subscription(WrenchStamped, "/bearing/ball_0/wrench", wrenches.append, 10)
node = subprocess.Popen(NODE)
while len(wrenches) < MESSAGES and node.poll() is None:
    rclpy.spin_once(listener, timeout_sec=0.1)
node.terminate()
node.wait()
listener.destroy_node()
rclpy.shutdown()

times = [message.header.stamp.sec + message.header.stamp.nanosec * 1e-9 for message in wrenches]
figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
for name in "xyz":
    axes.plot(times, [getattr(message.wrench.force, name) for message in wrenches], label=f"F{name}")
axes.set(xlabel="simulation time [s]", ylabel="force on ball 0 [N]", title="Received on /bearing/ball_0/wrench")
figure.legend(ncols=3, loc="outside lower center")
figure.savefig("live.png", dpi=100)
print(f"{len(wrenches)} wrenches from {times[0]:.2f} s to {times[-1]:.2f} s")
