#include "core/render/exposure/hot_spot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "core/base/median.h"
#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::render {
namespace {

constexpr double kCell = 0.02;  // of directions, as a tangent
// The smooth light of the flight follows wider ones.
constexpr std::array kReaches{kSpotReaches[1], kSpotReaches[2]};
// A spot is brighter by at least so much, and by so many times what is found elsewhere by chance.
constexpr double kMinSpotLog = 0.02, kTimesUsual = 7.0;
// Of the direction most often seen: at the edge of what photos see a hot spot is a guess.
constexpr double kMinWeightShare = 0.4;

struct Cell {
  double weight = 0.0, misfit = 0.0;  // sums
};

// By how much it is brighter around a direction, and how many samples say so.
struct Match {
  double log = 0.0, weight = 0.0;
};

std::vector<Match> MatchesOf(const std::vector<Cell>& cells, int side, double reach) {
  const int cells_away = static_cast<int>(reach / kCell);
  std::vector<Match> matches(cells.size());
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      Match& match = matches[static_cast<std::size_t>(row) * side + static_cast<std::size_t>(column)];
      double along = 0.0;
      for (int y = std::max(0, row - cells_away); y <= std::min(side - 1, row + cells_away); ++y) {
        for (int x = std::max(0, column - cells_away); x <= std::min(side - 1, column + cells_away); ++x) {
          const Cell& cell = cells[static_cast<std::size_t>(y) * side + static_cast<std::size_t>(x)];
          const int dx = x - column, dy = y - row;
          const double shape = SpotHill(kCell * kCell * (dx * dx + dy * dy), reach);
          along += shape * cell.misfit;
          match.weight += shape * shape * cell.weight;
        }
      }
      if (match.weight > 0.0) match.log = along / match.weight;
    }
  }
  return matches;
}

}  // namespace

std::optional<Eigen::Vector2d> FindHotSpot(const std::vector<ExposureSample>& samples,
                                           const std::vector<double>& misfits, double widest_look) {
  const int half = static_cast<int>(widest_look / kCell), side = 2 * half + 1;
  std::vector<Cell> cells(static_cast<std::size_t>(side) * side);
  double squares = 0.0, weights = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double weight = SampleWeight(misfits[i]);
    squares += weight * misfits[i] * misfits[i];
    weights += weight;
    const double column = std::round(static_cast<double>(samples[i].look[0]) / kCell) + half;
    const double row = std::round(static_cast<double>(samples[i].look[1]) / kCell) + half;
    if (!(column >= 0.0 && column < side && row >= 0.0 && row < side)) continue;
    Cell& cell = cells[static_cast<std::size_t>(row) * side + static_cast<std::size_t>(column)];
    cell.weight += weight;
    cell.misfit += weight * misfits[i];
  }
  const double sigma = std::sqrt(squares / std::max(weights, 1e-9));
  if (!(sigma > 0.0)) return {};

  std::optional<Eigen::Vector2d> best;
  double most = 0.0;
  for (const double reach : kReaches) {
    const std::vector<Match> matches = MatchesOf(cells, side, reach);
    double most_weight = 0.0;
    for (const Match& match : matches) most_weight = std::max(most_weight, match.weight);
    const double least_weight = kMinWeightShare * most_weight;
    std::vector<double> logs;
    for (const Match& match : matches) {
      if (match.weight > least_weight) logs.push_back(std::abs(match.log));
    }
    if (logs.empty()) continue;
    // What stands out by chance: neighbouring samples err together.
    const double usual = std::max(Median(std::move(logs)), 1e-6);
    for (std::size_t at = 0; at < matches.size(); ++at) {
      const Match& match = matches[at];
      const double sigmas = match.log * std::sqrt(match.weight) / sigma;
      if (match.weight <= least_weight || match.log < kMinSpotLog || match.log < kTimesUsual * usual ||
          sigmas <= most)
        continue;
      most = sigmas;
      const int row = static_cast<int>(at) / side, column = static_cast<int>(at) % side;
      best = kCell * Eigen::Vector2d(column - half, row - half);
    }
  }
  return best;
}

namespace {

constexpr auto kHills = static_cast<Eigen::Index>(kSpotTerms);
using Hills = Eigen::Matrix<double, kHills, 1>;
using HillsByHills = Eigen::Matrix<double, kHills, kHills>;

// Grounds differ in their hot spots if the halves of their spots agree about it by so many sigmas.
constexpr double kSigmasOfDifference = 2.0;
constexpr double kMaxShare = 2.0;

// What a sample says of the hot spot alone, less the mean over its spot of ground.
struct HillSample {
  Hills hills = Hills::Zero();  // how much of each hill nothing else explains
  double left = 0.0;            // what the light leaves
  double weight = 0.0;
};

std::vector<HillSample> HillSamplesOf(const std::vector<ExposureSample>& samples, std::size_t channel,
                                      const LightTerms& terms, const SolvedLight& light) {
  std::array<Eigen::VectorXd, kSpotTerms> gains, of_terms;
  for (Eigen::Index hill = 0; hill < kHills; ++hill) {
    gains[static_cast<std::size_t>(hill)] = light.gains_by_hill.col(hill);
    of_terms[static_cast<std::size_t>(hill)] = light.terms_by_hill.col(hill);
  }
  const std::vector<double> misfits = MisfitsOf(samples, channel, terms, light);
  std::vector<HillSample> of_hills(samples.size());
  for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
    end = EndOfSpot(samples, begin);
    HillSample mean;
    for (std::size_t i = begin; i < end; ++i) {
      HillSample& own = of_hills[i];
      own.left = misfits[i];
      own.weight = SampleWeight(misfits[i]);
      for (std::size_t hill = 0; hill < kSpotTerms; ++hill)
        own.hills[static_cast<Eigen::Index>(hill)] =
            Explained(samples[i], terms, gains[hill], of_terms[hill]);
      mean.hills += own.weight * own.hills;
      mean.left += own.weight * own.left;
      mean.weight += own.weight;
    }
    for (std::size_t i = begin; i < end; ++i) {
      of_hills[i].hills -= mean.hills / mean.weight;
      of_hills[i].left -= mean.left / mean.weight;
    }
  }
  return of_hills;
}

// Normal equations of the hills' heights.
struct HillEquations {
  HillsByHills normal = HillsByHills::Zero();
  Hills right = Hills::Zero();
};

// The heights of the widest hills, one or more: as many as foretell photos that are left out best. Shrunk by
// the sigma of their sum, by what photos differ: samples of one photo err together.
Hills SettledHeights(const std::vector<HillEquations>& photos) {
  HillEquations all;
  for (const HillEquations& photo : photos) {
    all.normal += photo.normal;
    all.right += photo.right;
  }
  all.normal.diagonal().array() += 1e-9 + 1e-6 * all.normal.trace();
  Hills settled = Hills::Zero();
  double most = 0.0;
  for (Eigen::Index count = 1; count <= kHills; ++count) {
    const Eigen::MatrixXd normal = all.normal.topLeftCorner(count, count);
    const Eigen::VectorXd right = all.right.head(count);
    const Eigen::VectorXd heights = geo::SolveSymmetric(normal, right);
    const Eigen::VectorXd of_sum = geo::SolveSymmetric(normal, Eigen::VectorXd::Ones(count));
    double lowered = 0.0, variance = 0.0;  // squared misfits of photos by the others' heights; of the sum
    for (const HillEquations& photo : photos) {
      const Eigen::MatrixXd own_normal = photo.normal.topLeftCorner(count, count);
      const Eigen::VectorXd own_right = photo.right.head(count);
      const Eigen::VectorXd by_others = geo::SolveSymmetric(normal - own_normal, right - own_right);
      lowered += by_others.dot(2.0 * own_right - own_normal * by_others);
      const double off = of_sum.dot(own_right - own_normal * heights);
      variance += off * off;
    }
    const double sum = heights.sum();
    if (!(sum > 0.0 && lowered > most && heights.allFinite())) continue;
    most = lowered;
    settled.setZero();
    settled.head(count) = std::max(0.0, 1.0 - variance / (sum * sum)) * heights;
  }
  return settled;
}

// How much more of the settled hot spot the ground shows, by one half of its spots and the other.
struct ShareEquations {
  std::array<double, 2> normal{}, right{};
};

using Cells = std::map<std::pair<std::int64_t, std::int64_t>, ShareEquations>;
constexpr int kCellsInReach = 6;

// By photo, out of what is known by cells of ground `cell_m` wide: the nearer the more.
std::vector<ShareEquations> AroundSpots(const Cells& cells, double cell_m, const SpotsOnGround& spots) {
  std::vector<ShareEquations> around(spots.middles_m.size());
  for (std::size_t i = 0; i < around.size(); ++i) {
    const Eigen::Vector2d middle = spots.middles_m[i] / cell_m;
    if (!middle.allFinite()) continue;
    const auto column = static_cast<std::int64_t>(std::floor(middle.x())),
               row = static_cast<std::int64_t>(std::floor(middle.y()));
    for (std::int64_t y = row - kCellsInReach; y <= row + kCellsInReach; ++y) {
      for (std::int64_t x = column - kCellsInReach; x <= column + kCellsInReach; ++x) {
        const auto cell = cells.find({y, x});
        if (cell == cells.end()) continue;
        const Eigen::Vector2d off{static_cast<double>(x) + 0.5 - middle.x(),
                                  static_cast<double>(y) + 0.5 - middle.y()};
        const double nearness = SpotHill(off.squaredNorm(), static_cast<double>(kCellsInReach));
        for (std::size_t half = 0; half < 2; ++half) {
          around[i].normal[half] += nearness * cell->second.normal[half];
          around[i].right[half] += nearness * cell->second.right[half];
        }
      }
    }
  }
  return around;
}

std::vector<double> SharesOf(const std::vector<ShareEquations>& photos) {
  std::vector<double> shares(photos.size(), 1.0);
  double agreed = 0.0, by_chance = 0.0, normals = 0.0;
  for (const auto& [normal, right] : photos) {
    agreed += right[0] * right[1];
    by_chance += right[0] * right[0] * right[1] * right[1];
    normals += normal[0] * normal[1];
  }
  if (!(normals > 0.0 && agreed > kSigmasOfDifference * std::sqrt(by_chance))) return shares;
  const double variance = agreed / normals;  // of the shares; then of what else photos leave
  double noise = 0.0, weights = 0.0;
  for (const auto& [normal, right] : photos) {
    const double weight = normal[0] + normal[1];
    noise += std::pow(right[0] + right[1], 2) - variance * weight * weight;
    weights += weight;
  }
  noise = std::max(0.0, noise / weights);
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const double weight = photos[i].normal[0] + photos[i].normal[1];
    if (!(weight > 0.0)) continue;
    const double more = variance * (photos[i].right[0] + photos[i].right[1]) / (variance * weight + noise);
    shares[i] = std::clamp(1.0 + more, 0.0, kMaxShare);
  }
  return shares;
}

}  // namespace

std::vector<double> SettleHotSpot(const std::vector<ExposureSample>& samples, std::size_t channel,
                                  const LightTerms& terms, const SpotsOnGround& spots, SolvedLight& light) {
  auto fitted = light.terms.segment<kHills>(static_cast<Eigen::Index>(kSmoothDirectionTerms));
  if (light.terms_by_hill.size() == 0) {
    fitted.setZero();
    return std::vector<double>(terms.photos(), 1.0);
  }
  std::vector<HillSample> of_hills = HillSamplesOf(samples, channel, terms, light);
  std::vector<HillEquations> heights_of(terms.photos());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const HillSample& own = of_hills[i];
    HillEquations& photo = heights_of[samples[i].photo];
    photo.normal += own.weight * own.hills * own.hills.transpose();
    photo.right += own.weight * own.hills * (own.left + own.hills.dot(fitted));
  }
  const Hills settled = SettledHeights(heights_of);
  const Hills change = settled - fitted;
  light.log_gains += light.gains_by_hill * change;
  light.terms += light.terms_by_hill * change;
  fitted = settled;  // to the last bit: 0 is none

  const double cell_m = std::max(spots.reach_m, 1e-3) / kCellsInReach;
  Cells cells;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const HillSample& own = of_hills[i];
    const double spot = own.hills.dot(settled), left = own.left - own.hills.dot(change);
    const auto cell_of = [&](float at_m) {
      return static_cast<std::int64_t>(std::floor(static_cast<double>(at_m) / cell_m));
    };
    ShareEquations& cell = cells[{cell_of(samples[i].ground_m[1]), cell_of(samples[i].ground_m[0])}];
    const std::size_t half = samples[i].spot % 2;
    cell.normal[half] += own.weight * spot * spot;
    cell.right[half] += own.weight * spot * left;
  }
  return SharesOf(AroundSpots(cells, cell_m, spots));
}

}  // namespace skyquilt::render
