// A front end of one's own: how a kind of feature is found in the next image. A policy names the front end of every
// kind; here points are followed by comparing blocks of pixels around the place where the prediction expects them,
// and all else (detection, refinement against the anchor's pixels, depth) is left to PointFlow.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/frontend/flow.hpp"
#include "plumbline/frontend/point_flow.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/testing/room_run.hpp"

namespace pl = plumbline;

struct BlockOptions : pl::PointFlowOptions {
  int search_px = 9;          ///< around the expected place
  float max_difference = 20;  ///< root mean square, of blocks freed of their means
};

template <class Store>
class BlockMatching {
 public:
  using Kind = typename Store::Kind;
  using Sensors = typename Kind::Sensors;
  using S = typename Kind::Scalar;
  using View = pl::View<Sensors>;
  using Options = BlockOptions;  // reached as `options.points`
  static constexpr bool gives_correspondences = true;

  explicit BlockMatching(const Options& options) : options_(options), flow_(options) {}

  void follow(const View& view, const auto& window, Store& store, const pl::SE3<S>& T_world_predicted) {
    const pl::SE3<S> T_cam_world = (T_world_predicted * view.T_body_cam).inverse();
    for (auto& landmark : store.landmarks()) {
      if (!landmark.current.valid) continue;
      pl::Vec<float, 2> found = flow_.expected(view, window, landmark, T_cam_world);
      const bool valid = match(view.previous.level(0), landmark.current.pixel, view.current.level(0), found);
      flow_.observe(view, landmark, valid, found);
    }
  }
  void for_each_correspondence(const View& view, const auto& window, const Store& store, auto&& take) const {
    flow_.for_each_correspondence(view, window, store, take);
  }
  void refine(const View& view, const auto& window, Store& store, const pl::SE3<S>& T_world_body) {
    flow_.refine(view, window, store, T_world_body);
  }
  void locate(const View& view, const auto& window, Store& store, const pl::SE3<S>& T_world_body) {
    flow_.locate(view, window, store, T_world_body);
  }
  void detect(const View& view, const auto& window, Store& store, int slot) { flow_.detect(view, window, store, slot); }

 private:
  using Image = pl::ImageView<const std::uint8_t>;
  static constexpr int half = 4, pixels = (2 * half + 1) * (2 * half + 1);

  /// Moves `place`, where `now` should show what `then` shows at `origin`, to where it does; between pixels by a
  /// parabola.
  bool match(const Image& then, const pl::Vec<float, 2>& origin, const Image& now, pl::Vec<float, 2>& place) const {
    const float border = float(half + options_.search_px + 2);
    if (!then.contains(origin.x(), origin.y(), border) || !now.contains(place.x(), place.y(), border)) return false;
    const int x0 = int(std::lround(place.x())), y0 = int(std::lround(place.y()));
    const pl::Vec<float, 2> whole(std::round(origin.x()), std::round(origin.y()));
    float best = std::numeric_limits<float>::infinity();
    int dx = 0, dy = 0;
    for (int y = -options_.search_px; y <= options_.search_px; ++y) {
      for (int x = -options_.search_px; x <= options_.search_px; ++x) {
        const float d = difference(then, int(whole.x()), int(whole.y()), now, x0 + x, y0 + y);
        if (d < best) best = d, dx = x, dy = y;
      }
    }
    if (!(best < options_.max_difference * options_.max_difference)) return false;
    if (std::max(std::abs(dx), std::abs(dy)) == options_.search_px) return false;  // it may lie further out
    const auto at = [&](int x, int y) {
      return difference(then, int(whole.x()), int(whole.y()), now, x0 + dx + x, y0 + dy + y);
    };
    const auto minimum = [&](float before, float after) {
      const float bend = before + after - 2 * best;
      return bend > 0 ? std::clamp((before - after) / (2 * bend), -0.5f, 0.5f) : 0.0f;
    };
    place =
        pl::Vec<float, 2>(float(x0 + dx) + minimum(at(-1, 0), at(1, 0)), float(y0 + dy) + minimum(at(0, -1), at(0, 1)));
    place += origin - whole;
    return true;
  }

  /// Variance of the difference of two blocks: their means may differ.
  static float difference(const Image& a, int ax, int ay, const Image& b, int bx, int by) {
    int sum = 0, squares = 0;
    for (int y = -half; y <= half; ++y) {
      const std::uint8_t *p = a.row(ay + y) + ax - half, *q = b.row(by + y) + bx - half;
      for (int x = 0; x <= 2 * half; ++x) {
        const int d = int(p[x]) - int(q[x]);
        sum += d;
        squares += d * d;
      }
    }
    const float mean = float(sum) / pixels;
    return float(squares) / pixels - mean * mean;
  }

  Options options_;
  pl::PointFlow<Store> flow_;
};

/// The policy: points by blocks, all other kinds as they come with the library.
struct Blocks {
  template <class Entry, class Store>
  struct Chosen {
    using Type = pl::Flow::Of<Entry, Store>;
  };
  template <int N, template <class> class Loss, class Store>
  struct Chosen<pl::Points<N, Loss>, Store> {
    using Type = BlockMatching<Store>;
  };

  template <class Entry, class Store>
  using Of = typename Chosen<Entry, Store>::Type;
};

int main() {
  constexpr int width = 320, height = 240;
  using Sensors = pl::Rig<pl::Rgbd<pl::Pinhole<double>, width * height>>;
  using Vo = pl::Estimator<Sensors, pl::Features<pl::Points<200>>, pl::SlidingWindow<6, Blocks>>;

  Sensors sensors{};
  sensors.vision.camera = {268, 268, 159.5, 119.5, {}};
  sensors.vision.width = width;
  sensors.vision.height = height;
  Vo::Options options;
  options.points.search_px = 8;
  const auto vo = std::make_unique<Vo>(sensors, options);

  const pl::testing::RoomRun run = pl::testing::run_in_room(*vo);
  std::printf("%.2f m traveled, at most %.1f cm off\n", run.path_m, 100 * run.error_m);
  return run.is_within(0.03) ? 0 : 1;
}
