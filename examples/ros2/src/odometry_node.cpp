/// The node: subscriptions, publishers and parameters. All else is in include/plumbline_ros2, without ROS.
#include <chrono>
#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include <tf2_ros/transform_broadcaster.h>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <nav_msgs/msg/path.hpp>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <rclcpp/rclcpp.hpp>
#include <rclcpp_components/register_node_macro.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/imu.hpp>

#include "plumbline_ros2/calibration.hpp"
#include "plumbline_ros2/conversions.hpp"
#include "plumbline_ros2/diagnostics.hpp"
#include "plumbline_ros2/odometry.hpp"
#include "plumbline_ros2/parameters.hpp"
#include "plumbline_ros2/session.hpp"
#include "runner.hpp"

namespace plumbline::ros2 {

class OdometryNode : public rclcpp::Node {
 public:
  explicit OdometryNode(const rclcpp::NodeOptions& options) : rclcpp::Node("plumbline", options) {
    read_parameters();
    configuration_ = parameters_.config.empty() ? &configurations().front() : &configuration_named(parameters_.config);
    const bool waits_for_camera_info = needs_camera_info(parameters_, *configuration_);

    odometry_ = create_publisher<nav_msgs::msg::Odometry>("odometry", 10);
    if (parameters_.path_length > 0) path_publisher_ = create_publisher<nav_msgs::msg::Path>("path", 10);
    if (parameters_.publish_tf) transforms_ = std::make_unique<tf2_ros::TransformBroadcaster>(*this);
    diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", 10);
    timer_ = create_wall_timer(std::chrono::seconds(1), [this] { publish_diagnostics(); });

    if (!waits_for_camera_info) begin({});
    subscribe(waits_for_camera_info);
  }

 private:
  void read_parameters() {
    for (const auto& [name, value] : get_node_parameters_interface()->get_parameter_overrides()) require_known(name);
    rcl_interfaces::msg::ParameterDescriptor descriptor;
    descriptor.read_only = true;
    for_each_parameter(parameters_, [&](const char* name, auto& value, const char* description) {
      descriptor.description = description;
      value = declare_parameter(name, value, descriptor);
    });
    check(parameters_);
  }

  void begin(const io::bag::CameraInfoMessage& info) {
    const io::Calibration calibration = calibration_of(parameters_, *configuration_, info);
    for (const std::string& note : calibration.notes) RCLCPP_WARN(get_logger(), "%s", note.c_str());
    session_ = std::make_unique<Session>(
        configuration_->needs, calibration, configuration_->make(calibration, parameters_.map), parameters_,
        Session::Callbacks{[this](const Odometry& odometry) { publish(odometry); },
                           [this](const std::string& note) { RCLCPP_WARN(get_logger(), "%s", note.c_str()); }});
    RCLCPP_INFO(get_logger(), "%s, images of %d x %d", configuration_->name, calibration.camera.width,
                calibration.camera.height);
  }

  void subscribe(bool waits_for_camera_info) {
    using sensor_msgs::msg::CameraInfo;
    using sensor_msgs::msg::Image;
    using sensor_msgs::msg::Imu;
    const rclcpp::QoS images = rclcpp::SensorDataQoS().keep_last(10);
    image_ = create_subscription<Image>("image", images, [this](Image::ConstSharedPtr message) {
      use([&] { session_->add_gray(held_image_of<Image>(std::move(message))); });
    });
    if (configuration_->needs.depth)
      depth_ = create_subscription<Image>("depth", images, [this](Image::ConstSharedPtr message) {
        use([&] { session_->add_depth(held_image_of<Image>(std::move(message))); });
      });
    if (configuration_->needs.imu)
      imu_ = create_subscription<Imu>(
          "imu", rclcpp::SensorDataQoS().keep_last(2000),
          [this](Imu::ConstSharedPtr message) { use([&] { session_->add(imu_sample_of(*message)); }); });
    if (waits_for_camera_info)
      camera_info_ = create_subscription<CameraInfo>(
          "camera_info", rclcpp::SensorDataQoS().keep_last(1), [this](CameraInfo::ConstSharedPtr message) {
            if (session_) return;
            try {
              begin(camera_info_of(*message));
            } catch (const std::exception& error) {
              RCLCPP_ERROR_THROTTLE(get_logger(), *get_clock(), 5000, "%s", error.what());
            }
          });
  }

  /// Callbacks of the subscriptions are in one group, so that one is called at a time.
  void use(const std::function<void()>& add) {
    if (!session_) {
      ++before_calibration_;
      return;
    }
    try {
      add();
    } catch (const std::exception& error) {
      ++unreadable_;
      RCLCPP_WARN_THROTTLE(get_logger(), *get_clock(), 5000, "a message is not used: it %s", error.what());
    }
  }

  /// In the thread of the estimator.
  void publish(const Odometry& odometry) {
    nav_msgs::msg::Odometry message;
    set_stamp(odometry.t_ns, message.header.stamp);
    message.header.frame_id = parameters_.odom_frame;
    message.child_frame_id = parameters_.base_frame;
    set_odometry(odometry, message);
    odometry_->publish(message);

    if (transforms_) {
      send(odometry.t_ns, parameters_.odom_frame, parameters_.base_frame, odometry.T_odom_base);
      if (odometry.T_map_odom) send(odometry.t_ns, parameters_.map_frame, parameters_.odom_frame, *odometry.T_map_odom);
    }
    if (path_publisher_) {
      geometry_msgs::msg::PoseStamped pose;
      pose.header = message.header;
      pose.pose = message.pose.pose;
      path_.header = message.header;
      path_.poses.push_back(pose);
      if (path_.poses.size() > static_cast<std::size_t>(parameters_.path_length))
        path_.poses.erase(path_.poses.begin());
      path_publisher_->publish(path_);
    }
  }

  void send(TimeNs t_ns, const std::string& parent, const std::string& child, const SE3<double>& T_parent_child) {
    geometry_msgs::msg::TransformStamped message;
    set_stamp(t_ns, message.header.stamp);
    message.header.frame_id = parent;
    message.child_frame_id = child;
    set_transform(T_parent_child, message.transform);
    transforms_->sendTransform(message);
  }

  void publish_diagnostics() {
    diagnostic_msgs::msg::DiagnosticArray array;
    array.header.stamp = now();
    diagnostic_msgs::msg::DiagnosticStatus& message = array.status.emplace_back();
    message.name = std::string(get_fully_qualified_name()) + ": odometry";
    message.hardware_id = configuration_->name;
    Status status;
    if (session_) status = session_->status();
    status.counts.before_calibration = before_calibration_;
    status.counts.unreadable = unreadable_;
    set_diagnostics(status, message);
    diagnostics_->publish(array);
    if (message.message == latest_) return;
    latest_ = message.message;
    RCLCPP_INFO(get_logger(), "%s", latest_.c_str());
  }

  Parameters parameters_;
  const Configuration* configuration_ = nullptr;
  rclcpp::Publisher<nav_msgs::msg::Odometry>::SharedPtr odometry_;
  rclcpp::Publisher<nav_msgs::msg::Path>::SharedPtr path_publisher_;
  rclcpp::Publisher<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr diagnostics_;
  std::unique_ptr<tf2_ros::TransformBroadcaster> transforms_;
  nav_msgs::msg::Path path_;
  rclcpp::TimerBase::SharedPtr timer_;
  std::size_t before_calibration_ = 0, unreadable_ = 0;
  std::string latest_;                // of the diagnostics
  std::unique_ptr<Session> session_;  // its thread uses the members above
  rclcpp::Subscription<sensor_msgs::msg::Image>::SharedPtr image_, depth_;
  rclcpp::Subscription<sensor_msgs::msg::Imu>::SharedPtr imu_;
  rclcpp::Subscription<sensor_msgs::msg::CameraInfo>::SharedPtr camera_info_;
};

}  // namespace plumbline::ros2

RCLCPP_COMPONENTS_REGISTER_NODE(plumbline::ros2::OdometryNode)
