#include "core/pipeline/move_to_control.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "core/alignment/adjustment/tie_to_control.h"
#include "core/alignment/align_report.h"
#include "core/alignment/matching/verified_pair.h"
#include "core/base/median.h"
#include "core/geo/bounds.h"
#include "core/geo/lat_lon.h"
#include "core/pipeline/control_points.h"

namespace skyquilt::pipeline {
namespace {

using Json = nlohmann::ordered_json;

using alignment::AlignedPhoto;
using alignment::GroundSimilarity;
using Complex = std::complex<double>;

constexpr std::size_t kMaxPoints = 4;
constexpr double kTurningSpread = 0.2;  // of the flight's extent: points nearer together tell no turn
constexpr double kMaxStretch = 0.05;
constexpr double kMaxTurnRad = 0.05;
constexpr double kSurveyM = 0.02;
constexpr double kMaxResidualGsds = 4.0;  // of points after the move
constexpr double kNoMoveGsds = 0.02;      // less is not worth another map

struct Tied {
  Complex now, surveyed;
  std::size_t report = 0;  // number of the point
};

Complex EastNorth(const Eigen::Vector3d& point_in_enu) { return {point_in_enu.x(), point_in_enu.y()}; }

std::vector<Tied> TiePoints(const FlightFacts& known, const std::vector<alignment::ControlPoint>& control,
                            const std::vector<alignment::View>& views,
                            std::vector<alignment::ControlReport>& reports) {
  std::vector<std::string> names;
  std::vector<char> is_tied;
  for (const AlignedPhoto& photo : known.flight.photos) {
    names.push_back(photo.photo.name);
    is_tied.push_back(photo.placement == alignment::Placement::kAligned ? 1 : 0);
  }
  const alignment::MarkedPhotos photos(names, views, is_tied);
  std::vector<Tied> tied;
  for (const alignment::ControlPoint& point : control) {
    const std::optional<alignment::Track> track = photos.TrackOf(point, reports.emplace_back());
    if (!track) continue;
    const Eigen::Vector3d surveyed = known.flight.frame.EnuAtHeight(point.position, track->point_in_enu.z());
    tied.push_back({EastNorth(track->point_in_enu), EastNorth(surveyed), reports.size() - 1});
  }
  return tied;
}

double ExtentM(const FlightFacts& known) {
  geo::Bounds2 bounds;
  for (const AlignedPhoto& photo : known.flight.photos) {
    bounds.Include(photo.cam_from_enu.TargetOriginInSource().head<2>());
  }
  return bounds.IsEmpty() ? 0.0 : std::hypot(bounds.Width(), bounds.Height());
}

GroundSimilarity FitMove(const std::vector<Tied>& tied, double extent_m) {
  std::vector<std::pair<Complex, Complex>> places;
  double spread_m = 0.0;
  Complex shift(0.0, 0.0);
  for (const Tied& one : tied) {
    places.emplace_back(one.now, one.surveyed);
    spread_m = std::max(spread_m, std::abs(one.now - tied.front().now));
    shift += (one.surveyed - one.now) / static_cast<double>(tied.size());
  }
  if (spread_m < kTurningSpread * extent_m || spread_m == 0.0) return {{1.0, 0.0}, shift};
  return alignment::FitSimilarity(places);
}

// About the vertical through the origin, and stretched about the mean height of the ground.
void Move(const GroundSimilarity& move, double ground_z_m, AlignedPhoto& photo) {
  const double stretch = std::abs(move.turn_and_scale);
  const Eigen::Vector3d center = photo.cam_from_enu.TargetOriginInSource();
  const Complex place = move * EastNorth(center);
  const Eigen::AngleAxisd turn_back(-std::arg(move.turn_and_scale), Eigen::Vector3d::UnitZ());
  photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
      (photo.cam_from_enu.rotation * Eigen::Quaterniond(turn_back)).normalized(),
      {place.real(), place.imag(), ground_z_m + stretch * (center.z() - ground_z_m)});
  photo.height_above_ground_m *= stretch;
  Eigen::Vector3d& shift_m = photo.readout_motion.shift_in_enu_m;
  shift_m = stretch * (turn_back.inverse() * shift_m);
}

ground::GroundSurface Moved(const ground::GroundSurface& ground, const GroundSimilarity& move) {
  if (ground.IsPlane()) return ground;
  const double mean_z_m = ground.MeanHeight();
  const double width_m = ground.CellSize() * (ground.Columns() - 1);
  const double height_m = ground.CellSize() * (ground.Rows() - 1);
  geo::Bounds2 bounds;
  for (const auto& [x, y] : {std::pair(0.0, 0.0), {width_m, 0.0}, {0.0, height_m}, {width_m, height_m}}) {
    const Complex corner = move * Complex(ground.SouthWest().x() + x, ground.SouthWest().y() + y);
    bounds.Include(Eigen::Vector2d(corner.real(), corner.imag()));
  }
  const int columns = static_cast<int>(std::ceil(bounds.Width() / ground.CellSize())) + 1;
  const int rows = static_cast<int>(std::ceil(bounds.Height() / ground.CellSize())) + 1;
  const GroundSimilarity back = move.Inverse();
  const double stretch = std::abs(move.turn_and_scale);
  std::vector<float> heights_m;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Complex was = back * Complex(bounds.min.x() + column * ground.CellSize(),
                                         bounds.min.y() + row * ground.CellSize());
      heights_m.push_back(
          static_cast<float>(mean_z_m + stretch * (ground.HeightAt({was.real(), was.imag()}) - mean_z_m)));
    }
  }
  return ground::GroundSurface::Grid(bounds.min, ground.CellSize(), columns, rows, std::move(heights_m),
                                     mean_z_m);
}

std::string WithControl(const std::string& known_json, const std::vector<alignment::ControlReport>& control,
                        Complex shift_of_middle) {
  if (known_json.empty()) return known_json;
  alignment::AlignReport of_control;
  of_control.control = control;
  of_control.position_bias_m = {shift_of_middle.real(), shift_of_middle.imag(), 0.0};
  const Json part = Json::parse(alignment::AlignReportJson(of_control));
  Json merged = Json::parse(known_json);
  for (const char* field : {"ground_control", "position_bias_m"}) merged[field] = part.at(field);
  return merged.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::optional<FlightFacts> MoveToControl(const FlightFacts& known,
                                         const std::vector<flight::GcpList>& lists) {
  const std::vector<alignment::ControlPoint> control = ControlPointsOf(lists);
  if (control.empty() || control.size() > kMaxPoints || known.flight.photos.empty()) return std::nullopt;
  std::vector<alignment::View> views;
  std::vector<double> gsds_m;
  for (const AlignedPhoto& photo : known.flight.photos) {
    views.push_back(
        {photo.intrinsics, photo.cam_from_enu, photo.height_above_ground_m, photo.readout_motion});
    gsds_m.push_back(views.back().GsdM());
  }
  const double gsd_m = Median(std::move(gsds_m));
  std::vector<alignment::ControlReport> reports;
  const std::vector<Tied> tied = TiePoints(known, control, views, reports);
  FlightFacts moved = known;
  GroundSimilarity move;
  if (!tied.empty()) move = FitMove(tied, ExtentM(known));
  if (std::abs(std::abs(move.turn_and_scale) - 1.0) > kMaxStretch ||
      std::abs(std::arg(move.turn_and_scale)) > kMaxTurnRad) {
    return std::nullopt;
  }
  double square_m2 = 0.0;
  for (const Tied& one : tied) {
    const Complex residual = move * one.now - one.surveyed;
    if (std::abs(residual) > kSurveyM + kMaxResidualGsds * gsd_m) return std::nullopt;
    square_m2 += std::norm(residual);
    alignment::ControlReport& told = reports[one.report];
    told.is_used = true;
    told.miss_east_m = residual.real();
    told.miss_north_m = residual.imag();
    told.residual_px = std::abs(residual) / gsd_m;
  }
  for (const alignment::ControlReport& point : reports) {
    if (point.is_used) continue;
    moved.flight.warnings.push_back(
        fmt::format("Ground control point {} is not used: it {}.", point.name, point.reason));
  }
  const Complex middle =
      EastNorth(known.flight.photos[known.flight.photos.size() / 2].cam_from_enu.TargetOriginInSource());
  const Complex shift = move * middle - middle;
  moved.alignment_json = WithControl(known.alignment_json, reports, shift);
  const double max_moved_m = std::abs(shift) + std::abs(move.turn_and_scale - 1.0) * ExtentM(known);
  if (max_moved_m < kNoMoveGsds * gsd_m) return moved;

  moved.appearance.reset();
  moved.ground = Moved(known.ground, move);
  for (AlignedPhoto& photo : moved.flight.photos) Move(move, known.ground.MeanHeight(), photo);
  // A single point has nothing to be checked against: the flight is better placed, but no more certain.
  if (tied.size() > 1) {
    const double residual_m = std::max(kSurveyM, std::sqrt(square_m2 / static_cast<double>(tied.size())));
    for (AlignedPhoto& photo : moved.flight.photos) {
      if (photo.placement == alignment::Placement::kAligned) photo.error_radius_m = residual_m;
    }
  }
  moved.flight.warnings.push_back(fmt::format(
      "The finished flight was moved as a whole to {} ground control point{}: {:.2f} m east, {:.2f} m north, "
      "turned by {:.2f} degrees, {:.2f} % larger.",
      tied.size(), tied.size() == 1 ? "" : "s", shift.real(), shift.imag(),
      geo::RadToDeg(std::arg(move.turn_and_scale)), 100.0 * (std::abs(move.turn_and_scale) - 1.0)));
  return moved;
}

}  // namespace skyquilt::pipeline
