# The configurations of the program: the product of these three lists. Each entry is a name and its C++ type
# (configuration.hpp); features may depend on the sensors. A sensor combination, a set of features or a backend is one
# line here, and nothing else.

set(plumbline_sensors
  "mono     = pl::Rig<MonoCamera>"
  "mono-imu = pl::Rig<MonoCamera, pl::Imu>"
  "rgbd     = pl::Rig<RgbdCamera>"
  "rgbd-imu = pl::Rig<RgbdCamera, pl::Imu>")

set(plumbline_features
  "points                 = pl::Features<pl::Points<400>>"
  "lines                  = LinesAlone<Sensors>"
  "points+lines           = pl::Features<pl::Points<400>, pl::Lines<100>>"
  "points+collinear       = pl::Features<pl::Points<400>, pl::Collinear<100>>"
  "points+lines+collinear = pl::Features<pl::Points<400>, pl::Lines<100>, pl::Collinear<100>>")

set(plumbline_backends
  "window = pl::SlidingWindow<10>"
  "direct = pl::DirectGaussNewton<>")

# Published systems by their names; those with `+ map` always have a map.
set(plumbline_systems
  "semi-direct-vio   = mono-imu/points+lines/direct"
  "rgbd-inertial-vio = rgbd-imu/points+lines/window"
  "lap-slam          = mono/points+collinear/window + map")
