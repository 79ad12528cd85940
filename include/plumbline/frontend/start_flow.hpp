#pragma once
/// Points for the start alone: PointFlow that finds no new ones once the start is over.

#include "plumbline/frontend/point_flow.hpp"

namespace plumbline {

template <class Store>
class StartFlow {
 public:
  using Kind = typename Store::Kind;
  using S = typename Kind::Scalar;
  using Options = PointFlowOptions;
  static constexpr bool votes = true, relates_two_views = true, is_for_start = true;

  explicit StartFlow(const Options& options) : flow_(options) {}

  /// A start begins, or is over: other kinds carry the estimate.
  void begin_start() { is_over_ = false; }
  void end_start(Store& store) {
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
