#include "plumbline/frontend/image_pair.hpp"

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "estimator/simulation.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;
using test::SimulatedRgbd;

namespace {

constexpr int width = SimulatedRgbd::width, height = SimulatedRgbd::height;
template <class S>
using RgbdRig = Rig<Rgbd<Pinhole<S>, width * height>>;
template <class S>
using MonoRig = Rig<Mono<Pinhole<S>, width * height>>;

template <class Sensors>
Sensors rig_of(const Pinhole<double>& camera) {
  using S = typename Sensors::Scalar;
  Sensors rig{};
  rig.vision.camera = {S(camera.fx), S(camera.fy), S(camera.cx), S(camera.cy), {}};
  rig.vision.width = width;
  rig.vision.height = height;
  return rig;
}

const SimulatedRgbd& room() {
  static const SimulatedRgbd simulated(3, 2, 10);
  return simulated;
}

}  // namespace

TEST_CASE("image_pair: images have the size of the rig, depth the size of the image or none") {
  const auto rig = rig_of<RgbdRig<float>>(room().camera);
  RgbdRig<float>::Frame frame;
  frame.gray = room().frames[0].gray.view();
  REQUIRE(ImagePair<RgbdRig<float>>::has_right_size(rig, frame));
  frame.depth = room().frames[0].depth.view();
  REQUIRE(ImagePair<RgbdRig<float>>::has_right_size(rig, frame));
  frame.depth.width -= 1;
  REQUIRE_FALSE(ImagePair<RgbdRig<float>>::has_right_size(rig, frame));
  frame.depth = {};
  frame.gray.height -= 1;
  REQUIRE_FALSE(ImagePair<RgbdRig<float>>::has_right_size(rig, frame));
  REQUIRE_FALSE(ImagePair<MonoRig<float>>::has_right_size(rig_of<MonoRig<float>>(room().camera), {}));
}

TEMPLATE_TEST_CASE("image_pair: the new image beside the kept one, and where that was taken", "", RgbdRig<float>,
                   RgbdRig<double>, MonoRig<double>) {
  using Sensors = TestType;
  using S = typename Sensors::Scalar;
  const auto rig = rig_of<Sensors>(room().camera);
  const auto images = std::make_unique<ImagePair<Sensors>>(RotationAlignmentOptions{});
  const auto see = [&](std::size_t i) {
    typename Sensors::Frame frame;
    frame.t_ns = room().t_ns[i];
    frame.gray = room().frames[i].gray.view();
    if constexpr (Sensors::has_depth) frame.depth = room().frames[i].depth.view();
    REQUIRE(images->take_in(frame));
    return images->view(rig, frame, SE3<S>(), {}, S(0.1));
  };
  const auto shows = [&](const auto& pyramid, std::size_t i) {
    return pyramid.level(0)(100, 100) == room().frames[i].gray.view()(100, 100) &&
           pyramid.level(0)(37, 200) == room().frames[i].gray.view()(37, 200);
  };
  const SE3<S> T(SO3<S>(), Vec<S, 3>(1, 2, 3));
  {
    const View<Sensors> view = see(0);
    REQUIRE(view.t_ns == room().t_ns[0]);
    REQUIRE(view.dt == S(0.1));
    REQUIRE(&view.camera() == &rig.vision.camera);
    REQUIRE(view.depth.empty() != Sensors::has_depth);
    REQUIRE(shows(view.current, 0));
    images->keep(view, T);
  }
  {
    const View<Sensors> view = see(1);
    REQUIRE(shows(view.previous, 0));
    REQUIRE(shows(view.current, 1));
    REQUIRE(view.T_world_previous.p() == T.p());
  }  // not kept
  const View<Sensors> view = see(2);
  REQUIRE(shows(view.previous, 0));
  REQUIRE(shows(view.current, 2));
}

TEMPLATE_TEST_CASE("image_pair: the rotation is estimated on the coarsest level", "", float, double) {
  using S = TestType;
  using Sensors = MonoRig<S>;
  const auto rig = rig_of<Sensors>(room().camera);
  const auto images = std::make_unique<ImagePair<Sensors>>(RotationAlignmentOptions{});
  std::vector<std::uint8_t> moved(std::size_t(width * height));
  const ImageView<const std::uint8_t> image = room().frames[0].gray.view();
  constexpr int shift = 12;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) moved[std::size_t(y * width + x)] = image(std::max(x - shift, 0), y);
  }
  typename Sensors::Frame first{0, image}, second{1, {moved.data(), width, height, width}};
  REQUIRE(images->take_in(first));
  images->keep(images->view(rig, first, SE3<S>(), {}, S(0.1)), SE3<S>());
  REQUIRE(images->take_in(second));
  const View<Sensors> view = images->view(rig, second, SE3<S>(), {}, S(0.1));
  const RotationAlignment<S> found = images->align_motion(view, SE3<S>(), S(1), false);
  REQUIRE(found.valid);
  // What was straight ahead is now seen `shift` pixels to the right.
  const Vec<S, 3> ahead = found.R_cur_prev * Vec<S, 3>::UnitZ();
  REQUIRE(double(ahead.x() / ahead.z()) == Approx(shift / 268.0).epsilon(0.2));
  REQUIRE(std::abs(double(ahead.y())) < 0.01);
  // A wrong guess does no harm: no motion is tried as well.
  const RotationAlignment<S> again =
      images->align_motion(view, SE3<S>(SO3<S>::exp({S(0.8), S(-0.5), S(1)}), zeros<S, 3>()), S(1), false);
  REQUIRE((again.valid && !again.moved && again.cost <= found.cost * S(1.01)));
}

TEST_CASE("image_pair: after a gap the rotation is found in any direction") {
  using Sensors = MonoRig<double>;
  const auto rig = rig_of<Sensors>(room().camera);
  const auto images = std::make_unique<ImagePair<Sensors>>(RotationAlignmentOptions{});
  std::vector<std::uint8_t> moved(std::size_t(width * height));
  const ImageView<const std::uint8_t> image = room().frames[0].gray.view();
  const int shift = GENERATE(-110, -70, 70, 110);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) moved[std::size_t(y * width + x)] = image(std::clamp(x - shift, 0, width - 1), y);
  }
  Sensors::Frame first{0, image}, second{1, {moved.data(), width, height, width}};
  REQUIRE(images->take_in(first));
  images->keep(images->view(rig, first, SE3<double>(), {}, 0.1), SE3<double>());
  REQUIRE(images->take_in(second));
  const View<Sensors> view = images->view(rig, second, SE3<double>(), {}, 0.1);
  const auto direction = [&](bool after_gap) {
    const Vec<double, 3> ahead = images->align_motion(view, {}, 1.0, after_gap).R_cur_prev * Vec<double, 3>::UnitZ();
    return ahead.x() / ahead.z();
  };
  CHECK(direction(true) == Approx(shift / 268.0).epsilon(0.2));
  CHECK_FALSE(direction(false) == Approx(shift / 268.0).epsilon(0.2));
}

TEST_CASE("image_pair: a black image is unusable, a blurred or half as bright one is not") {
  using Sensors = MonoRig<double>;
  const auto rig = rig_of<Sensors>(room().camera);
  const auto images = std::make_unique<ImagePair<Sensors>>(RotationAlignmentOptions{});
  const ImageView<const std::uint8_t> image = room().frames[0].gray.view();
  const auto shows = [&](auto&& pixel) {
    std::vector<std::uint8_t> pixels;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) pixels.push_back(std::uint8_t(pixel(x, y)));
    }
    Sensors::Frame frame{1, {pixels.data(), width, height, width}};
    REQUIRE(images->take_in(frame));
    return images->has_contrast();
  };
  Sensors::Frame first{0, image};
  REQUIRE(images->take_in(first));
  images->keep(images->view(rig, first, SE3<double>(), {}, 0.1), SE3<double>());
  CHECK_FALSE(shows([](int, int) { return 0; }));
  CHECK_FALSE(shows([](int, int) { return 255; }));
  CHECK_FALSE(shows([&](int x, int y) { return image(x, y) / 16; }));
  CHECK(shows([&](int x, int y) { return image(x, y) / 2; }));
  CHECK(shows([&](int x, int y) {
    int sum = 0;
    for (int k = -7; k <= 7; ++k) sum += image(std::clamp(x + k, 0, width - 1), y);
    return sum / 15;
  }));
}

TEST_CASE("image_pair: a picture again, and almost") {
  using Sensors = MonoRig<double>;
  const auto rig = rig_of<Sensors>(room().camera);
  const auto images = std::make_unique<ImagePair<Sensors>>(RotationAlignmentOptions{});
  const auto gray = room().frames[0].gray.view();
  std::vector<std::uint8_t> copy(gray.row(0), gray.row(0) + width * height);
  const auto see = [&](const std::uint8_t* pixels, TimeNs t_ns) {
    Sensors::Frame frame;
    frame.t_ns = t_ns;
    frame.gray = {pixels, width, height, width};
    REQUIRE(images->take_in(frame));
    return images->view(rig, frame, SE3<double>(), {}, 0.1);
  };
  images->keep(see(gray.row(0), 0), {});
  (void)see(copy.data(), 1);
  CHECK(images->repeats());
  for (int v = 100; v < 140; ++v) {
    for (int u = 100; u < 140; ++u) copy[std::size_t(v * width + u)] ^= 4;
  }
  (void)see(copy.data(), 2);
  CHECK_FALSE(images->repeats());
}

TEST_CASE("image_pair: the rotation is that of the scene, not of what a mask excludes") {
  using Sensors = MonoRig<double>;
  const auto rig = rig_of<Sensors>(room().camera);
  const auto error_rad = [&](bool with_mask) {
    const auto images = std::make_unique<ImagePair<Sensors>>(RotationAlignmentOptions{});
    testing::Image<std::uint8_t> used(width, height);
    const auto is_hood = [](int y) { return y >= height / 2; };
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) used.view()(x, y) = is_hood(y) ? 0 : 255;
    }
    if (with_mask) REQUIRE(images->set_mask(rig, used.view()));
    double error = 0;
    for (int i = 0; i < 2; ++i) {
      testing::Image<std::uint8_t> image(width, height);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const int bars = 128 + (x / 16 % 2 == 0 ? 100 : -100);
          image.view()(x, y) = is_hood(y) ? std::uint8_t(bars) : room().frames[std::size_t(i)].gray.view()(x, y);
        }
      }
      REQUIRE(images->take_in({room().t_ns[std::size_t(i)], image.view()}));
      const View<Sensors> view = images->view(rig, {room().t_ns[std::size_t(i)], image.view()}, SE3<double>(), {}, 0.1);
      const SE3<double> T_cur_prev = room().T_world_cam[1].inverse() * room().T_world_cam[0];
      if (i == 1) {
        const auto found = images->align_motion(view, SE3<double>(SO3<double>(), T_cur_prev.p()), 2.0, false);
        REQUIRE(found.valid);
        error = (found.R_cur_prev * T_cur_prev.rotation().inverse()).log().norm();
      }
      images->keep(view, SE3<double>());
    }
    return error;
  };
  REQUIRE(error_rad(true) < 0.02);  // a third of a pixel of the thumbnail
  REQUIRE(error_rad(false) > 2 * error_rad(true));
}

TEST_CASE("image_pair: a mask of another size is refused, and the one before stays") {
  using Sensors = MonoRig<float>;
  const auto rig = rig_of<Sensors>(room().camera);
  const auto images = std::make_unique<ImagePair<Sensors>>(RotationAlignmentOptions{});
  const testing::Image<std::uint8_t> right(width, height), wrong(width, height - 1);
  const Sensors::Frame frame{room().t_ns[0], room().frames[0].gray.view()};
  const auto is_masked = [&] {
    REQUIRE(images->take_in(frame));
    return images->view(rig, frame, SE3<float>(), {}, 0.1f).current.mask().excludes(5, 5);
  };
  REQUIRE_FALSE(is_masked());
  REQUIRE(images->set_mask(rig, right.view()));
  REQUIRE(is_masked());
  REQUIRE_FALSE(images->set_mask(rig, wrong.view()));
  REQUIRE(is_masked());
  REQUIRE(images->set_mask(rig, {}));
  REQUIRE_FALSE(is_masked());
}
