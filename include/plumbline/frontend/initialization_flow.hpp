#pragma once
/// Front end of points during initialization only: PointFlow that detects no new points after it.

#include "plumbline/frontend/point_flow.hpp"

namespace plumbline {

template <class Store>
class InitializationFlow {
 public:
  using Kind = typename Store::Kind;
  using S = typename Kind::Scalar;
  using Options = PointFlowOptions;
  static constexpr bool gives_correspondences = true, relates_two_views = true, is_for_initialization = true;

  explicit InitializationFlow(const Options& options) : flow_(options) {}

  /// Initialization begins, or ends: the points are removed.
  void begin_initialization() { is_over_ = false; }
  void end_initialization(Store& store) {
    store.clear();
    is_over_ = true;
  }

  void follow(const auto& view, const auto& window, Store& store, const SE3<S>& T_world_predicted) {
    flow_.follow(view, window, store, T_world_predicted);
  }
  void for_each_correspondence(const auto& view, const auto& window, const Store& store, auto&& take) const {
    flow_.for_each_correspondence(view, window, store, take);
  }
  void refine(const auto& view, const auto& window, Store& store, const SE3<S>& T_world_body) {
    flow_.refine(view, window, store, T_world_body);
  }
  void locate(const auto& view, const auto& window, Store& store, const SE3<S>& T_world_body) {
    flow_.locate(view, window, store, T_world_body);
  }
  void detect(const auto& view, const auto& window, Store& store, int slot) {
    if (!is_over_) flow_.detect(view, window, store, slot);
  }
  void for_each_pair(const auto& view, const Store& store, int slot, auto&& visit) const {
    flow_.for_each_pair(view, store, slot, visit);
  }

 private:
  PointFlow<Store> flow_;
  bool is_over_ = false;
};

}  // namespace plumbline
