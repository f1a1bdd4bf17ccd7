#include "core/alignment/matching/verified_pair.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/alignment/scene/disjoint_sets.h"
#include "core/alignment/scene/photo_set.h"

namespace skyquilt::alignment {
namespace {

using Complex = std::complex<double>;

constexpr int kMaxTrials = 250;
constexpr int kRefinements = 6;
constexpr double kMaxScale = 1.35;
constexpr double kTrustedTurnRad = 0.35;
constexpr double kReliefOfHeight = 0.2;  // height differences as a share of the flying height

struct Tolerance {
  Complex along{1.0, 0.0};  // unit vector between the cameras
  double across_m = 1.0;
  double along_m = 1.0;

  bool Holds(Complex residual) const {
    const Complex turned = residual * std::conj(along);
    return std::abs(turned.real()) <= along_m && std::abs(turned.imag()) <= across_m;
  }
};

Tolerance MakeTolerance(const VerificationOptions& options, double tolerance_m) {
  const double length = std::abs(options.baseline_m);
  return {length > 1e-9 ? options.baseline_m / length : Complex(1.0, 0.0), tolerance_m,
          tolerance_m + kReliefOfHeight * length};
}

// The places of the matches in both photos, one coordinate after the other: most of a flight's comparing is
// counting which of them a motion explains.
class MatchedPlaces {
 public:
  explicit MatchedPlaces(const std::vector<std::pair<Complex, Complex>>& places) {
    for (const auto& [a, b] : places) {
      ax_.push_back(a.real()), ay_.push_back(a.imag());
      bx_.push_back(b.real()), by_.push_back(b.imag());
    }
  }

  // How many `motion` explains; fewer than that where they are no more than `most` in any case.
  std::size_t CountInliers(const GroundSimilarity& motion, const Tolerance& tolerance,
                           std::size_t most) const {
    constexpr std::size_t kStep = 64;
    const double cos = motion.turn_and_scale.real(), sin = motion.turn_and_scale.imag();
    const double x = motion.shift.real(), y = motion.shift.imag();
    const double along_x = tolerance.along.real(), along_y = -tolerance.along.imag();
    std::size_t inliers = 0;
    for (std::size_t from = 0; from < ax_.size(); from += kStep) {
      if (inliers + (ax_.size() - from) <= most) return inliers;
      const std::size_t to = std::min(from + kStep, ax_.size());
      int held = 0;
      for (std::size_t k = from; k < to; ++k) {
        const double off_x = bx_[k] - (cos * ax_[k] - sin * ay_[k] + x);
        const double off_y = by_[k] - (cos * ay_[k] + sin * ax_[k] + y);
        const double along = off_x * along_x - off_y * along_y, across = off_x * along_y + off_y * along_x;
        held += static_cast<int>(std::abs(along) <= tolerance.along_m) &
                static_cast<int>(std::abs(across) <= tolerance.across_m);
      }
      inliers += held;
    }
    return inliers;
  }

 private:
  std::vector<double> ax_, ay_, bx_, by_;
};

// Do the inliers crowd around the motion more than matches would that had fallen anywhere in the search
// area?
bool StandsOut(const std::vector<int>& inliers, const std::vector<std::pair<Complex, Complex>>& places,
               const GroundSimilarity& motion, const Tolerance& tolerance, double search_area_m2) {
  std::vector<Complex> residuals;
  double along = 0.0, across = 0.0;
  for (const int k : inliers) {
    residuals.push_back((places[k].second - motion * places[k].first) * std::conj(tolerance.along));
    along += residuals.back().real() * residuals.back().real();
    across += residuals.back().imag() * residuals.back().imag();
  }
  const auto count = static_cast<double>(inliers.size());
  along = 2.0 * std::max(std::sqrt(along / count), 0.1 * tolerance.across_m);
  across = 2.0 * std::max(std::sqrt(across / count), 0.1 * tolerance.across_m);
  const auto inside = std::count_if(residuals.begin(), residuals.end(), [&](Complex residual) {
    return std::hypot(residual.real() / along, residual.imag() / across) < 1.0;
  });
  const double chance = std::min(1.0, std::numbers::pi * along * across / search_area_m2);
  const double by_chance = chance * static_cast<double>(places.size());
  return static_cast<double>(inside) >= by_chance + 5.0 * std::sqrt(by_chance) + 5.0;
}

}  // namespace

GroundSimilarity FitSimilarity(
    const std::vector<std::pair<std::complex<double>, std::complex<double>>>& places) {
  Complex mean_a, mean_b;
  for (const auto& [a, b] : places) {
    mean_a += a;
    mean_b += b;
  }
  mean_a /= static_cast<double>(places.size());
  mean_b /= static_cast<double>(places.size());
  Complex cross;
  double square = 0.0;
  for (const auto& [a, b] : places) {
    cross += std::conj(a - mean_a) * (b - mean_b);
    square += std::norm(a - mean_a);
  }
  const Complex turn = square > 1e-9 ? cross / square : Complex(1.0, 0.0);
  return {turn, mean_b - turn * mean_a};
}

std::optional<PhotoPair> VerifyOnGround(const GroundKeypoints& projected, int first, int second,
                                        const std::vector<KeypointMatch>& matches,
                                        const VerificationOptions& options) {
  const std::vector<GroundKeypoint>& of_first = projected[first];
  const std::vector<GroundKeypoint>& of_second = projected[second];
  const int count = static_cast<int>(matches.size());
  if (count < options.min_matches) return std::nullopt;
  std::vector<std::pair<Complex, Complex>> places;
  places.reserve(count);
  for (const KeypointMatch& match : matches) {
    places.emplace_back(of_first[match.first].place, of_second[match.second].place);
  }

  const MatchedPlaces matched(places);
  const Tolerance loose = MakeTolerance(options, options.first_tolerance_m);
  GroundSimilarity best;
  std::size_t most = 0;
  const int step = std::max(1, count / kMaxTrials);
  for (int k = 0; k < count; k += step) {
    const double keypoint_turn =
        std::remainder(of_second[matches[k].second].angle_rad - of_first[matches[k].first].angle_rad,
                       2.0 * std::numbers::pi);
    for (const double turn : {0.0, keypoint_turn}) {
      if (!options.any_turn && std::abs(turn) > kTrustedTurnRad) continue;
      const Complex rotor = std::polar(1.0, turn);
      const GroundSimilarity motion{rotor, places[k].second - rotor * places[k].first};
      const std::size_t inliers = matched.CountInliers(motion, loose, most);
      if (inliers > most) {
        most = inliers;
        best = motion;
      }
    }
  }
  if (static_cast<int>(most) < options.min_matches) return std::nullopt;

  std::vector<int> inliers;
  Tolerance tolerance = loose;
  for (int round = 0; round < kRefinements; ++round) {
    const double shrink = std::min(1.0, round / (kRefinements - 2.0));
    tolerance = MakeTolerance(options, std::pow(options.first_tolerance_m, 1.0 - shrink) *
                                           std::pow(options.last_tolerance_m, shrink));
    inliers.clear();
    std::vector<std::pair<Complex, Complex>> kept;
    for (int k = 0; k < count; ++k) {
      if (!tolerance.Holds(places[k].second - best * places[k].first)) continue;
      inliers.push_back(k);
      kept.push_back(places[k]);
    }
    if (static_cast<int>(inliers.size()) < options.min_matches) return std::nullopt;
    best = FitSimilarity(kept);
    const double scale = std::abs(best.turn_and_scale);
    if (scale > kMaxScale || scale < 1.0 / kMaxScale) return std::nullopt;
  }
  if (!StandsOut(inliers, places, best, tolerance, options.search_area_m2)) return std::nullopt;

  PhotoPair pair{first, second, best, {}, 0.0};
  double square = 0.0;
  pair.matches.reserve(inliers.size());  // no more: all pairs of a flight are kept
  for (const int k : inliers) {
    pair.matches.push_back(matches[k]);
    square += std::norm(places[k].second - best * places[k].first);
  }
  pair.rms_m = std::sqrt(square / static_cast<double>(inliers.size()));
  return pair;
}

ConnectedComponents FindConnectedComponents(std::size_t photos, const std::vector<PhotoPair>& pairs) {
  DisjointSets sets(photos);
  PhotoSet paired(photos);
  for (const PhotoPair& pair : pairs) {
    sets.Join(sets.SetOf(pair.first), sets.SetOf(pair.second));
    for (const int photo : {pair.first, pair.second}) paired.Add(photo);
  }
  ConnectedComponents components;
  components.of_photo.assign(photos, -1);
  for (std::size_t i = 0; i < photos; ++i) {
    if (!paired.Has(i)) continue;
    int& component = components.of_photo[sets.SetOf(static_cast<int>(i))];  // of the first photo of the set
    if (component < 0) {
      component = static_cast<int>(components.members.size());
      components.members.emplace_back();
    }
    components.of_photo[i] = component;
    components.members[component].push_back(static_cast<int>(i));
  }
  return components;
}

}  // namespace skyquilt::alignment
