#include "core/ground/model_ground.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/base/scoped_timer.h"
#include "core/ground/membrane_grid.h"

namespace skyquilt::ground {
namespace {

constexpr std::size_t kFewPoints = 40;
constexpr int kHoldBackEvery = 5;
constexpr double kGridMustBeBetter = 0.75;  // its error as a share of the plane's
constexpr double kLeastCellM = 1.0;
constexpr double kCellGsds = 40.0;
// Tried, from following every point to evening out their noise; held-back points choose.
constexpr double kStiffnesses[] = {0.3, 1.0, 3.0, 10.0, 30.0};
// Heights that would shift nothing by a visible part of a pixel.
constexpr double kFlatWithinGsds = 0.25;

struct FlightScale {
  double height_m = 50.0;
  double gsd_m = 0.02;
};

FlightScale ScaleOf(const alignment::AlignedFlight& flight) {
  std::vector<double> heights, gsds;
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    heights.push_back(photo.height_above_ground_m);
    gsds.push_back(photo.height_above_ground_m / photo.intrinsics.MeanFocalPx());
  }
  if (heights.empty()) return {};
  return {Median(heights), Median(gsds)};
}

// Drops points far off the median height of their neighbourhood.
std::vector<Eigen::Vector3d> DropOutliers(const std::vector<Eigen::Vector3d>& points,
                                          const FlightScale& scale) {
  const double cell_m = 0.15 * scale.height_m;
  using Cell = std::pair<long, long>;
  std::map<Cell, std::vector<double>> cells;
  const auto cell_of = [&](const Eigen::Vector3d& point) {
    return Cell{std::lround(std::floor(point.x() / cell_m)), std::lround(std::floor(point.y() / cell_m))};
  };
  for (const Eigen::Vector3d& point : points) cells[cell_of(point)].push_back(point.z());
  std::map<Cell, std::pair<double, double>> bands;  // middle and half width around each cell
  for (const auto& entry : cells) {
    std::vector<double> around;
    for (long x = entry.first.first - 1; x <= entry.first.first + 1; ++x) {
      for (long y = entry.first.second - 1; y <= entry.first.second + 1; ++y) {
        const auto neighbour = cells.find({x, y});
        if (neighbour != cells.end())
          around.insert(around.end(), neighbour->second.begin(), neighbour->second.end());
      }
    }
    const double middle = Median(around);
    for (double& z : around) z = std::abs(z - middle);
    bands[entry.first] = {middle, std::max(0.035 * scale.height_m, 6.0 * Median(around))};
  }
  std::vector<Eigen::Vector3d> kept;
  for (const Eigen::Vector3d& point : points) {
    const auto& [middle, half_width] = bands[cell_of(point)];
    if (std::abs(point.z() - middle) <= half_width) kept.push_back(point);
  }
  return kept;
}

GroundSurface AsSurface(MembraneGrid grid, double mean_z_m) {
  return GroundSurface::Grid(grid.south_west_in_enu, grid.cell_m, grid.columns, grid.rows,
                             std::move(grid.heights_m), mean_z_m);
}

}  // namespace

GroundSurface ModelGround(const alignment::AlignedFlight& flight, ModelGroundReport& report) {
  report = {};
  ScopedTimer timer(report.seconds);
  report.points_given = static_cast<int>(flight.tie_points_in_enu.size());
  const FlightScale scale = ScaleOf(flight);
  const auto finish = [&](GroundSurface surface, const char* model, std::string reason) {
    report.model = model;
    report.reason = std::move(reason);
    report.lowest_m = surface.MinHeight();
    report.highest_m = surface.MaxHeight();
    report.mean_m = surface.MeanHeight();
    report.cell_m = surface.IsPlane() ? 0.0 : surface.CellSize();
    return surface;
  };
  const std::vector<Eigen::Vector3d> points = DropOutliers(flight.tie_points_in_enu, scale);
  report.points_used = static_cast<int>(points.size());
  if (points.size() < kFewPoints) {
    return finish(GroundSurface::Plane(flight.ground_z_in_enu_m), "plane",
                  fmt::format("only {} points on the ground are known: the flat ground of the recorded poses",
                              points.size()));
  }
  std::vector<double> heights;
  for (const Eigen::Vector3d& point : points) heights.push_back(point.z());
  const double mean_z_m = Median(heights);
  const double cell_m = std::max(kLeastCellM, kCellGsds * scale.gsd_m);

  std::vector<Eigen::Vector3d> fitted, held_back;
  for (std::size_t i = 0; i < points.size(); ++i)
    (i % kHoldBackEvery == 0 ? held_back : fitted).push_back(points[i]);
  const auto error_of = [&](const GroundSurface& surface) {
    std::vector<double> off;
    for (const Eigen::Vector3d& point : held_back)
      off.push_back(std::abs(point.z() - surface.HeightAt(point.head<2>())));
    return Median(std::move(off));
  };
  report.plane_error_m = error_of(GroundSurface::Plane(mean_z_m));
  double stiffness = kStiffnesses[0];
  for (const double tried : kStiffnesses) {
    const double error_m = error_of(AsSurface(FitMembrane(fitted, cell_m, mean_z_m, tried), mean_z_m));
    if (tried != kStiffnesses[0] && error_m >= report.grid_error_m) continue;
    report.grid_error_m = error_m;
    stiffness = tried;
  }
  if (report.plane_error_m < kFlatWithinGsds * scale.gsd_m) {
    return finish(GroundSurface::Plane(mean_z_m), "plane",
                  fmt::format("points lie within {:.2f} m of a level plane", report.plane_error_m));
  }
  if (report.grid_error_m > kGridMustBeBetter * report.plane_error_m) {
    return finish(GroundSurface::Plane(mean_z_m), "plane",
                  fmt::format("a grid explains held-back points no better ({:.2f} m) than a plane ({:.2f} m)",
                              report.grid_error_m, report.plane_error_m));
  }
  return finish(AsSurface(FitMembrane(points, cell_m, mean_z_m, stiffness), mean_z_m), "grid",
                fmt::format("held-back points lie {:.2f} m off the grid and {:.2f} m off a plane",
                            report.grid_error_m, report.plane_error_m));
}

std::string ModelGroundReportJson(const ModelGroundReport& report) {
  const nlohmann::ordered_json json = {{"model", report.model},
                                       {"reason", report.reason},
                                       {"points_given", report.points_given},
                                       {"points_used", report.points_used},
                                       {"plane_error_m", report.plane_error_m},
                                       {"grid_error_m", report.grid_error_m},
                                       {"cell_m", report.cell_m},
                                       {"lowest_m", report.lowest_m},
                                       {"highest_m", report.highest_m},
                                       {"mean_m", report.mean_m},
                                       {"seconds", report.seconds}};
  return json.dump(2);
}

}  // namespace skyquilt::ground
