#include "plumbline/core/matrix.hpp"

#include "plumbline/initialization/aligned_window.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"

using namespace plumbline;

namespace {

using Pose = SE3<double>;
Pose at(double x) { return Pose({}, {x, 0, 0}); }

/// Frames along x; the state of one is its x.
struct Frames {
  static constexpr int slots = 4;
  struct Frame {
    bool used = false;
    TimeNs t_ns = 0;
    struct {
      double x = 0;
      double value() const { return x; }
    } state;
  };
  std::vector<Frame> all = std::vector<Frame>(slots);
  const Frame& operator[](int slot) const { return all[std::size_t(slot)]; }
  Pose T_world_body(int slot) const { return at((*this)[slot].state.x); }
  int oldest() const { return 1; }
  int newest() const { return 3; }
  int size() const { return int(all[1].used) + int(all[3].used); }
};

/// Writes down what it is asked for; solving moves every frame by one.
struct Window {
  struct Backend {
    Frames& frames;
    std::vector<std::string>& calls;
    std::vector<double> begins, lengths, sigmas;
    double prior = 0, offset = 0;

    void restart(auto&& state_of, double prior_on_biases, const Pose&, double time_offset) {
      calls.push_back("restart");
      for (int slot = 0; slot < Frames::slots; ++slot)
        if (frames[slot].used) frames.all[std::size_t(slot)].state.x = state_of(slot);
      begins.push_back(frames[1].state.x);
      prior = prior_on_biases;
      offset = time_offset;
    }
    void hold_distance(int a, int b, double length, double sigma) {
      calls.push_back("hold");
      CHECK((a == 1 && b == 3));
      lengths.push_back(length);
      sigmas.push_back(sigma);
    }
    void optimize(const auto&, const Pose&, auto&, const LevenbergMarquardtOptions& solver) {
      calls.push_back("optimize " + std::to_string(solver.max_iterations));
      for (auto& frame : frames.all) frame.state.x += 1;
    }
  };
  struct Store {
    double scale = 1;
    void rescale(double by) { scale *= by; }
  };
  struct Landmarks {
    Store points, lines;
    void for_each(auto&& visit) { visit(points), visit(lines); }
  };
  Frames frames_;
  std::vector<std::string> calls;
  Backend backend_{frames_, calls, {}, {}, {}};
  Landmarks landmarks_;
  Frames& frames() { return frames_; }
  Backend& backend() { return backend_; }
  Landmarks& landmarks() { return landmarks_; }
};

template <bool without_depth>
struct Aligned {
  static constexpr bool needs_second_view = without_depth;
  struct Options {
    struct {
      double position_sigma = 0.01;
    } alignment;
    double min_scale_sigma = 0.02, max_time_sigma_s = 1e-3;
  } values;
  double sigma = 0.05;
  std::vector<std::pair<TimeNs, double>> corrected;

  const Options& options() const { return values; }
  double scale() const { return 2; }
  double scale_sigma() const { return sigma; }
  double prior_on_biases() const { return 7; }
  void correct(TimeNs t_ns, const Pose& T) { corrected.emplace_back(t_ns, T.p().x()); }
};
struct Propagation {
  double time_offset(double sigma_s) const { return 3 * sigma_s; }
};
struct View {
  int rig = 0;
};

struct Scene {
  Window window;
  explicit Scene(bool has_one = false) {
    window.frames_.all[1] = {!has_one, 10, {5}};
    window.frames_.all[3] = {true, 30, {8}};
  }
  template <bool without_depth>
  void solve(const Aligned<without_depth>& aligned) {
    LevenbergMarquardtOptions solver;
    solver.max_iterations = 17;
    solve_aligned_window(aligned, solver, View{}, window, Propagation{}, Pose(), [&](int slot) { return 20.0 * slot; });
  }
};

}  // namespace

TEST_CASE("aligned_window: the initializer is given the camera poses of the frames that are there") {
  Scene scene;
  Aligned<true> aligned;
  correct_poses(aligned, scene.window.frames_, at(0.5));
  CHECK(aligned.corrected == std::vector<std::pair<TimeNs, double>>{{10, 5.5}, {30, 8.5}});
}

TEST_CASE("aligned_window: it is solved at the states of the alignment, and again linearized at the solution") {
  Scene scene;
  scene.solve(Aligned<false>{});
  CHECK(scene.window.calls == std::vector<std::string>{"restart", "optimize 17", "restart", "optimize 17"});
  CHECK(scene.window.backend_.begins == std::vector<double>{20, 21});
  CHECK(scene.window.frames_[3].state.x == 62);
  CHECK((scene.window.backend_.prior == 7 && scene.window.backend_.offset == Approx(3e-3)));
  CHECK((scene.window.landmarks_.points.scale == 2 && scene.window.landmarks_.lines.scale == 2));  // once
}

TEST_CASE("aligned_window: without depth the length of the path is held by the sigma of the scale, or the least one") {
  const double length = 40, noise = 0.01 * 2;
  for (const auto& [sigma, relative] : {std::pair{0.05, 0.05}, std::pair{0.001, 0.02}}) {
    Scene scene;
    Aligned<true> aligned;
    aligned.sigma = sigma;
    scene.solve(aligned);
    CHECK(scene.window.calls ==
          std::vector<std::string>{"restart", "hold", "optimize 17", "restart", "hold", "optimize 17"});
    CHECK(scene.window.backend_.lengths == std::vector<double>{length, length});  // that of the alignment, twice
    for (const double held : scene.window.backend_.sigmas) CHECK(held == Approx(std::hypot(relative * length, noise)));
  }
}

TEST_CASE("aligned_window: one frame alone has no length") {
  Scene scene(true);
  scene.solve(Aligned<true>{});
  CHECK(scene.window.calls == std::vector<std::string>{"restart", "optimize 17", "restart", "optimize 17"});
}
