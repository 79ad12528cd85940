#pragma once
/// The tracking state of an estimator, the events that change it, and the table of its transitions.
///                                                                              docs/concepts/tracking_state.md
///
///   next_state(state, event)   the whole state machine: nothing else decides which state follows
///
/// What an estimator does in a state, and which events a frame gives rise to, is in estimator.hpp, outage.hpp and
/// initialization/. What is reported to the user (Health) is a function of the state, see publisher.hpp.

#include <array>
#include <cstddef>
#include <cstdint>

namespace plumbline {

enum class TrackingState : std::uint8_t {
  uninitialized,  ///< there is no first view: no image so far, or none that showed enough
  initializing,   ///< there is a first view; a camera without depth waits for a second one with parallax
  visual_only,    ///< rigs with an IMU: poses of vision alone are gathered until vision and IMU are aligned
  nominal,        ///< every frame is tracked and solved for
  outage,         ///< images give no pose: IMU-only propagation, or waiting for a sight that is known
  lost,           ///< the outage was too long, or the initialization wrong: the next image begins a new initialization
};

enum class TrackingEvent : std::uint8_t {
  first_view,               ///< an image shows enough to initialize with
  landmarks_located,        ///< rigs with an IMU: landmarks are located, their poses await the alignment
  initialized,              ///< all that the rig can observe is estimated
  pose_found,               ///< the frame's features give its pose
  no_pose,                  ///< they do not
  image_unusable,           ///< the image shows too little, or repeats the one before
  imu_vision_inconsistent,  ///< the IMU excludes the pose of the frame's features
  outage_too_long,          ///< neither the IMU nor the local map can bridge the outage any longer
  initialization_rejected,  ///< the alignment, or the scale after it, turned out to be wrong
  relocalized,              ///< the map gave a pose
  reset_requested,          ///< by the user
};

inline constexpr std::size_t tracking_states = 6, tracking_events = 11;

namespace detail {
/// Rows: state. Columns: event, in the order of TrackingEvent.
inline constexpr auto transitions = [] {
  using enum TrackingState;
  using Row = std::array<TrackingState, tracking_events>;
  return std::array<Row, tracking_states>{{
      // first_view, landmarks_located, initialized, pose_found, no_pose, image_unusable,
      // imu_vision_inconsistent, outage_too_long, initialization_rejected, relocalized, reset_requested
      /* uninitialized */
      {initializing, uninitialized, uninitialized, uninitialized, uninitialized, uninitialized,  //
       uninitialized, uninitialized, uninitialized, nominal, uninitialized},
      /* initializing */
      {initializing, visual_only, nominal, initializing, initializing, uninitialized,  //
       initializing, uninitialized, uninitialized, nominal, uninitialized},
      /* visual_only */
      {initializing, visual_only, nominal, visual_only, uninitialized, visual_only,  //
       uninitialized, uninitialized, uninitialized, nominal, uninitialized},
      /* nominal */
      {nominal, nominal, nominal, nominal, outage, outage,  //
       outage, lost, lost, nominal, lost},
      /* outage */
      {outage, outage, outage, nominal, outage, outage,  //
       outage, lost, lost, nominal, lost},
      /* lost */
      {initializing, lost, lost, lost, lost, lost,  //
       lost, lost, lost, nominal, lost},
  }};
}();
}  // namespace detail

constexpr TrackingState next_state(TrackingState state, TrackingEvent event) {
  return detail::transitions[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

/// The tracking state, and how often it was lost.
class TrackingStatus {
 public:
  TrackingState state() const { return state_; }
  std::uint32_t resets() const { return resets_; }

  void handle(TrackingEvent event) {
    const TrackingState next = next_state(state_, event);
    if (next == TrackingState::lost && state_ != TrackingState::lost) ++resets_;
    state_ = next;
  }
  /// An initialization that began from a known pose has lost it.
  void count_reset() { ++resets_; }

  /// Whether there is a first view, of which the features are tracked.
  bool has_first_view() const { return state_ != TrackingState::uninitialized && state_ != TrackingState::lost; }
  /// Whether features are tracked against located landmarks.
  bool has_landmarks() const { return has_first_view() && state_ != TrackingState::initializing; }

 private:
  TrackingState state_ = TrackingState::uninitialized;
  std::uint32_t resets_ = 0;
};

constexpr const char* name_of(TrackingState state) {
  switch (state) {
    case TrackingState::uninitialized: return "uninitialized";
    case TrackingState::initializing: return "initializing";
    case TrackingState::visual_only: return "visual only";
    case TrackingState::nominal: return "nominal";
    case TrackingState::outage: return "outage";
    case TrackingState::lost: return "lost";
  }
  return "unknown";
}

constexpr const char* name_of(TrackingEvent event) {
  switch (event) {
    case TrackingEvent::first_view: return "first view";
    case TrackingEvent::landmarks_located: return "landmarks located";
    case TrackingEvent::initialized: return "initialized";
    case TrackingEvent::pose_found: return "pose found";
    case TrackingEvent::no_pose: return "no pose";
    case TrackingEvent::image_unusable: return "image unusable";
    case TrackingEvent::imu_vision_inconsistent: return "IMU and vision inconsistent";
    case TrackingEvent::outage_too_long: return "outage too long";
    case TrackingEvent::initialization_rejected: return "initialization rejected";
    case TrackingEvent::relocalized: return "relocalized";
    case TrackingEvent::reset_requested: return "reset requested";
  }
  return "unknown";
}

}  // namespace plumbline
