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

#include <concepts>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// A front end whose landmarks give correspondences for the RANSAC consensus of the pose.
template <class F>
concept GivesCorrespondences = F::gives_correspondences;

/// A front end whose landmarks give pairs of bearings of two views, for the initialization of a camera without depth.
template <class F>
concept RelatesTwoViews = F::relates_two_views;

/// A front end of a kind that holds others.
template <class F>
concept ReadsKindsBefore = F::reads_kinds_before;

namespace detail {
/// What the concept is checked with.
struct SomeVisitor {
  void operator()(const auto&...) const;
};
}  // namespace detail

/// `window` gives T_world_body(slot). A front end of a kind that holds others gets their stores as a last argument of
/// each call (`reads_kinds_before`); that is not checked here.
template <class F, class Store, class Window>
concept FrontEnd = std::constructible_from<F, const typename F::Options&> &&
    requires(F& front_end, const F& known, Store& store, const View<typename Store::Kind::Sensors>& view,
             const Window& window, const SE3<typename Store::S>& T_world_body, int slot, detail::SomeVisitor visit) {
  front_end.follow(view, window, store, T_world_body);
  front_end.refine(view, window, store, T_world_body);
  front_end.locate(view, window, store, T_world_body);
  front_end.detect(view, window, store, slot);
  requires !GivesCorrespondences<F> || requires { known.for_each_correspondence(view, window, store, visit); };
  requires !RelatesTwoViews<F> || requires { known.for_each_pair(view, store, slot, visit); };
};

}  // namespace plumbline
