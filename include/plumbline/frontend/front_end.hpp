#pragma once
/// A front end finds the landmarks of one kind in the next image. It owns what that takes (edge maps, scratch); the
/// landmarks belong to the store.
///
/// In the order of one frame:
///   (align)   the pose, from pixels that all landmarks together know the depth of, `for_each_alignment_sample`
///   follow    every landmark of the previous image into the current one, from where the predicted pose sees it
///   (vote)    what its landmarks have to say in the search for the pose that most agree on, `for_each_correspondence`
///   refine    looks again where the estimated pose sees a landmark: tracked ones are corrected, lost ones found
///   locate    landmarks without a place in space, by this frame's view of them
///   detect    new landmarks, in a keyframe
///
/// A policy names the front end of every kind (`template <class Store> using Of`), and a backend its default policy.

#include <cstddef>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// `window` tells T_world_body(slot).
template <class F, class Store, class Window>
concept FrontEnd = requires(F& front_end, Store& store, const View<typename Store::Kind::Sensors>& view,
                            const Window& window, const SE3<typename Store::S>& T_world_body, int slot) {
  typename F::Options;
  front_end.follow(view, window, store, T_world_body);
  front_end.refine(view, window, store, T_world_body);
  front_end.locate(view, window, store, T_world_body);
  front_end.detect(view, window, store, slot);
};

/// Whether the landmarks of this front end vote for the pose.
template <class F>
concept Votes = F::votes;

}  // namespace plumbline
