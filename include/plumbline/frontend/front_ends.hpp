#pragma once
/// The front ends of all kinds of an estimator, in the order of the kinds; with the RANSAC consensus of the pose over
/// all correspondences.

#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/frontend/front_end.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/geometry/two_view.hpp"
#include "plumbline/state/pose_prior.hpp"

namespace plumbline {

/// Options of one kind: those of its store and those of its front end, side by side.
template <class FrontEndOptions>
struct KindOptions : StoreOptions, FrontEndOptions {};

namespace detail {

/// No image alignment, for a policy that tracks every landmark on its own: no state, no code.
struct NoImageMotion {
  struct Named {};
  static Named options_of(const auto&) { return {}; }
  explicit NoImageMotion(const Named&) {}
};
template <class Policy, class Sensors, int MaxSamples>
struct ImageMotionOf {
  using Type = NoImageMotion;
};
template <class Policy, class Sensors, int MaxSamples>
requires requires { typename Policy::template Motion<Sensors, MaxSamples>; }
struct ImageMotionOf<Policy, Sensors, MaxSamples> {
  using Type = typename Policy::template Motion<Sensors, MaxSamples>;
};

/// Largest number of patches that a front end adds to the alignment of two images.
template <class FrontEnd>
constexpr int max_alignment_samples_of() {
  if constexpr (requires { FrontEnd::max_alignment_samples; }) return FrontEnd::max_alignment_samples;
  return 0;
}

}  // namespace detail

/// Number of landmarks in the RANSAC consensus, and of its inliers.
struct InlierCount {
  int candidates = 0, inliers = 0;
};

template <class Policy, class Sensors, int Slots, class FeatureSet>
class FrontEnds;

template <class Policy, class Sensors, int Slots, class... Entries>
class FrontEnds<Policy, Sensors, Slots, Features<Entries...>> {
 public:
  using S = typename Sensors::Scalar;
  using Set = Features<Entries...>;
  using Landmarks = typename Set::template Landmarks<Sensors, Slots>;
  template <class Entry>
  using Of = typename Policy::template Of<Entry, typename Set::template StoreOf<Entry, Sensors, Slots>>;

  using ImageMotion = typename detail::ImageMotionOf<Policy, Sensors,
                                                     (0 + ... + detail::max_alignment_samples_of<Of<Entries>>())>::Type;

  /// All options by name: `options.points`, `options.lines`, ...
  struct Options : Entries::template Named<KindOptions<typename Of<Entries>::Options>>..., ImageMotion::Named {};

  /// Whether all satisfy the concept, with a window of that type.
  template <class Window>
  static constexpr bool are_front_ends =
      ((ReadsKindsBefore<Of<Entries>> ||
        FrontEnd<Of<Entries>, typename Set::template StoreOf<Entries, Sensors, Slots>, Window>)&&...);

  /// Whether a kind gives pairs of bearings of two views, for the initialization of a camera without depth.
  static constexpr bool relates_two_views = (false || ... || RelatesTwoViews<Of<Entries>>);

  explicit FrontEnds(const Options& options)
      : front_ends_(Entries::options_of(options)...), image_motion_(ImageMotion::options_of(options)) {}

  static Landmarks make_landmarks(const Options& options) { return Landmarks(Entries::options_of(options)...); }

  /// Refines a predicted pose by image alignment; no operation for a policy without
  /// `template <class Sensors, int MaxSamples> using Motion`.
  void align(const View<Sensors>& view, const auto& window, const Landmarks& landmarks, const PosePrior<S>& prior,
             SE3<S>& T_world_body) {
    if constexpr (requires { image_motion_.clear(); }) {
      image_motion_.clear();
      const SE3<S> T_world_predicted = T_world_body;
      Landmarks::for_each_index([&]<std::size_t I>() {
        const auto& front_end = std::get<I>(front_ends_);
        if constexpr (requires { front_end.max_alignment_samples; }) {
          front_end.for_each_alignment_sample(view, window, landmarks.template get<I>(), T_world_predicted,
                                              [&](const auto& sample) { image_motion_.add(sample); });
        }
      });
      image_motion_.align(view, prior, T_world_body);
    }
  }
  const ImageMotion& image_motion() const { return image_motion_; }

  /// Tracks all landmarks into the current image.
  void follow(const View<Sensors>& view, const auto& window, Landmarks& landmarks, const SE3<S>& T_world_predicted) {
    for_each(landmarks, [&](auto& front_end, auto& store, auto... before) {
      store.begin_frame();
      front_end.follow(view, window, store, T_world_predicted, before...);
    });
  }

  /// Finds the pose with most inliers among the located landmarks by RANSAC, beginning with `T_world_body`, and rejects
  /// the outliers. Only poses with passes_gate(T_world_body) are considered, unless none of them has a consensus.
  /// Without any consensus the pose stays unchanged. Returns the numbers of candidates and inliers.
  InlierCount find_consensus(const View<Sensors>& view, const auto& window, Landmarks& landmarks,
                             const PoseRansacOptions& options, SE3<S>& T_world_body, auto&& passes_gate) {
    if constexpr (max_correspondences > 0) {
      correspondences_.clear();
      candidates_.clear();
      for_each_corresponding_kind([&]<std::size_t I>(const auto& front_end) {
        const auto take = [&](int index, const PoseCorrespondence<S>& correspondence) {
          correspondences_.push_back(correspondence);
          candidates_.push_back({I, index});
        };
        front_end.for_each_correspondence(view, window, landmarks.template get<I>(), take);
      });
      const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
      const auto body_passes_gate = [&](const SE3<S>& T) { return passes_gate((view.T_body_cam * T).inverse()); };
      auto found = ransac_pose(correspondences_, T_cam_world, options, body_passes_gate);
      if (!found.valid) found = ransac_pose(correspondences_, T_cam_world, options);
      const int candidates = static_cast<int>(correspondences_.size());
      if (!found.valid) return {candidates, 0};
      T_world_body = (view.T_body_cam * found.T_cam_world).inverse();
      for_each_corresponding_kind([&]<std::size_t I>(const auto&) {
        for (std::size_t k = 0; k < correspondences_.size(); ++k) {
          if (candidates_[k].kind == I && !found.inlier[k]) landmarks.template get<I>().reject(candidates_[k].index);
        }
      });
      return {candidates, found.inliers};
    }
    return {};
  }

  InlierCount find_consensus(const View<Sensors>& view, const auto& window, Landmarks& landmarks,
                             const PoseRansacOptions& options, SE3<S>& T_world_body) {
    return find_consensus(view, window, landmarks, options, T_world_body, [](const SE3<S>&) { return true; });
  }

  /// Searches all landmarks again near their projections by the estimated pose.
  void refine(const View<Sensors>& view, const auto& window, Landmarks& landmarks, const SE3<S>& T_world_body) {
    for_each(landmarks, [&](auto& front_end, auto& store, auto... before) {
      front_end.refine(view, window, store, T_world_body, before...);
    });
  }

  /// Locates landmarks by their observations in this frame, and removes unused ones.
  void locate(const View<Sensors>& view, const auto& window, Landmarks& landmarks, const SE3<S>& T_world_body) {
    for_each(landmarks, [&](auto& front_end, auto& store, auto... before) {
      front_end.locate(view, window, store, T_world_body, before...);
      store.prune();
    });
  }

  /// Stores the observations of the frame as those of the keyframe in `slot`, and adds new landmarks.
  void detect(const View<Sensors>& view, const auto& window, Landmarks& landmarks, int slot) {
    for_each(landmarks, [&](auto& front_end, auto& store, auto... before) {
      store.record(slot);
      front_end.detect(view, window, store, slot, before...);
    });
  }

  /// visit(bearing in the anchor, bearing now) for all tracked landmarks anchored in `slot` of kinds that give such
  /// pairs.
  void for_each_pair(const View<Sensors>& view, const Landmarks& landmarks, int slot, auto&& visit) const {
    Landmarks::for_each_index([&]<std::size_t I>() {
      const auto& front_end = std::get<I>(front_ends_);
      if constexpr (requires { front_end.relates_two_views; }) {
        front_end.for_each_pair(view, landmarks.template get<I>(), slot, visit);
      }
    });
  }

  /// Initialization begins or ends: for kinds that exist during initialization only.
  void begin_initialization() {
    std::apply([](auto&... f) { (begin_initialization(f), ...); }, front_ends_);
  }
  void end_initialization(Landmarks& landmarks) {
    for_each(landmarks, [](auto& front_end, auto& store, auto...) {
      if constexpr (requires { front_end.end_initialization(store); }) front_end.end_initialization(store);
    });
  }
  /// Number of tracked landmarks of all other kinds.
  int lasting_count(const Landmarks& landmarks) const {
    int n = 0;
    Landmarks::for_each_index([&]<std::size_t I>() {
      const auto& store = landmarks.template get<I>();
      if constexpr (!requires { std::get<I>(front_ends_).is_for_initialization; } &&
                    !HasMembers<typename std::remove_cvref_t<decltype(store)>::Kind>) {
        n += store.tracked_count();
      }
    });
    return n;
  }

 private:
  /// Largest number of correspondences.
  static constexpr int max_correspondences = (0 + ... + (GivesCorrespondences<Of<Entries>> ? Entries::capacity : 0));

  /// The landmark of a correspondence.
  struct Candidate {
    std::size_t kind;
    int index;  ///< in its store
  };

  void for_each_corresponding_kind(auto&& visit) const {
    Landmarks::for_each_index([&]<std::size_t I>() {
      const auto& front_end = std::get<I>(front_ends_);
      if constexpr (GivesCorrespondences<std::remove_cvref_t<decltype(front_end)>>)
        visit.template operator()<I>(front_end);
    });
  }

  static void begin_initialization(auto& front_end) {
    if constexpr (requires { front_end.begin_initialization(); }) front_end.begin_initialization();
  }

  /// visit(front end, store), with the stores before it as a third argument for a front end with `reads_kinds_before`.
  void for_each(Landmarks& landmarks, auto&& visit) {
    Landmarks::for_each_index([&]<std::size_t I>() {
      auto& front_end = std::get<I>(front_ends_);
      if constexpr (requires { front_end.reads_kinds_before; }) {
        visit(front_end, landmarks.template get<I>(), landmarks.template before<I>());
      } else {
        visit(front_end, landmarks.template get<I>());
      }
    });
  }

  std::tuple<Of<Entries>...> front_ends_;
  [[no_unique_address]] ImageMotion image_motion_;
  FixedVector<PoseCorrespondence<S>, (max_correspondences > 0 ? max_correspondences : 1)> correspondences_;
  FixedVector<Candidate, (max_correspondences > 0 ? max_correspondences : 1)> candidates_;
};

}  // namespace plumbline
