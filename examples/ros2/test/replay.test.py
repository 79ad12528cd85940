"""Plays a bag into the node: poses, transforms and diagnostics are there, and agree."""

import time
import unittest

import diagnostic_msgs.msg
import launch
import launch.actions
import launch_ros.actions
import launch_testing.actions
import nav_msgs.msg
import numpy
import rclpy
import tf2_msgs.msg
from launch.substitutions import LaunchConfiguration

TOPICS = ("image", "depth", "camera_info", "imu")


def generate_test_description():
    node = launch_ros.actions.Node(
        package="plumbline_ros2",
        executable="odometry",
        name="plumbline",
        parameters=[LaunchConfiguration("parameters")],
        remappings=[(name, LaunchConfiguration(name)) for name in TOPICS],
    )
    play = launch.actions.ExecuteProcess(cmd=["ros2", "bag", "play", LaunchConfiguration("bag")], output="screen")
    delayed = launch.actions.TimerAction(period=3.0, actions=[play])
    description = launch.LaunchDescription(
        [launch.actions.DeclareLaunchArgument(name) for name in ("bag", "parameters")]
        + [launch.actions.DeclareLaunchArgument(name, default_value="/unused/" + name) for name in TOPICS]
        + [node, delayed, launch_testing.actions.ReadyToTest()]
    )
    return description, {"node": node, "play": play}


class Replay(unittest.TestCase):
    def test_odometry_transforms_and_diagnostics(self, proc_info, play):
        rclpy.init()
        try:
            listener = rclpy.create_node("listener")
            odometry, transforms, levels = [], {}, []
            listener.create_subscription(nav_msgs.msg.Odometry, "odometry", odometry.append, 100)
            listener.create_subscription(
                tf2_msgs.msg.TFMessage,
                "/tf",
                lambda message: transforms.update(
                    ((t.header.stamp.sec, t.header.stamp.nanosec), t)
                    for t in message.transforms
                    if t.child_frame_id == "base_link"
                ),
                100,
            )
            listener.create_subscription(
                diagnostic_msgs.msg.DiagnosticArray,
                "/diagnostics",
                lambda message: levels.extend(s.level for s in message.status if s.name.endswith(": odometry")),
                100,
            )
            end = None
            while end is None or time.monotonic() < end:
                rclpy.spin_once(listener, timeout_sec=0.1)
                if end is None and play.process_details is not None and play.return_code is not None:
                    end = time.monotonic() + 3
        finally:
            rclpy.shutdown()

        self.assertGreater(len(odometry), 20)
        self.assertIn(b"\x00", levels)  # tracking
        stamps = [(m.header.stamp.sec, m.header.stamp.nanosec) for m in odometry]
        self.assertEqual(stamps, sorted(set(stamps)))
        compared = 0
        for stamp, message in zip(stamps, odometry):
            self.assertEqual((message.header.frame_id, message.child_frame_id), ("odom", "base_link"))
            covariance = numpy.array(message.pose.covariance).reshape(6, 6)
            self.assertGreater(numpy.linalg.eigvalsh((covariance + covariance.T) / 2).min(), 0)
            if stamp in transforms:
                position, translation = message.pose.pose.position, transforms[stamp].transform.translation
                self.assertEqual((position.x, position.y, position.z), (translation.x, translation.y, translation.z))
                compared += 1
        self.assertGreater(compared, 10)
