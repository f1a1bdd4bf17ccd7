#include "core/geo/height_trend.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/median.h"
#include "core/geo/bounds.h"

namespace skyquilt::geo {
namespace {

using Row = Eigen::Vector4d;                   // of 1, x, y, x^2 + y^2
constexpr std::array<int, 3> kTerms{1, 3, 4};  // of each shape
constexpr std::size_t kCellsPerTerm = 6;
// The error of a shape as a share of the simpler one's. Hills are better explained by any shape with more
// terms, and end where they end: a shape that is to hold beyond the points explains most of what the simpler
// one leaves.
constexpr std::array<double, 3> kMustBe{1.0, 0.5, 0.4};
constexpr int kRounds = 10;
// What a slope is held by where the points say little of it, as across a single flight line: equations a
// cell.
constexpr double kSlopeHold = 0.001;
constexpr double kMadsOfWidth = 3.0;
constexpr double kLeastWidthM = 0.01;

struct Cell {
  Row row;
  double height_m = 0.0;
};

struct Fit {
  Row terms = Row::Zero();
  double error_m = 0.0;
};

Fit FitTerms(const std::vector<Cell>& cells, int terms, double median_m) {
  Fit fit;
  fit.terms[0] = median_m;
  std::vector<double> misses(cells.size());
  for (int round = 0;; ++round) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      misses[i] = std::abs(cells[i].height_m - cells[i].row.dot(fit.terms));
    }
    fit.error_m = Median(misses);
    if (round == kRounds || terms == 1) return fit;
    const double width_m = std::max(kLeastWidthM, kMadsOfWidth * fit.error_m);
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(terms, terms);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(terms);
    normal(1, 1) = normal(2, 2) = kSlopeHold * static_cast<double>(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const double weight = 1.0 / (1.0 + misses[i] * misses[i] / (width_m * width_m));
      const Eigen::VectorXd row = cells[i].row.head(terms);
      normal += weight * row * row.transpose();
      right += weight * cells[i].height_m * row;
    }
    fit.terms.head(terms) = normal.ldlt().solve(right);
  }
}

}  // namespace

std::vector<Eigen::Vector3d> CellMedians(const std::vector<Eigen::Vector3d>& points_in_enu, double cell_m) {
  std::map<std::pair<long, long>, std::vector<Eigen::Vector3d>> points_of_cell;
  for (const Eigen::Vector3d& point : points_in_enu) {
    points_of_cell[{std::lround(point.x() / cell_m), std::lround(point.y() / cell_m)}].push_back(point);
  }
  std::vector<Eigen::Vector3d> medians;
  for (const auto& [at, points] : points_of_cell) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    std::vector<double> ups;
    for (const Eigen::Vector3d& point : points) {
      middle += point;
      ups.push_back(point.z());
    }
    middle /= static_cast<double>(points.size());
    middle.z() = Median(std::move(ups));
    medians.push_back(middle);
  }
  return medians;
}

HeightTrend FitHeightTrend(const std::vector<Eigen::Vector3d>& points_in_enu, double cell_m) {
  std::vector<double> heights;
  Bounds2 bounds;
  for (const Eigen::Vector3d& point : points_in_enu) {
    heights.push_back(point.z());
    bounds.Include(Eigen::Vector2d(point.head<2>()));
  }
  if (heights.empty()) return {};
  const double median_m = Median(std::move(heights));
  const Eigen::Vector2d center = 0.5 * (bounds.min + bounds.max);
  // Coordinates up to about 1, so that all terms count alike.
  const double reach_m = std::max(cell_m, 0.5 * std::max(bounds.Width(), bounds.Height()));
  std::vector<Cell> cells;
  for (const Eigen::Vector3d& median : CellMedians(points_in_enu, cell_m)) {
    const Eigen::Vector2d p = (median.head<2>() - center) / reach_m;
    cells.push_back({{1.0, p.x(), p.y(), p.squaredNorm()}, median.z()});
  }
  Fit best = FitTerms(cells, kTerms[0], median_m);
  std::size_t shape = 0;
  for (std::size_t tried = 1; tried < kTerms.size(); ++tried) {
    if (cells.size() < kCellsPerTerm * static_cast<std::size_t>(kTerms[tried])) break;
    const Fit fit = FitTerms(cells, kTerms[tried], median_m);
    if (fit.error_m > kMustBe[tried] * best.error_m) continue;
    best = fit;
    shape = tried;
  }
  return {.shape = static_cast<HeightTrend::Shape>(shape),
          .center_in_enu = center,
          .height_m = best.terms[0],
          .slope = best.terms.segment<2>(1) / reach_m,
          .bowl_per_m = best.terms[3] / (reach_m * reach_m),
          .error_m = best.error_m};
}

}  // namespace skyquilt::geo
