// What a user of the library writes first: a camera, a pose, a point seen from it.
#include <cmath>
#include <cstdio>

#include <plumbline/camera/pinhole.hpp>
#include <plumbline/lie/se3.hpp>

namespace pl = plumbline;

int main() {
  const pl::Pinhole<float> camera{.fx = 400, .fy = 400, .cx = 320, .cy = 240};
  const pl::SE3<float> T_world_cam(pl::SO3<float>(), pl::Vec<float, 3>(0, 0, -1));
  const pl::Vec<float, 3> p_world(0.5f, 0.25f, 1);
  const pl::Projection<float> seen = camera.project(T_world_cam.inverse() * p_world);
  std::printf("seen at %.1f %.1f px\n", double(seen.uv.x()), double(seen.uv.y()));
  return seen.valid && std::abs(seen.uv.x() - 420) < 1e-3f && std::abs(seen.uv.y() - 290) < 1e-3f ? 0 : 1;
}
