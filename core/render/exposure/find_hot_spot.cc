#include "core/render/exposure/find_hot_spot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/median.h"
#include "core/render/exposure/light_equations.h"

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

}  // namespace skyquilt::render
