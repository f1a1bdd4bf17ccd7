#include "core/ground/membrane_grid.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/geo/bounds.h"
#include "core/geo/height_trend.h"

namespace skyquilt::ground {
namespace {

// Of the broad shape; lengths in flying heights.
constexpr double kCell = 0.2;
constexpr double kNear = 0.3;          // sigma of the weights
constexpr double kGoesOn = 0.35;       // how far a slope is carried on
constexpr double kFarInNear = 3.0;     // in sigmas: beyond, nothing counts
constexpr double kTrendWeight = 0.01;  // of the trend, against 1 for a cell right here
constexpr double kSlopeHold = 0.05;
// Over a wide land flown low the cells grow instead of their number.
constexpr double kMaxBroadCells = 250'000.0;

// What lies above the trend at a place. Each row's cells lie from west to east.
double AboveTrend(const std::vector<std::vector<Eigen::Vector3d>>& rows, const Eigen::Vector2d& place,
                  double south_m, double cell_m, double height_m) {
  const double near_m = kNear * height_m;
  double weight = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  const auto row_of = [&](double north) {
    return std::clamp<long>(std::lround((north - south_m) / cell_m), 0, static_cast<long>(rows.size()) - 1);
  };
  const long last = row_of(place.y() + kFarInNear * near_m);
  for (long row = row_of(place.y() - kFarInNear * near_m); row <= last; ++row) {
    const std::vector<Eigen::Vector3d>& cells = rows[static_cast<std::size_t>(row)];
    const double west = place.x() - kFarInNear * near_m, east = place.x() + kFarInNear * near_m;
    auto cell = std::partition_point(cells.begin(), cells.end(),
                                     [&](const Eigen::Vector3d& one) { return one.x() < west; });
    for (; cell != cells.end() && cell->x() <= east; ++cell) {
      Eigen::Vector3d from_place = *cell;
      from_place.head<2>() -= place;
      const double far2 = from_place.head<2>().squaredNorm() / (near_m * near_m);
      if (far2 > kFarInNear * kFarInNear) continue;
      const double counts = std::exp(-0.5 * far2);
      weight += counts;
      sum += counts * from_place;
      square += counts * from_place * from_place.transpose();
    }
  }
  if (weight <= 0.0) return 0.0;
  const Eigen::Vector3d mean = sum / weight;
  const Eigen::Matrix3d spread = square / weight - mean * mean.transpose();
  const Eigen::Matrix2d held =
      spread.topLeftCorner<2, 2>() + kSlopeHold * near_m * near_m * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d slope = held.ldlt().solve(Eigen::Vector2d(spread.col(2).head<2>()));
  const double explained = slope.dot(spread.topLeftCorner<2, 2>() * slope);
  const double share = spread(2, 2) > 0.0 ? std::min(1.0, explained / spread(2, 2)) : 0.0;
  Eigen::Vector2d to_place = -mean.head<2>();
  const double far_m = to_place.norm();
  if (far_m > kGoesOn * height_m) to_place *= kGoesOn * height_m / far_m;
  return weight / (weight + kTrendWeight) * (mean.z() + share * slope.dot(to_place));
}

}  // namespace

GroundSurface BroadShape(const std::vector<Eigen::Vector3d>& points_in_enu, double flown_height_m,
                         double margin_m) {
  geo::Bounds2 bounds;
  for (const Eigen::Vector3d& point : points_in_enu) bounds.Include(Eigen::Vector2d(point.head<2>()));
  double cell_m = kCell * flown_height_m;
  if (!bounds.IsEmpty()) {
    const double area_m2 = (bounds.Width() + 2.0 * margin_m) * (bounds.Height() + 2.0 * margin_m);
    cell_m = std::max(cell_m, std::sqrt(area_m2 / kMaxBroadCells));
  }
  const geo::HeightTrend trend = geo::FitHeightTrend(points_in_enu, cell_m);
  if (bounds.IsEmpty()) return GroundSurface::Plane(trend.height_m);
  const Eigen::Vector2d south_west = bounds.min - Eigen::Vector2d::Constant(margin_m);
  const int columns = static_cast<int>(std::ceil((bounds.Width() + 2.0 * margin_m) / cell_m)) + 2;
  const int count = static_cast<int>(std::ceil((bounds.Height() + 2.0 * margin_m) / cell_m)) + 2;
  std::vector<std::vector<Eigen::Vector3d>> rows(static_cast<std::size_t>(count));
  for (Eigen::Vector3d cell : geo::CellMedians(points_in_enu, cell_m)) {
    cell.z() -= trend.At(cell.head<2>());
    rows[static_cast<std::size_t>(std::lround((cell.y() - south_west.y()) / cell_m))].push_back(cell);
  }
  for (std::vector<Eigen::Vector3d>& row : rows) {
    std::sort(row.begin(), row.end(),
              [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.x() < b.x(); });
  }
  std::vector<float> heights;
  heights.reserve(static_cast<std::size_t>(columns) * count);
  for (int row = 0; row < count; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d place = south_west + cell_m * Eigen::Vector2d(column, row);
      heights.push_back(static_cast<float>(trend.At(place) +
                                           AboveTrend(rows, place, south_west.y(), cell_m, flown_height_m)));
    }
  }
  return GroundSurface::Grid(south_west, cell_m, columns, count, std::move(heights), trend.height_m);
}

namespace {

constexpr int kMinMarginCells = 12;
constexpr int kMaxCells = 4'000'000;
constexpr int kSweeps = 40;
constexpr double kOverRelaxation = 1.6;
constexpr double kMaxPointsPerCell = 4.0;  // more do not make a cell stiffer: neighbours must agree as well
// Away from points the surface returns to the broad shape within about 20 cells (1 / sqrt of this).
constexpr double kPullToShape = 0.0025;
constexpr int kSmallestSide = 8;

struct Level {
  int columns = 0, rows = 0;
  std::vector<float> target;  // height over the broad shape
  std::vector<float> weight;
  std::vector<float> height;
};

Level Coarser(const Level& fine) {
  Level coarse;
  coarse.columns = (fine.columns + 1) / 2;
  coarse.rows = (fine.rows + 1) / 2;
  const std::size_t cells = static_cast<std::size_t>(coarse.columns) * coarse.rows;
  coarse.target.assign(cells, 0.0F);
  coarse.weight.assign(cells, 0.0F);
  coarse.height.assign(cells, 0.0F);
  for (int row = 0; row < fine.rows; ++row) {
    for (int column = 0; column < fine.columns; ++column) {
      const std::size_t from = static_cast<std::size_t>(row) * fine.columns + column;
      const std::size_t to = static_cast<std::size_t>(row / 2) * coarse.columns + column / 2;
      coarse.target[to] += fine.weight[from] * fine.target[from];
      coarse.weight[to] += fine.weight[from];
    }
  }
  for (std::size_t i = 0; i < cells; ++i) {
    if (coarse.weight[i] > 0.0F) coarse.target[i] /= coarse.weight[i];
    coarse.weight[i] = std::min<float>(coarse.weight[i], kMaxPointsPerCell);
  }
  return coarse;
}

void Relax(Level& level, double stiffness, double pull) {
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int row = 0; row < level.rows; ++row) {
      for (int column = 0; column < level.columns; ++column) {
        const std::size_t at = static_cast<std::size_t>(row) * level.columns + column;
        double sum = level.weight[at] * level.target[at];
        double weight = level.weight[at] + pull;
        const auto add = [&](bool inside, std::size_t neighbour) {
          if (!inside) return;
          sum += stiffness * level.height[neighbour];
          weight += stiffness;
        };
        add(column > 0, at - 1);
        add(column + 1 < level.columns, at + 1);
        add(row > 0, at - level.columns);
        add(row + 1 < level.rows, at + level.columns);
        const double settled = sum / weight;
        level.height[at] += static_cast<float>(kOverRelaxation * (settled - level.height[at]));
      }
    }
  }
}

}  // namespace

MembraneGrid FitMembrane(const std::vector<Eigen::Vector3d>& points_in_enu, double cell_m,
                         const GroundSurface& broad_shape, double margin_m, double stiffness) {
  geo::Bounds2 bounds;
  for (const Eigen::Vector3d& point : points_in_enu) bounds.Include(Eigen::Vector2d(point.head<2>()));
  if (bounds.IsEmpty()) bounds.Include(Eigen::Vector2d(0.0, 0.0));
  margin_m = std::max(margin_m, kMinMarginCells * cell_m);
  const double area = (bounds.Width() + 2.0 * margin_m) * (bounds.Height() + 2.0 * margin_m);
  cell_m = std::max(cell_m, std::sqrt(area / kMaxCells));
  MembraneGrid grid;
  grid.cell_m = cell_m;
  const int margin = static_cast<int>(std::ceil(margin_m / cell_m));
  grid.south_west_in_enu = bounds.min - Eigen::Vector2d::Constant(margin * cell_m);
  grid.columns = static_cast<int>(std::ceil(bounds.Width() / cell_m)) + 2 * margin + 1;
  grid.rows = static_cast<int>(std::ceil(bounds.Height() / cell_m)) + 2 * margin + 1;

  // Medians per node; points sorted by node, so that no cell needs its own list.
  std::vector<std::pair<std::size_t, float>> by_node;
  by_node.reserve(points_in_enu.size());
  for (const Eigen::Vector3d& point : points_in_enu) {
    const Eigen::Vector2d at = (point.head<2>() - grid.south_west_in_enu) / cell_m;
    const std::size_t column =
        static_cast<std::size_t>(std::clamp<long>(std::lround(at.x()), 0, grid.columns - 1));
    const std::size_t row = static_cast<std::size_t>(std::clamp<long>(std::lround(at.y()), 0, grid.rows - 1));
    by_node.emplace_back(row * grid.columns + column,
                         static_cast<float>(point.z() - broad_shape.HeightAt(point.head<2>())));
  }
  std::sort(by_node.begin(), by_node.end());
  std::vector<Level> levels(1);
  Level& finest = levels.front();
  finest.columns = grid.columns;
  finest.rows = grid.rows;
  const std::size_t nodes = static_cast<std::size_t>(grid.columns) * grid.rows;
  finest.target.assign(nodes, 0.0F);
  finest.weight.assign(nodes, 0.0F);
  finest.height.assign(nodes, 0.0F);
  for (std::size_t i = 0; i < by_node.size();) {
    std::size_t end = i;
    while (end < by_node.size() && by_node[end].first == by_node[i].first) ++end;
    finest.target[by_node[i].first] = by_node[(i + end) / 2].second;
    finest.weight[by_node[i].first] = static_cast<float>(std::min<double>(kMaxPointsPerCell, end - i));
    i = end;
  }
  while (std::min(levels.back().columns, levels.back().rows) > kSmallestSide) {
    levels.push_back(Coarser(levels.back()));
  }
  for (std::size_t l = levels.size(); l-- > 0;) {
    Level& level = levels[l];
    if (l + 1 < levels.size()) {
      const Level& coarse = levels[l + 1];
      for (int row = 0; row < level.rows; ++row) {
        for (int column = 0; column < level.columns; ++column) {
          level.height[static_cast<std::size_t>(row) * level.columns + column] =
              coarse.height[static_cast<std::size_t>(row / 2) * coarse.columns + column / 2];
        }
      }
    }
    // A coarse cell stands for four fine ones: the pull counts as much over the same ground.
    Relax(level, stiffness, stiffness * kPullToShape * std::pow(4.0, static_cast<double>(l)));
  }
  grid.heights_m = std::move(levels.front().height);
  for (std::size_t i = 0; i < nodes; ++i) {
    const auto columns = static_cast<std::size_t>(grid.columns);
    const std::size_t row = i / columns, column = i % columns;
    const Eigen::Vector2d node(static_cast<double>(column), static_cast<double>(row));
    grid.heights_m[i] += static_cast<float>(broad_shape.HeightAt(grid.south_west_in_enu + cell_m * node));
  }
  return grid;
}

}  // namespace skyquilt::ground
