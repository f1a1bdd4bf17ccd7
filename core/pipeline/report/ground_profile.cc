#include "core/pipeline/report/ground_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/geo/geodesic.h"

namespace skyquilt::pipeline {
namespace {

// A grid is bilinear between its nodes: half a cell misses none of its bends.
constexpr double kStepsPerCell = 2.0;
constexpr int kChunksToMeasure = 64;
constexpr double kMaxProfileLengthM = 100'000.0;

double LengthM(const geo::LatLon& from, const geo::LatLon& to, int chunks) {
  double length_m = 0.0;
  geo::LatLon before = from;
  for (int i = 1; i <= chunks; ++i) {
    const geo::LatLon next = geo::OnTheWay(from, to, static_cast<double>(i) / chunks);
    length_m += geo::MetresApart(before, next);
    before = next;
  }
  return length_m;
}

bool IsWithin(const geo::LatLonBounds& bounds, const geo::LatLon& position) {
  const bool is_lat = position.lat_deg >= bounds.south_deg && position.lat_deg <= bounds.north_deg;
  // Bounds across the antimeridian end beyond 180 degrees.
  const auto is_lon = [&](double lon_deg) {
    return lon_deg >= bounds.west_deg && lon_deg <= bounds.east_deg;
  };
  return is_lat && (is_lon(position.lon_deg) || is_lon(position.lon_deg + 360.0));
}

bool IsOnGrid(const LocatedMap& map, const geo::Wgs84& on_ground) {
  if (map.ground.IsPlane()) return true;
  const Eigen::Vector2d in_grid = map.frame.EnuFromWgs84(on_ground).head<2>() - map.ground.SouthWest();
  const Eigen::Vector2d size(map.ground.Columns() - 1, map.ground.Rows() - 1);
  return (in_grid.array() >= 0.0).all() && (in_grid.array() <= size.array() * map.ground.CellSize()).all();
}

ProfileSample SampleAt(const LocatedMap& map, const geo::LatLonBounds& bounds, const geo::LatLon& position,
                       double distance_m) {
  ProfileSample sample{distance_m, position, std::nullopt};
  if (!IsWithin(bounds, position)) return sample;
  const geo::Wgs84 on_ground = GroundAt(map, position);
  if (IsOnGrid(map, on_ground) && std::isfinite(on_ground.height_ellipsoid_m))
    sample.height_m = on_ground.height_ellipsoid_m;
  return sample;
}

// What goes up and down between two neighbours that both have a height.
void Sum(GroundProfile& profile) {
  const ProfileSample* before = nullptr;
  for (const ProfileSample& sample : profile.samples) {
    if (sample.height_m) {
      const double height_m = *sample.height_m;
      profile.lowest_m = std::min(profile.lowest_m.value_or(height_m), height_m);
      profile.highest_m = std::max(profile.highest_m.value_or(height_m), height_m);
      const double up_m = before != nullptr ? height_m - *before->height_m : 0.0;
      (up_m > 0.0 ? profile.climb_m : profile.descent_m) += std::abs(up_m);
    }
    before = sample.height_m ? &sample : nullptr;
  }
}

}  // namespace

Result<GroundProfile> ProfileGround(const LocatedMap& map, const geo::LatLonBounds& bounds,
                                    const std::vector<geo::LatLon>& line) {
  if (line.size() < 2 || line.size() > kMaxProfileCorners) {
    return Error{ErrorCode::kUnprocessable,
                 fmt::format("A line has 2 to {} positions, this one {}.", kMaxProfileCorners, line.size()),
                 ""};
  }
  std::vector<double> parts_m;
  double length_m = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    parts_m.push_back(LengthM(line[i - 1], line[i], kChunksToMeasure));
    length_m += parts_m.back();
  }
  if (!(length_m <= kMaxProfileLengthM)) {
    return Error{ErrorCode::kUnprocessable,
                 fmt::format("The line is {:.0f} km long; at most {:.0f} km are taken.", length_m / 1e3,
                             kMaxProfileLengthM / 1e3),
                 ""};
  }
  double step_m = length_m / static_cast<double>(kMaxProfileSamples);
  if (!map.ground.IsPlane()) step_m = std::max(step_m, map.ground.CellSize() / kStepsPerCell);
  GroundProfile profile;
  profile.samples.push_back(SampleAt(map, bounds, line.front(), 0.0));
  for (std::size_t i = 0; i < parts_m.size(); ++i) {
    const int steps = step_m > 0.0 ? std::max(1, static_cast<int>(std::ceil(parts_m[i] / step_m))) : 1;
    const double before_m = profile.length_m;
    for (int k = 1; k <= steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      profile.samples.push_back(
          SampleAt(map, bounds, geo::OnTheWay(line[i], line[i + 1], share), before_m + share * parts_m[i]));
    }
    profile.length_m += parts_m[i];
    profile.step_m = std::max(profile.step_m, parts_m[i] / steps);
  }
  Sum(profile);
  return profile;
}

}  // namespace skyquilt::pipeline
