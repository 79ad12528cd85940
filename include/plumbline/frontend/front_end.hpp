#pragma once
/// Concept of a front end: it finds the landmarks of one kind in the next image. It owns its scratch data (edge maps,
/// buffers); the landmarks belong to the store.
///
/// Calls in the order of one frame; those in parentheses are optional:
///   (align)      pose by the patches of all landmarks with depth, `for_each_alignment_sample`
///   follow       finds every landmark of the previous image in the current one, near its predicted projection
///   (consensus)  correspondences for the RANSAC consensus of the pose, `for_each_correspondence`
///   refine       searches again near the projection by the estimated pose: corrects tracked landmarks, finds lost ones
///   locate       estimates the geometry of landmarks that are not located
///   detect       adds new landmarks, in a keyframe
///
/// A policy names the front end of every kind (`template <class Store> using Of`), and a backend its default policy.

#include <cstddef>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// `window` gives T_world_body(slot).
template <class F, class Store, class Window>
concept FrontEnd = requires(F& front_end, Store& store, const View<typename Store::Kind::Sensors>& view,
                            const Window& window, const SE3<typename Store::S>& T_world_body, int slot) {
  typename F::Options;
  front_end.follow(view, window, store, T_world_body);
  front_end.refine(view, window, store, T_world_body);
  front_end.locate(view, window, store, T_world_body);
  front_end.detect(view, window, store, slot);
};

/// A front end whose landmarks give correspondences for the RANSAC consensus of the pose.
template <class F>
concept GivesCorrespondences = F::gives_correspondences;

}  // namespace plumbline
