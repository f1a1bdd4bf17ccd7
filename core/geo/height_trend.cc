#include "core/geo/height_trend.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/median.h"
#include "core/geo/bounds.h"
#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::geo {
namespace {

using Shape = HeightTrend::Shape;
using Row = Eigen::Vector4d;  // of 1, x, y, x^2 + y^2
constexpr int kRounds = 10;
// What a slope is held by where the points say little of it, as across a single flight line: equations a
// point.
constexpr double kSlopeHold = 0.001;
constexpr double kMadsOfWidth = 3.0;
constexpr double kMinWidthM = 0.01;  // of cells
constexpr std::size_t kCellsPerTerm = 6;

int TermsOf(Shape shape) { return shape == Shape::kLevel ? 1 : shape == Shape::kPlane ? 3 : 4; }

// The error of a shape as a share of the simpler one's. Hills are better explained by any shape with more
// terms, and end where they end: a shape that is to hold beyond the points explains most of what the simpler
// one leaves.
double MustBe(Shape shape) { return shape == Shape::kPlane ? 0.5 : 0.4; }

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

HeightTrend FitShape(const std::vector<Eigen::Vector3d>& points_in_enu, Shape shape, double min_width_m) {
  if (points_in_enu.empty()) return {};
  std::vector<double> heights, misses_m;
  Bounds2 bounds;
  for (const Eigen::Vector3d& point : points_in_enu) {
    heights.push_back(point.z());
    bounds.Include(Eigen::Vector2d(point.head<2>()));
  }
  HeightTrend trend = HeightTrend::Level(Median(heights));
  trend.shape = shape;
  trend.center_in_enu = 0.5 * (bounds.min + bounds.max);
  // Coordinates up to about 1, so that all terms count alike.
  const double reach_m = std::max(1.0, 0.5 * std::max(bounds.Width(), bounds.Height()));
  const int terms = TermsOf(shape);
  for (int round = 0;; ++round) {
    misses_m.clear();
    for (const Eigen::Vector3d& point : points_in_enu)
      misses_m.push_back(std::abs(point.z() - trend.At(point.head<2>())));
    trend.error_m = Median(misses_m);
    if (round == kRounds || shape == Shape::kLevel) return trend;
    const double width_m = std::max(min_width_m, kMadsOfWidth * trend.error_m);
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(terms, terms);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(terms);
    normal(1, 1) = normal(2, 2) = kSlopeHold * static_cast<double>(points_in_enu.size());
    for (std::size_t i = 0; i < points_in_enu.size(); ++i) {
      const Eigen::Vector2d p = (points_in_enu[i].head<2>() - trend.center_in_enu) / reach_m;
      const Eigen::VectorXd row = Row(1.0, p.x(), p.y(), p.squaredNorm()).head(terms);
      const double weight = 1.0 / (1.0 + misses_m[i] * misses_m[i] / (width_m * width_m));
      normal += weight * row * row.transpose();
      right += weight * points_in_enu[i].z() * row;
    }
    Row solved = Row::Zero();
    solved.head(terms) = SolveSymmetric(normal, right);
    trend.height_m = solved[0];
    trend.slope = solved.segment<2>(1) / reach_m;
    trend.bowl_per_m = solved[3] / (reach_m * reach_m);
  }
}

HeightTrend FitHeightTrend(const std::vector<Eigen::Vector3d>& points_in_enu, double cell_m) {
  const std::vector<Eigen::Vector3d> cells = CellMedians(points_in_enu, cell_m);
  HeightTrend best = FitShape(cells, Shape::kLevel, kMinWidthM);
  for (const Shape shape : {Shape::kPlane, Shape::kBowl}) {
    if (cells.size() < kCellsPerTerm * static_cast<std::size_t>(TermsOf(shape))) break;
    const HeightTrend tried = FitShape(cells, shape, kMinWidthM);
    if (tried.error_m <= MustBe(shape) * best.error_m) best = tried;
  }
  return best;
}

}  // namespace skyquilt::geo
