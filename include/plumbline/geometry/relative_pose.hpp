#pragma once
/// Relative pose of two calibrated views with nothing known beforehand: by a homography or an essential matrix,
/// whichever fits the pairs better, with the reason where it is rejected.                   docs/math/geometry.md 8
///
///   the simpler of two models holds if  S_simpler / (S_simpler + S_other) > 0.40,  S of (27)                  (30)
///   rotation against the better of the others, homography against essential matrix
///   ambiguous if another motion has more than 0.85 of the support (28) of the best                            (31)
/// MSAC over four and over five pairs; every sample that is the best so far is refined by (24) or (16). Where (29)
/// finds more noise than stated, the models are refined and scored again with it: with too small a noise every
/// rotation looks like a motion. The motions (25) of a plane are compared as they are: (16) does not see the errors
/// along the epipolar lines, and these hold them. The same input gives the same output, and the number of samples is
/// bounded.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/core/random_sample.hpp"
#include "plumbline/geometry/epipolar.hpp"
#include "plumbline/geometry/essential_matrix.hpp"
#include "plumbline/geometry/five_point.hpp"
#include "plumbline/geometry/homography.hpp"
#include "plumbline/geometry/pure_rotation.hpp"
#include "plumbline/geometry/two_view.hpp"
#include "plumbline/geometry/two_view_scores.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

enum class TwoViewModel : std::uint8_t { none, rotation, homography, essential };
enum class TwoViewFailure : std::uint8_t { none, few_pairs, no_consensus, rotation_only, little_parallax, ambiguous };

struct RelativePoseOptions {
  double sigma_rad = 2e-3;  ///< of either bearing; rather too large than too small
  double gate = 3;          ///< inliers are within this many sigma
  int homography_samples = 80;
  int essential_samples = 200;
  int iterations = 6;               ///< of the last (16) and (24)
  double confidence = 0.999;        ///< of having drawn one sample without wrong pairs
  double simpler_ratio = 0.40;      ///< (30)
  double max_rival = 0.85;          ///< (31)
  double min_parallax_rad = 0.017;  ///< median, after rotation
  int min_inliers = 30;
  std::uint64_t seed = 1;
};

/// The best motion of both models, for any number of pairs.
template <class S>
class RelativePoseSearch {
 public:
  using Pairs = std::span<const BearingPair<S>>;

  RelativePoseSearch(Pairs pairs, const RelativePoseOptions& options)
      : pairs_(pairs), options_(options), sigma_(S(options.sigma_rad)), score_(pairs, sigma_), random_(options.seed) {}

  /// At least five pairs.
  TwoViewFailure run(const SO3<S>& R_guess) {
    search_homography();
    HomographyMotions<S> of_plane = motions_of_homography(H_);
    search_motion(R_guess, of_plane);
    noise = score_.noise(essential_matrix(best.T_2_1), 3 * sigma_);
    if (noise > S(1.2) * sigma_) {
      widen(noise);
      of_plane = motions_of_homography(H_);
    }
    search_rotation(R_guess, of_plane.R_nearest);
    scores[2] = score_.essential(essential_matrix(best.T_2_1));
    if (best.pairs < options_.min_inliers) return TwoViewFailure::no_consensus;
    if (simpler(scores[0], std::max(scores[1], scores[2]))) {  // (30)
      model = TwoViewModel::rotation;
      best.T_2_1 = SE3<S>(R_, best.T_2_1.p());
      return TwoViewFailure::rotation_only;
    }
    model = simpler(scores[1], scores[2]) ? TwoViewModel::homography : TwoViewModel::essential;
    model == TwoViewModel::homography ? compare_motions_of_plane(of_plane) : compare_motions(of_plane);
    return rival.support > S(options_.max_rival) * best.support ? TwoViewFailure::ambiguous
                                                                : TwoViewFailure::none;  // (31)
  }

  TwoViewModel model = TwoViewModel::none;
  std::array<S, 3> scores{};  ///< (27) of rotation, homography, essential matrix
  S noise = S(0);             ///< (29)
  SupportedMotion<S> best, rival;

 private:
  bool simpler(S simple, S other) const { return simple > S(options_.simpler_ratio) * (simple + other); }

  template <std::size_t K>
  std::array<BearingPair<S>, K> sample() {
    std::array<BearingPair<S>, K> out;
    const std::array<std::uint32_t, K> index = random_sample<K>(random_, std::uint32_t(pairs_.size()));
    for (std::size_t k = 0; k < K; ++k) out[k] = pairs_[index[k]];
    return out;
  }
  bool enough(int samples, int size, double right) const {
    return samples >= samples_needed(options_.confidence, right / double(pairs_.size()), size);
  }

  void search_homography() {
    set_zero(H_);
    S best_sample = 0;
    // A pair that a homography meets counts as one when it brings the most it can, for about two thirds in the mean.
    for (int k = 0; k < options_.homography_samples; ++k) {
      if (enough(k, 4, double(scores[1] / (2 * TwoViewScores<S>::most)))) break;
      Mat<S, 3, 3> H;
      if (!homography_of_four(sample<4>(), H)) continue;
      const S score = score_.homography(H, best_sample);
      if (!(score > best_sample)) continue;
      best_sample = score;
      adopt(H, score);
      adopt_refined(H, S(4), 2);
    }
    adopt_refined(H_, S(2), options_.iterations);
  }
  void adopt_refined(Mat<S, 3, 3> H, S widening, int iterations) {
    for (const S widened : {widening, S(2)}) {
      if (!refine_homography(pairs_, widened * sigma_, iterations, H)) return;
    }
    adopt(H, score_.homography(H, scores[1]));
  }
  void adopt(const Mat<S, 3, 3>& H, S score) {
    if (!(score > scores[1])) return;
    scores[1] = score;
    H_ = H;
  }

  /// The same models for more noise than was said.
  void widen(S sigma) {
    sigma_ = sigma;
    score_ = TwoViewScores<S>(pairs_, sigma);
    scores[1] = score_.homography(H_);
    adopt_refined(H_, S(2), options_.iterations);
    best = score_.supported(best.T_2_1);
    adopt(refined(best.T_2_1, S(2), options_.iterations));
  }

  void search_rotation(const SO3<S>& R_guess, const SO3<S>& R_of_plane) {
    for (SO3<S> R : {R_guess, R_of_plane}) {
      for (const S widening : {S(16), S(4), S(2)}) {
        if (!refine_rotation(pairs_, widening * sigma_, options_.iterations, R)) break;
      }
      const S score = score_.homography(R.matrix());
      if (!(score >= scores[0])) continue;
      scores[0] = score;
      R_ = R;
    }
  }

  void search_motion(const SO3<S>& R_guess, const HomographyMotions<S>& of_plane) {
    S best_sample = 0;
    const auto offer = [&](const auto& motions) {
      SupportedMotion<S> sampled;
      for (const SE3<S>& T_2_1 : motions) {
        const SupportedMotion<S> motion = score_.supported(T_2_1);
        if (motion.support > sampled.support) sampled = motion;
      }
      if (!(sampled.support > best_sample)) return;
      best_sample = sampled.support;
      adopt(sampled);
      adopt(refined(sampled.T_2_1, S(8), 3));
    };
    Vec<S, 3> t;
    if (consensus_translation(pairs_, R_guess, 10 * sigma_, 20, random_.next(), t)) {
      offer(std::array<SE3<S>, 2>{SE3<S>(R_guess, t), SE3<S>(R_guess, -t)});
    }
    offer(of_plane.T_2_1);
    for (int k = 0; k < options_.essential_samples && !enough(k, 5, best.pairs); ++k) {
      for (const Mat<S, 3, 3>& E : five_point(sample<5>())) {
        if (score_.essential(E, best_sample) > best_sample) offer(motions_of_essential(E));
      }
    }
    adopt(refined(best.T_2_1, S(2), options_.iterations));
  }
  SupportedMotion<S> refined(const SE3<S>& T_2_1, S widening, int iterations) const {
    SO3<S> R = T_2_1.rotation();
    Vec<S, 3> t = T_2_1.p();
    for (const S widened : {widening, S(2)}) {
      if (!refine_epipolar(pairs_, widened * sigma_, iterations, R, t)) return {};
    }
    return score_.supported(SE3<S>(R, t));
  }
  void adopt(const SupportedMotion<S>& motion) {
    if (motion.support > best.support) best = motion;
  }

  /// Rounding, noise and refinement leave the same motion in different words.
  static bool differ(const SE3<S>& A, const SE3<S>& B) {
    return norm((A.rotation().inverse() * B.rotation()).log()) > S(0.05) || norm(A.p() - B.p()) > S(0.2);
  }
  void compare_motions_of_plane(const HomographyMotions<S>& of_plane) {
    best = {};
    for (const SE3<S>& T_2_1 : of_plane.T_2_1) adopt(score_.supported(T_2_1));
    for (const SE3<S>& T_2_1 : of_plane.T_2_1) compare(score_.supported(T_2_1));
  }
  void compare_motions(const HomographyMotions<S>& of_plane) {
    const auto compare_refined = [&](const SE3<S>& T_2_1) {
      if (score_.supported(T_2_1).support > best.support / 2) compare(refined(T_2_1, S(4), options_.iterations));
    };
    for (const SE3<S>& T_2_1 : motions_of_essential(essential_matrix(best.T_2_1))) compare_refined(T_2_1);
    for (const SE3<S>& T_2_1 : of_plane.T_2_1) compare_refined(T_2_1);
  }
  void compare(const SupportedMotion<S>& motion) {
    if (motion.support > rival.support && differ(motion.T_2_1, best.T_2_1)) rival = motion;
  }

  Pairs pairs_;
  RelativePoseOptions options_;
  S sigma_;
  TwoViewScores<S> score_;
  Random random_;
  Mat<S, 3, 3> H_;
  SO3<S> R_;
};

template <class S, std::size_t Capacity>
struct RelativePose {
  bool valid = false;  ///< found, and no reason to reject it
  TwoViewFailure failure = TwoViewFailure::few_pairs;
  TwoViewModel model = TwoViewModel::none;
  TwoView<S, Capacity> two_view;  ///< the best that was found, rejected or not; of a rotation p means nothing
  SupportedMotion<S> rival;       ///< the next best that is another motion: the one of the two if `ambiguous`
  S rival_part = S(0);            ///< its support by that of the best
  S noise_rad = S(0);             ///< (29)
  std::array<S, 3> scores{};      ///< (27) of rotation, homography, essential matrix
};

template <class S, std::size_t Capacity>
class RelativePoseSolver {
 public:
  using Outcome = RelativePose<S, Capacity>;

  /// The guess is one hypothesis more, and may be the identity.
  Outcome solve(std::span<const BearingPair<S>> pairs, const SO3<S>& R_guess,
                const RelativePoseOptions& options = {}) const {
    PLUMBLINE_ASSERT(pairs.size() <= Capacity);
    Outcome out;
    if (pairs.size() < 8 || pairs.size() < std::size_t(options.min_inliers)) return out;
    RelativePoseSearch<S> search(pairs, options);
    out.failure = search.run(R_guess);
    out.model = search.model;
    out.rival = search.rival;
    out.rival_part = search.best.support > S(0) ? search.rival.support / search.best.support : S(0);
    out.noise_rad = search.noise;
    out.scores = search.scores;
    const SE3<S>& T_2_1 = search.best.T_2_1;
    out.two_view.describe(pairs, T_2_1.rotation(), T_2_1.p(), S(options.gate * options.sigma_rad));
    if (out.failure == TwoViewFailure::none && !(out.two_view.parallax > S(options.min_parallax_rad))) {
      out.failure = TwoViewFailure::little_parallax;
    }
    out.valid = out.failure == TwoViewFailure::none && out.two_view.valid;
    return out;
  }
};

}  // namespace plumbline
