#include "plumbline_ros2/parameters.hpp"

#include <limits>
#include <string>

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"
#include "temporary_directory.hpp"

using namespace plumbline::ros2;

namespace {

std::string refusal(const Parameters& p) {
  return message_of([&] { check(p); });
}
template <class Value>
std::string refusal_of(Value Parameters::*member, const Value& value) {
  Parameters p;
  p.*member = value;
  return refusal(p);
}

}  // namespace

TEST_CASE("parameters that the node does not have are refused") {
  for (const std::string& name : parameter_names()) REQUIRE(message_of([&] { require_known(name); }).empty());
  for (const char* name : {"use_sim_time", "qos_overrides./tf.publisher.depth", "start_type_description_service"})
    REQUIRE(message_of([&] { require_known(name); }).empty());
  REQUIRE(message_of([] { require_known("odom_fram"); }) ==
          "parameter \"odom_fram\" is unknown, did you mean \"odom_frame\"?");
  REQUIRE(message_of([] { require_known("zzz"); }).find("known are config, calibration") != std::string::npos);
  REQUIRE(!message_of([] { require_known(""); }).empty());
}

TEST_CASE("values that cannot be meant are refused by the name of the parameter") {
  REQUIRE(refusal({}).empty());
  REQUIRE(refusal_of(&Parameters::queue, std::int64_t{0}).find("queue") != std::string::npos);
  REQUIRE(refusal_of(&Parameters::depth_scale, -1.0).find("depth_scale") != std::string::npos);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(refusal_of(&Parameters::depth_scale, nan).find("depth_scale") != std::string::npos);
  REQUIRE(refusal_of(&Parameters::depth_tolerance_s, nan).find("depth_tolerance_s") != std::string::npos);
  REQUIRE(refusal_of(&Parameters::path_length, std::int64_t{-1}).find("path_length") != std::string::npos);
  REQUIRE(refusal_of(&Parameters::odom_frame, std::string("/odom")).find("leading slash") != std::string::npos);
  REQUIRE(refusal_of(&Parameters::odom_frame, std::string("base_link")).find("differ") != std::string::npos);
  REQUIRE(refusal_of(&Parameters::T_base_body, {1, 2, 3}).find("7 values") != std::string::npos);
  REQUIRE(refusal_of(&Parameters::T_base_body, {0, 0, 0, 0, 0, 0, 2}).find("unit length") != std::string::npos);
  REQUIRE(refusal_of(&Parameters::T_base_body, {nan, 0, 0, 0, 0, 0, 1}).find("finite") != std::string::npos);
}

TEST_CASE("T_base_body is x y z and a quaternion x y z w") {
  Parameters p;
  p.T_base_body = {1, 2, 3, 0.5, -0.5, 0.5, 0.5};
  REQUIRE(refusal(p).empty());
  const plumbline::SE3<double> T = T_base_body_of(p, true);
  REQUIRE(T.p() == plumbline::Vec<double, 3>(1, 2, 3));
  REQUIRE(T.rotation().quaternion().y() == Approx(-0.5));
  REQUIRE(minus(T_base_body_of({}, false), default_T_base_body(false)).norm() == 0);
}
