#pragma once
/// The front ends of all kinds of an estimator, in the order of the kinds, and the pose that most of what they follow
/// agrees on.

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

/// Of a policy that follows every landmark by itself: no state, no code.
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

/// What the landmarks of a front end may add to the alignment of two images.
template <class FrontEnd>
constexpr int max_alignment_samples_of() {
  if constexpr (requires { FrontEnd::max_alignment_samples; }) return FrontEnd::max_alignment_samples;
  return 0;
}

}  // namespace detail

/// How many landmarks had a say in the pose, and how many agree on it.
struct Agreement {
  int asked = 0, agree = 0;
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

  /// Whether a kind tells which bearings of two views belong together: a camera without depth starts by them.
  static constexpr bool relates_two_views = (false || ... || requires { Of<Entries>::relates_two_views; });

  explicit FrontEnds(const Options& options)
      : front_ends_(Entries::options_of(options)...), image_motion_(ImageMotion::options_of(options)) {}

  static Landmarks make_landmarks(const Options& options) { return Landmarks(Entries::options_of(options)...); }

  /// Moves T, where the frame is expected, to where the images have it, of a policy that compares them as a whole
  /// (`template <class Sensors, int MaxSamples> using Motion`).
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

  /// Follows all landmarks into the current image.
  void follow(const View<Sensors>& view, const auto& window, Landmarks& landmarks, const SE3<S>& T_world_predicted) {
    for_each(landmarks, [&](auto& front_end, auto& store, auto... before) {
      store.begin_frame();
      front_end.follow(view, window, store, T_world_predicted, before...);
    });
  }

  /// Finds the pose that most located landmarks agree on, beginning with `T_world_body`, and takes the others out of
  /// the frame. Of a majority that moves otherwise than can be, no pose is taken where others agree on one that can:
  /// admits(T_world_body) tells. Leaves the pose alone when none is found. Returns who was asked, and how many agree.
  Agreement agree(const View<Sensors>& view, const auto& window, Landmarks& landmarks, const PoseRansacOptions& options,
                  SE3<S>& T_world_body, auto&& admits) {
    if constexpr (votes > 0) {
      votes_.clear();
      voters_.clear();
      for_each_voting_kind([&]<std::size_t I>(const auto& front_end) {
        const auto take = [&](int index, const PoseCorrespondence<S>& vote) {
          votes_.push_back(vote);
          voters_.push_back({I, index});
        };
        front_end.for_each_correspondence(view, window, landmarks.template get<I>(), take);
      });
      const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
      const auto body_admits = [&](const SE3<S>& T) { return admits((view.T_body_cam * T).inverse()); };
      auto found = ransac_pose(votes_, T_cam_world, options, body_admits);
      if (!found.valid) found = ransac_pose(votes_, T_cam_world, options);
      const int asked = static_cast<int>(votes_.size());
      if (!found.valid) return {asked, 0};
      T_world_body = (view.T_body_cam * found.T_cam_world).inverse();
      for_each_voting_kind([&]<std::size_t I>(const auto&) {
        for (std::size_t k = 0; k < votes_.size(); ++k) {
          if (voters_[k].kind == I && !found.inlier[k]) landmarks.template get<I>().reject(voters_[k].index);
        }
      });
      return {asked, found.inliers};
    }
    return {};
  }

  Agreement agree(const View<Sensors>& view, const auto& window, Landmarks& landmarks, const PoseRansacOptions& options,
                  SE3<S>& T_world_body) {
    return agree(view, window, landmarks, options, T_world_body, [](const SE3<S>&) { return true; });
  }

  /// Looks again for all landmarks where the pose sees them.
  void refine(const View<Sensors>& view, const auto& window, Landmarks& landmarks, const SE3<S>& T_world_body) {
    for_each(landmarks, [&](auto& front_end, auto& store, auto... before) {
      front_end.refine(view, window, store, T_world_body, before...);
    });
  }

  /// Landmarks without a place in space, by this frame's view of them; those of no use any more are forgotten.
  void locate(const View<Sensors>& view, const auto& window, Landmarks& landmarks, const SE3<S>& T_world_body) {
    for_each(landmarks, [&](auto& front_end, auto& store, auto... before) {
      front_end.locate(view, window, store, T_world_body, before...);
      store.prune();
    });
  }

  /// Records what the frame saw as the keyframe in `slot`, and finds new landmarks.
  void detect(const View<Sensors>& view, const auto& window, Landmarks& landmarks, int slot) {
    for_each(landmarks, [&](auto& front_end, auto& store, auto... before) {
      store.record(slot);
      front_end.detect(view, window, store, slot, before...);
    });
  }

  /// Gives visit(bearing in the anchor, bearing now) of all landmarks anchored in `slot` that relate two views.
  void for_each_pair(const View<Sensors>& view, const Landmarks& landmarks, int slot, auto&& visit) const {
    Landmarks::for_each_index([&]<std::size_t I>() {
      const auto& front_end = std::get<I>(front_ends_);
      if constexpr (requires { front_end.relates_two_views; }) {
        front_end.for_each_pair(view, landmarks.template get<I>(), slot, visit);
      }
    });
  }

  /// A start begins, or is over: for kinds that are there for it alone.
  void begin_start() {
    std::apply([](auto&... f) { (begin_start(f), ...); }, front_ends_);
  }
  void end_start(Landmarks& landmarks) {
    for_each(landmarks, [](auto& front_end, auto& store, auto...) {
      if constexpr (requires { front_end.end_start(store); }) front_end.end_start(store);
    });
  }
  /// Tracked landmarks of all other kinds.
  int lasting_count(const Landmarks& landmarks) const {
    int n = 0;
    Landmarks::for_each_index([&]<std::size_t I>() {
      const auto& store = landmarks.template get<I>();
      if constexpr (!requires { std::get<I>(front_ends_).is_for_start; } &&
                    !HoldsOthers<typename std::remove_cvref_t<decltype(store)>::Kind>) {
        n += store.tracked_count();
      }
    });
    return n;
  }

 private:
  /// How many landmarks may vote.
  static constexpr int votes = (0 + ... + (Votes<Of<Entries>> ? Entries::capacity : 0));

  struct Voter {
    std::size_t kind;
    int index;  ///< in its store
  };

  void for_each_voting_kind(auto&& visit) const {
    Landmarks::for_each_index([&]<std::size_t I>() {
      const auto& front_end = std::get<I>(front_ends_);
      if constexpr (Votes<std::remove_cvref_t<decltype(front_end)>>) visit.template operator()<I>(front_end);
    });
  }

  static void begin_start(auto& front_end) {
    if constexpr (requires { front_end.begin_start(); }) front_end.begin_start();
  }

  /// visit(front end, store), and as a third argument the stores before it for a front end that says it reads them.
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
  FixedVector<PoseCorrespondence<S>, (votes > 0 ? votes : 1)> votes_;
  FixedVector<Voter, (votes > 0 ? votes : 1)> voters_;
};

}  // namespace plumbline
