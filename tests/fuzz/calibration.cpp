// Any bytes as a calibration: the reader returns one that a camera can be made of, or throws a ReadError.
#include <cmath>

#include "fuzz_folder.hpp"
#include "plumbline/io/calibration.hpp"
#include "plumbline/io/make_camera.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryDirectory folder;
  const std::filesystem::path file = folder.write("calibration.yaml", text_of(data, size));
  expect_read_error_at_most([&] {
    const plumbline::io::Calibration calibration = plumbline::io::read_calibration(file);
    require(calibration.camera.width > 0 && calibration.camera.height > 0, "an image has pixels");
    for (const double x : calibration.camera.intrinsics) require(std::isfinite(x), "intrinsics are finite");
    if (calibration.T_body_camera)
      require(calibration.T_body_camera->R().allFinite() && calibration.T_body_camera->p().allFinite(),
              "a pose is finite");
    const auto camera = plumbline::io::make_camera<double>(calibration.camera);
    (void)camera.project(plumbline::Vec<double, 3>(0.1, 0.1, 1));
  });
  return 0;
}
