#include "core/ground/model_ground.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/base/scoped_timer.h"
#include "core/camera/footprint.h"
#include "core/geo/bounds.h"
#include "core/geo/local_frame.h"
#include "core/ground/membrane_grid.h"

namespace skyquilt::ground {
namespace {

constexpr double kMaxNodes = 250'000;  // of a sampled elevation model

// From the nodes known, ring by ring, until none is left.
void FillHoles(std::vector<char>& known, MembraneGrid& grid) {
  const auto at = [&](int column, int row) { return static_cast<std::size_t>(row) * grid.columns + column; };
  while (std::find(known.begin(), known.end(), 0) != known.end()) {
    const std::vector<char> before = known;
    for (int row = 0; row < grid.rows; ++row) {
      for (int column = 0; column < grid.columns; ++column) {
        if (before[at(column, row)]) continue;
        double sum = 0.0;
        int count = 0;
        for (int r = std::max(0, row - 1); r <= std::min(grid.rows - 1, row + 1); ++r) {
          for (int c = std::max(0, column - 1); c <= std::min(grid.columns - 1, column + 1); ++c) {
            if (!before[at(c, r)]) continue;
            sum += grid.heights_m[at(c, r)];
            ++count;
          }
        }
        if (count == 0) continue;
        grid.heights_m[at(column, row)] = static_cast<float>(sum / count);
        known[at(column, row)] = 1;
      }
    }
  }
}

// An elevation model in the flight's enu frame. Holes take the mean of what lies around them. Nothing where
// the model covers less than half of the area. Cells grow beyond cell_m where there would be too many.
std::optional<MembraneGrid> SampleDem(const ElevationModel& model, const geo::LocalFrame& frame,
                                      const geo::Bounds2& area_in_enu, double cell_m) {
  MembraneGrid grid;
  grid.cell_m = std::max(cell_m, std::sqrt(area_in_enu.Width() * area_in_enu.Height() / kMaxNodes));
  grid.south_west_in_enu = area_in_enu.min;
  grid.columns = std::max(2, static_cast<int>(std::ceil(area_in_enu.Width() / grid.cell_m)) + 1);
  grid.rows = std::max(2, static_cast<int>(std::ceil(area_in_enu.Height() / grid.cell_m)) + 1);
  const std::size_t nodes = static_cast<std::size_t>(grid.columns) * grid.rows;
  grid.heights_m.assign(nodes, 0.0F);
  std::vector<char> known(nodes, 0);
  for (std::size_t i = 0; i < nodes; ++i) {
    const std::size_t row = i / grid.columns, column = i % grid.columns;
    const Eigen::Vector2d at =
        grid.south_west_in_enu +
        grid.cell_m * Eigen::Vector2d(static_cast<double>(column), static_cast<double>(row));
    const geo::Wgs84 place = frame.Wgs84FromEnu({at.x(), at.y(), 0.0});
    const auto height_m = model.source->GroundHeightM({place.lat_deg, place.lon_deg});
    if (!height_m) continue;
    const double ellipsoid_m = frame.origin().height_ellipsoid_m + *height_m - model.zero_m;
    grid.heights_m[i] =
        static_cast<float>(frame.EnuFromWgs84({place.lat_deg, place.lon_deg, ellipsoid_m}).z());
    known[i] = 1;
  }
  if (2 * static_cast<std::size_t>(std::count(known.begin(), known.end(), 1)) < nodes) return std::nullopt;
  FillHoles(known, grid);
  return grid;
}

constexpr std::size_t kFewPoints = 40;
constexpr int kHoldBackEvery = 5;
constexpr double kGridMustBeBetter = 0.75;  // its error as a share of the plane's
// Tried, from following every point to evening out their noise; held-back points choose.
constexpr double kStiffnesses[] = {0.3, 1.0, 3.0, 10.0, 30.0};
constexpr double kModelAsGood = 1.05;
constexpr double kMinCellM = 1.0;
constexpr double kCellGsds = 40.0;
// Of a photo that looks towards the horizon no more than this, in flying heights.
constexpr double kMaxMarginHeights = 2.0;
constexpr double kMinHeightM = 0.5;  // of a camera above the ground
// A point further from the cameras than this came of rays that hardly cross.
constexpr double kFarthestPointM = 100'000.0;
// Heights that would shift nothing by a visible part of a pixel.
constexpr double kFlatWithinGsds = 0.25;

struct FlightScale {
  double height_m = 50.0;
  double gsd_m = 0.02;
};

FlightScale ScaleOf(const alignment::AlignedFlight& flight) {
  std::vector<double> heights, gsds;
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    const double height_m = std::max(kMinHeightM, photo.height_above_ground_m);
    heights.push_back(height_m);
    gsds.push_back(height_m / photo.intrinsics.MeanFocalPx());
  }
  if (heights.empty()) return {};
  return {Median(heights), Median(gsds)};
}

std::vector<Eigen::Vector3d> OnEarth(const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Vector3d> kept;
  kept.reserve(points.size());
  for (const Eigen::Vector3d& point : points) {
    // Each by itself, so that none that is not a number passes: maxCoeff() may step over it.
    if ((point.array().abs() < kFarthestPointM).all()) kept.push_back(point);
  }
  return kept;
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

// What the photos look at, as if the ground were level.
geo::Bounds2 SeenArea(const alignment::AlignedFlight& flight, double ground_z_m) {
  geo::Bounds2 area;
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    for (const Eigen::Vector2d& corner :
         camera::GroundFootprint(photo.intrinsics, photo.cam_from_enu, ground_z_m, 1))
      area.Include(corner);
  }
  return area;
}

// How far photos look beyond the points, east, north, west or south.
double Overhang(const geo::Bounds2& seen, const std::vector<Eigen::Vector3d>& points) {
  if (seen.IsEmpty()) return 0.0;
  geo::Bounds2 known;
  for (const Eigen::Vector3d& point : points) known.Include(Eigen::Vector2d(point.head<2>()));
  return std::max(0.0, std::max((known.min - seen.min).maxCoeff(), (seen.max - known.max).maxCoeff()));
}

// How far up an elevation model in enu must go to meet the points.
double ShiftTo(const std::vector<Eigen::Vector3d>& points, const GroundSurface& model) {
  std::vector<double> ups;
  ups.reserve(points.size());
  for (const Eigen::Vector3d& point : points) ups.push_back(point.z() - model.HeightAt(point.head<2>()));
  return Median(std::move(ups));
}

// The model moved up as a whole and bent to the points where they are.
GroundSurface BendTo(const std::vector<Eigen::Vector3d>& points, const GroundSurface& model, double shift_m,
                     double cell_m, double stiffness) {
  std::vector<Eigen::Vector3d> above = points;
  std::vector<double> heights;
  heights.reserve(above.size());
  for (Eigen::Vector3d& point : above) {
    heights.push_back(point.z());
    point.z() -= model.HeightAt(point.head<2>());
  }
  const GroundSurface bend =
      AsSurface(FitMembrane(above, cell_m, GroundSurface::Plane(shift_m), 0.0, stiffness), shift_m);
  std::vector<float> bent = model.Heights();
  for (std::size_t i = 0; i < bent.size(); ++i) {
    const std::size_t columns = static_cast<std::size_t>(model.Columns());
    const std::size_t row = i / columns, column = i % columns;
    const Eigen::Vector2d node(static_cast<double>(column), static_cast<double>(row));
    bent[i] += static_cast<float>(bend.HeightAt(model.SouthWest() + model.CellSize() * node));
  }
  return GroundSurface::Grid(model.SouthWest(), model.CellSize(), model.Columns(), model.Rows(),
                             std::move(bent), Median(std::move(heights)));
}

double MedianError(const std::vector<Eigen::Vector3d>& points, const GroundSurface& surface) {
  std::vector<double> off;
  off.reserve(points.size());
  for (const Eigen::Vector3d& point : points) {
    off.push_back(std::abs(point.z() - surface.HeightAt(point.head<2>())));
  }
  return Median(std::move(off));
}

struct Judged {
  double stiffness = kStiffnesses[0];
  double error_m = 0.0;
};

// The stiffness with which a surface made of the other points lies nearest to those held back.
template <typename SurfaceOf>
Judged BestStiffness(const std::vector<Eigen::Vector3d>& held_back, const SurfaceOf& surface_of) {
  Judged best;
  for (const double tried : kStiffnesses) {
    const double error_m = MedianError(held_back, surface_of(tried));
    if (tried != kStiffnesses[0] && error_m >= best.error_m) continue;
    best = {tried, error_m};
  }
  return best;
}

}  // namespace

GroundSurface ModelGround(const alignment::AlignedFlight& flight, ModelGroundReport& report,
                          const std::optional<ElevationModel>& elevation_model) {
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
  const std::vector<Eigen::Vector3d> points = DropOutliers(OnEarth(flight.tie_points_in_enu), scale);
  report.points_used = static_cast<int>(points.size());
  const double cell_m = std::max(kMinCellM, kCellGsds * scale.gsd_m);
  std::optional<GroundSurface> model;
  geo::Bounds2 area = SeenArea(flight, flight.ground_z_in_enu_m);
  if (elevation_model && !area.IsEmpty()) {
    // Where the ground falls away the photos see more of it.
    area.min -= Eigen::Vector2d::Constant(scale.height_m);
    area.max += Eigen::Vector2d::Constant(scale.height_m);
    if (auto sampled = SampleDem(*elevation_model, flight.frame, area, cell_m)) {
      std::vector<double> nodes(sampled->heights_m.begin(), sampled->heights_m.end());
      model = AsSurface(*std::move(sampled), Median(std::move(nodes)));
    }
  }
  if (points.size() < kFewPoints && model) {
    report.dem_shift_m = 0.0;
    return finish(
        *std::move(model), "elevation model",
        fmt::format("only {} points on the ground are known: the elevation model, its zero at take-off",
                    points.size()));
  }
  if (points.size() < kFewPoints) {
    return finish(GroundSurface::Plane(flight.ground_z_in_enu_m), "plane",
                  fmt::format("only {} points on the ground are known: the flat ground of the recorded poses",
                              points.size()));
  }
  std::vector<double> heights;
  heights.reserve(points.size());
  for (const Eigen::Vector3d& point : points) heights.push_back(point.z());
  const double mean_z_m = Median(heights);
  const double margin_m =
      std::min(Overhang(SeenArea(flight, mean_z_m), points), kMaxMarginHeights * scale.height_m);
  const GroundSurface shape = BroadShape(points, scale.height_m, margin_m);

  std::vector<Eigen::Vector3d> fitted, held_back;
  for (std::size_t i = 0; i < points.size(); ++i)
    (i % kHoldBackEvery == 0 ? held_back : fitted).push_back(points[i]);
  const Judged grid = BestStiffness(held_back, [&](double stiffness) {
    return AsSurface(FitMembrane(fitted, cell_m, shape, 0.0, stiffness), mean_z_m);
  });
  report.plane_error_m = MedianError(held_back, GroundSurface::Plane(mean_z_m));
  report.grid_error_m = grid.error_m;
  Judged bent;
  if (model) {
    const double shift_m = ShiftTo(fitted, *model);
    std::vector<Eigen::Vector3d> lowered = held_back;
    for (Eigen::Vector3d& point : lowered) point.z() -= shift_m;
    report.dem_error_m = MedianError(lowered, *model);
    bent = BestStiffness(
        held_back, [&](double stiffness) { return BendTo(fitted, *model, shift_m, cell_m, stiffness); });
  }
  if (report.plane_error_m < kFlatWithinGsds * scale.gsd_m) {
    return finish(GroundSurface::Plane(mean_z_m), "plane",
                  fmt::format("points lie within {:.2f} m of a level plane", report.plane_error_m));
  }
  // A model is believed where it has the shape of the points before it is bent to them. As good as a grid
  // where points are, it is better where none are.
  if (report.dem_error_m && *report.dem_error_m <= kGridMustBeBetter * report.plane_error_m &&
      bent.error_m <= kModelAsGood * report.grid_error_m) {
    const double shift_m = ShiftTo(points, *model);
    report.dem_shift_m = shift_m;
    return finish(
        BendTo(points, *model, shift_m, cell_m, bent.stiffness), "elevation model",
        fmt::format("moved up by {:.2f} m it lies {:.2f} m off held-back points, and bent to the others "
                    "{:.2f} m; a grid without it {:.2f} m, a plane {:.2f} m",
                    shift_m, *report.dem_error_m, bent.error_m, report.grid_error_m, report.plane_error_m));
  }
  const std::string without_model =
      report.dem_error_m
          ? fmt::format("; the elevation model does not fit them ({:.2f} m)", *report.dem_error_m)
          : "";
  if (report.grid_error_m > kGridMustBeBetter * report.plane_error_m) {
    return finish(GroundSurface::Plane(mean_z_m), "plane",
                  fmt::format("a grid explains held-back points no better ({:.2f} m) than a plane ({:.2f} m)",
                              report.grid_error_m, report.plane_error_m) +
                      without_model);
  }
  return finish(AsSurface(FitMembrane(points, cell_m, shape, margin_m, grid.stiffness), mean_z_m), "grid",
                fmt::format("held-back points lie {:.2f} m off the grid and {:.2f} m off a plane",
                            report.grid_error_m, report.plane_error_m) +
                    without_model);
}

}  // namespace skyquilt::ground
