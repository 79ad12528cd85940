"""The node in a process of its own:

  ros2 launch plumbline_ros2 odometry.launch.py parameters:=my.yaml image:=/cam0/image_raw imu:=/imu0
"""

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

TOPICS = {
    "image": "/camera/image_raw",
    "depth": "/camera/depth/image_raw",
    "camera_info": "/camera/camera_info",
    "imu": "/imu/data_raw",
}


def generate_launch_description():
    parameters = get_package_share_directory("plumbline_ros2") + "/config/rgbd.yaml"
    return LaunchDescription(
        [DeclareLaunchArgument("parameters", default_value=parameters, description="YAML file")]
        + [DeclareLaunchArgument(name, default_value=topic, description="topic") for name, topic in TOPICS.items()]
        + [
            Node(
                package="plumbline_ros2",
                executable="odometry",
                name="plumbline",
                output="screen",
                parameters=[LaunchConfiguration("parameters")],
                remappings=[(name, LaunchConfiguration(name)) for name in TOPICS],
            )
        ]
    )
