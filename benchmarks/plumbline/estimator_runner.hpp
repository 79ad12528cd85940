#pragma once
/// The Runner of one estimator type.

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "inspect.hpp"
#include "mask.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/io/make_camera.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "runner.hpp"
#include "snapshot_of.hpp"
#include "steady_clock.hpp"

/// The sensors as the calibration describes them; it must describe all that the type has.
template <class Sensors>
Sensors make_sensors(const plumbline::io::Calibration& calibration) {
  using S = typename Sensors::Scalar;
  const plumbline::io::CameraCalibration& camera = calibration.camera;
  const std::size_t pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  constexpr std::size_t max_pixels = decltype(Sensors::vision)::max_pixels;
  if (pixels > max_pixels)
    throw std::runtime_error("images of " + std::to_string(camera.width) + "x" + std::to_string(camera.height) +
                             " are larger than the " + std::to_string(max_pixels) + " pixels of this configuration");
  Sensors sensors{};
  sensors.vision.camera = plumbline::io::make_camera<S>(camera);
  sensors.vision.width = camera.width;
  sensors.vision.height = camera.height;
  if constexpr (Sensors::has_depth) sensors.vision.depth.units_per_meter = static_cast<S>(calibration.depth_scale);
  if (camera.readout_s) {
    sensors.vision.readout.set({static_cast<S>(*camera.readout_s), S(0)});
  } else if constexpr (Sensors::has_imu && !Sensors::has_depth) {
    sensors.vision.readout.set({S(0), S(0.02), true});  // observable with a gyroscope
  }
  if constexpr (Sensors::has_imu) {
    sensors.imu.T_body_cam = calibration.T_body_camera.value();
    sensors.imu.limits = calibration.imu_limits;
    sensors.imu.noise = calibration.imu.value();  // no time offset: a recording's frames have it applied
  }
  return sensors;
}

template <class Estimator, class Sensors>
class EstimatorRunner final : public Runner {
 public:
  using S = typename Estimator::S;

  /// `mask` is empty, or of the size of the images.
  EstimatorRunner(const Sensors& sensors, const cv::Mat& mask, MapChoice map)
      : estimator_(std::make_unique<Estimator>(sensors, typename Estimator::Options{}, options_of(map))) {
    if (!estimator_->set_mask(plumbline::opencv::view<std::uint8_t>(mask)))
      throw std::runtime_error("the mask has not the size of the images");
  }

  std::optional<plumbline::Error> add_imu([[maybe_unused]] const plumbline::ImuSample& sample) override {
    if constexpr (Sensors::has_imu)
      if (const auto accepted = estimator_->add_imu(sample); !accepted) return accepted.error();
    return std::nullopt;
  }

  FrameOutput add_frame(plumbline::TimeNs t_ns, const cv::Mat& gray, const cv::Mat& depth) override {
    typename Estimator::Frame frame;
    frame.t_ns = t_ns;
    frame.gray = plumbline::opencv::view<std::uint8_t>(gray);
    if constexpr (Sensors::has_depth) frame.depth = plumbline::opencv::view<std::uint16_t>(depth);
    previous_ns_ = estimator_->latest().t_ns;
    const plumbline::Result<plumbline::Estimate<S>> estimate = estimator_->add_frame(frame);
    FrameOutput out{to_double(estimator_->latest()), std::nullopt, {}, estimator_->init_report(), {}, {}, {}};
    out.S_map_world = estimator_->map().S_map_world().template cast<double>();
    if (const auto* map = estimator_->map().get()) {
      out.is_in_map = map->is_in_map();
      out.map_counts = map->counts();
    }
    out.map_timing = estimator_->map().take_timing();
    out.is_uncertain = out.estimate.health.reason == plumbline::HealthReason::scale_uncertain &&
                       out.start.stage != plumbline::InitStage::done;
    if (estimate)
      out.timing = estimator_->timing();
    else
      out.refused = estimate.error();
    return out;
  }

  double time_offset_s() const override { return estimator_->rig_state().time_offset_s(); }

  std::vector<plumbline::Vec<double, 3>> landmarks() const override {
    std::vector<plumbline::Vec<double, 3>> points;
    const auto& window = estimator_->backend().window();
    const auto& T_body_cam = estimator_->rig_state().T_body_cam();
    estimator_->landmarks().for_each([&](const auto& store) {
      using Kind = typename std::remove_cvref_t<decltype(store)>::Kind;
      for (const auto& landmark : store.landmarks()) {
        if (!landmark.located) continue;
        const plumbline::Vec<S, 3> p_world =
            window.T_world_body(landmark.anchor) * (T_body_cam * Kind::middle(landmark.geometry));
        points.push_back(p_world.template cast<double>());
      }
    });
    return points;
  }

  std::vector<MapFeature> map() const override {
    std::vector<MapFeature> features;
    const auto& window = estimator_->backend().window();
    const auto& T_body_cam = estimator_->rig_state().T_body_cam();
    int kind = 0;
    estimator_->landmarks().for_each([&](const auto& store) {
      using Store = std::remove_cvref_t<decltype(store)>;
      for (const auto& landmark : store.landmarks()) {
        if (!landmark.takes_part() || !is_sharp(landmark.geometry)) continue;
        const plumbline::SE3<S> T_world_anchor = window.T_world_body(landmark.anchor) * T_body_cam;
        const auto in_world = [&](const plumbline::Vec<S, 3>& p) {
          return plumbline::Vec<double, 3>((T_world_anchor * p).template cast<double>());
        };
        const auto [start, end] = ends_of<typename Store::Kind>(landmark.geometry);
        features.push_back({kind, landmark.id, are_lines<Store>, in_world(start), in_world(end)});
      }
      ++kind;
    });
    return features;
  }

  plumbline::MapArchiveError load_map(std::span<const std::byte> bytes) override {
    return estimator_->map().get()->load(bytes);
  }

  std::vector<std::byte> saved_map() override {
    std::vector<std::byte> bytes;
    estimator_->hand_over_keyframes();
    estimator_->map().get()->save(
        [&](std::span<const std::byte> part) { bytes.insert(bytes.end(), part.begin(), part.end()); });
    return bytes;
  }

  std::optional<MapSummary> map_summary() const override {
    const auto* map = estimator_->map().get();
    if (!map) return std::nullopt;
    MapSummary out{map->counts(), map->places().size(), {}, {}};
    for (int k = map->loaded(); k < map->places().size(); ++k) {
      const auto& keyframe = map->places().keyframe(k);
      const auto S_map_world =
          plumbline::Sim3<S>(map->places().graph().pose(k)) * plumbline::Sim3<S>(keyframe.T_world_body).inverse();
      out.corrections.push_back({keyframe.t_ns, keyframe.world, S_map_world.template cast<double>()});
    }
    const auto& graph = map->places().graph();
    for (int l = 0; l < graph.loops(); ++l) {
      const auto& loop = graph.loop(l);
      out.loops.push_back({map->places().keyframe(loop.i).t_ns, map->places().keyframe(loop.j).t_ns,
                           plumbline::Sim3<S>(loop.edge.residual.measured).template cast<double>()});
    }
    return out;
  }

  std::optional<MapSnapshot> map_snapshot(std::size_t most_points) const override {
    const auto* map = estimator_->map().get();
    if (!map) return std::nullopt;
    MapSnapshot out = snapshot_of(*map, most_points);
    if (!map->is_in_map()) return out;
    const plumbline::Sim3<double> S_map_world = map->S_map_world().template cast<double>();
    for (const MapFeature& feature : this->map()) {
      if (!feature.is_line) continue;
      const plumbline::Vec<float, 3> start = (S_map_world * feature.start).template cast<float>();
      const plumbline::Vec<float, 3> end = (S_map_world * feature.end).template cast<float>();
      out.lines.push_back({start.x(), start.y(), start.z(), end.x(), end.y(), end.z()});
    }
    return out;
  }

  FeatureCounts seen() const override {
    FeatureCounts out;
    estimator_->landmarks().for_each([&](const auto& store) {
      (are_lines<std::remove_cvref_t<decltype(store)>> ? out.lines : out.points) += store.seen_count();
    });
    return out;
  }

  std::size_t bytes() const override { return sizeof(Estimator); }

  Inspection inspect() const override { return ::inspect(*estimator_, previous_ns_); }

 private:
  static typename Estimator::MapOptions options_of(MapChoice map) {
    typename Estimator::MapOptions options{.is_used = map.is_used, .map = {}};
    options.map.localize_only = map.localize_only;
    return options;
  }

  template <class Store>
  static constexpr bool are_lines = std::is_same_v<typename Store::Kind::Place, plumbline::LineSegment>;

  /// Lines are not kept with less; points are, as they constrain the rotation.
  template <class Geometry>
  static bool is_sharp(const Geometry& geometry) {
    if constexpr (requires { geometry.sigma_inverse_range; })
      return geometry.sigma_inverse_range < geometry.inverse_range / 5;
    else
      return true;
  }

  /// In the anchor's camera [m].
  template <class Kind, class Geometry>
  static std::pair<plumbline::Vec<S, 3>, plumbline::Vec<S, 3>> ends_of(const Geometry& geometry) {
    if constexpr (requires { geometry.at(geometry.extent[0]); })
      return {geometry.at(geometry.extent[0]), geometry.at(geometry.extent[1])};
    else
      return {Kind::middle(geometry), Kind::middle(geometry)};
  }

  std::unique_ptr<Estimator> estimator_;
  plumbline::TimeNs previous_ns_ = 0;  ///< of the frame before the latest
};
