#include "core/pipeline/inspect_flight.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/alignment/align_by_pose.h"
#include "core/bands/captures.h"
#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/base/text/printable.h"
#include "core/camera/footprint.h"
#include "core/flight/remarks/because.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/ground/ground_surface.h"
#include "core/pipeline/memory_budget.h"
#include "core/pipeline/report/judge_map.h"
#include "core/pipeline/report/mosaic_report.h"
#include "core/poses/estimate_poses.h"
#include "core/poses/lists/compare_sources.h"
#include "core/render/plan_mosaic.h"

namespace skyquilt::pipeline {
namespace {

using flight::RemarkCode;

// CPU seconds, measured with tests/bench on two cores of 2020s laptop class: an order of magnitude.
constexpr double kAlignSecondsPerPhoto = 0.45;
constexpr double kDecodeSecondsPerMegapixel = 0.012;
constexpr double kRenderSecondsPerMegapixel = 0.10;

// Share of a's footprint that b sees too, by a grid of points.
double SharedGround(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b) {
  const geo::Bounds2 bounds = camera::BoundsOf(a);
  int in_a = 0;
  int in_both = 0;
  constexpr int kSteps = 24;
  for (int row = 0; row < kSteps; ++row) {
    for (int column = 0; column < kSteps; ++column) {
      const Eigen::Vector2d point{bounds.min.x() + (column + 0.5) / kSteps * bounds.Width(),
                                  bounds.min.y() + (row + 0.5) / kSteps * bounds.Height()};
      if (!camera::PolygonContains(a, point)) continue;
      ++in_a;
      in_both += camera::PolygonContains(b, point) ? 1 : 0;
    }
  }
  return in_a == 0 ? 0.0 : static_cast<double>(in_both) / in_a;
}

void DescribeCoverage(const alignment::AlignedFlight& flight, FlightVerdict& verdict) {
  std::vector<std::vector<Eigen::Vector2d>> footprints;
  double sum_m2 = 0.0;
  double boxes_m2 = 0.0;  // what the cells of each are looked for in
  for (const auto& photo : flight.photos) {
    footprints.push_back(
        camera::GroundFootprint(photo.intrinsics, photo.cam_from_enu, flight.ground_z_in_enu_m));
    if (footprints.back().empty()) continue;
    sum_m2 += camera::AreaM2(footprints.back());
    const geo::Bounds2 bounds = camera::BoundsOf(footprints.back());
    boxes_m2 += bounds.Width() * bounds.Height();
  }
  std::vector<double> overlaps;
  for (std::size_t i = 0; i + 1 < footprints.size(); ++i) {
    if (!footprints[i].empty() && !footprints[i + 1].empty())
      overlaps.push_back(SharedGround(footprints[i], footprints[i + 1]));
  }
  verdict.forward_overlap = MedianIfAny(std::move(overlaps));
  // Cells of a fiftieth of a photo: the union of the footprints. Larger where there are very many, or where
  // footprints are so thin that their boxes are nearly empty.
  constexpr double kMaxCells = 2e6;
  constexpr double kMaxPasses = 10e6;
  const double cell_m = std::max(
      {0.5, std::sqrt(sum_m2 / static_cast<double>(std::max<std::size_t>(1, footprints.size()))) / 50.0,
       std::sqrt(sum_m2 / kMaxCells), std::sqrt(boxes_m2 / kMaxPasses)});
  std::set<std::pair<long, long>> cells;
  for (const auto& polygon : footprints) {
    if (polygon.empty()) continue;
    const geo::Bounds2 bounds = camera::BoundsOf(polygon);
    if (!std::isfinite(bounds.Width() + bounds.Height())) continue;
    for (long row = std::lround(bounds.min.y() / cell_m); row * cell_m <= bounds.max.y(); ++row) {
      for (long column = std::lround(bounds.min.x() / cell_m); column * cell_m <= bounds.max.x(); ++column) {
        if (camera::PolygonContains(polygon, {(column + 0.5) * cell_m, (row + 0.5) * cell_m}))
          cells.emplace(row, column);
      }
    }
  }
  verdict.area_m2 = static_cast<double>(cells.size()) * cell_m * cell_m;
  verdict.mean_photos_per_point = verdict.area_m2 > 0.0 ? sum_m2 / verdict.area_m2 : 0.0;
}

// Photos that only what they show may place count among those that hang on the others' positions.
MapQuality QualityByRecords(const poses::PosedFlight& posed, alignment::AlignedFlight placed) {
  for (const flight::Photo& photo : posed.unplaced) {
    alignment::AlignedPhoto one;
    one.photo = photo;
    one.cam_from_enu = placed.photos.front().cam_from_enu;
    placed.photos.push_back(std::move(one));
  }
  std::erase_if(placed.left_out, [&](const flight::LeftOutPhoto& left_out) {
    return std::any_of(posed.unplaced.begin(), posed.unplaced.end(),
                       [&](const flight::Photo& photo) { return photo.name == left_out.name; });
  });
  return JudgeMap({.flight = placed,
                   .poses = posed.report,
                   .is_placed = posed.is_placed,
                   .is_by_images = !posed.unplaced.empty(),
                   .is_forecast = true});
}

// Where the angles of a photo come from; those of a log's airframe bear its name.
std::string AngleSourceOf(const poses::PosedPhoto& photo, const flight::Flight& flight) {
  using poses::AttitudeOrigin;
  const auto& own = photo.photo.attitude;
  if (photo.attitude_origin == AttitudeOrigin::kCourse) return "none";
  if (photo.attitude_origin == AttitudeOrigin::kDirection) return "heading from GPSImgDirection";
  const bool is_own = photo.attitude_origin != AttitudeOrigin::kSmoothed ||
                      (own && own->kind == flight::AttitudeKind::kGimbal);
  if (is_own && own) return own->source;
  const auto log = std::find_if(flight.logs.begin(), flight.logs.end(), [](const flight::FlightLog& one) {
    return !one.attitude.empty() || !one.imu.empty();
  });
  return log == flight.logs.end() ? "log" : log->file_name;
}

// What the map will stand on: after lists and logs, which may take the place of what photos record.
void CountSources(const poses::PosedFlight& posed, const flight::Flight& flight, FlightVerdict& verdict) {
  verdict.position_sources.clear();
  verdict.attitude_sources.clear();
  for (const poses::PosedPhoto& photo : posed.photos) {
    ++verdict.position_sources[photo.position_source.empty() ? "none" : photo.position_source];
    ++verdict.attitude_sources[AngleSourceOf(photo, flight)];
  }
  for (const flight::Photo& photo : posed.unplaced) {
    ++verdict.position_sources[photo.position ? photo.position->source : "none"];
    ++verdict.attitude_sources[photo.attitude ? photo.attitude->source : "none"];
  }
}

// What the photos record; all their megapixels.
double DescribePictures(const flight::Flight& flight, FlightVerdict& verdict) {
  double input_megapixels = 0.0;
  std::vector<const flight::Photo*> photos;
  for (const flight::Photo& photo : flight.photos) {
    const auto& lens = photo.intrinsics;
    ++verdict.cameras[fmt::format("{}, {} x {} px, focal {:.0f} px ({})", flight::MakeAndModel(photo),
                                  lens.width_px, lens.height_px, lens.MeanFocalPx(),
                                  flight::FocalSourceName(photo.focal_source))];
    ++verdict.position_sources[photo.position ? photo.position->source : "none"];
    ++verdict.attitude_sources[photo.attitude ? photo.attitude->source : "none"];
    input_megapixels += 1e-6 * lens.width_px * lens.height_px;
    photos.push_back(&photo);
  }
  if (const auto captured = CaptureSpanOf(photos)) {
    verdict.first_capture = captured->first;
    verdict.last_capture = captured->last;
  }
  return input_megapixels;
}

// What the map will be, and what it will cost.
void Foretell(const MosaicOptions& options, const alignment::AlignedFlight& placed,
              const render::MosaicPlan& plan, double input_megapixels, FlightVerdict& verdict) {
  verdict.gsd_m = plan.gsd_m;
  if (const Result<void> sane = options.CheckGsd(plan.gsd_m); !sane)
    verdict.warnings.push_back(flight::WhyOf(sane.error()));
  verdict.max_zoom = plan.base_zoom;
  verdict.tile_size_px = plan.tile_size_px;
  const double pixel_m = geo::PixelSizeInMercM(plan.base_zoom, plan.tile_size_px) *
                         geo::GroundMetresPerMercMetre(placed.frame.origin().lat_deg);
  verdict.output_megapixels = 1e-6 * verdict.area_m2 / (pixel_m * pixel_m);
  const int cores = ThreadCount(options.threads);
  verdict.expected_seconds =
      (kAlignSecondsPerPhoto * verdict.photos_placeable + kDecodeSecondsPerMegapixel * input_megapixels +
       kRenderSecondsPerMegapixel * verdict.output_megapixels) /
      std::min(cores, 8);
  constexpr double kMib = 1 << 20;
  FlightSize size;
  size.photos = static_cast<std::int64_t>(placed.photos.size());
  std::vector<std::int64_t> pixels;
  for (const auto& photo : placed.photos)
    pixels.push_back(std::int64_t{photo.intrinsics.width_px} * photo.intrinsics.height_px);
  size.largest_pixels = *std::max_element(pixels.begin(), pixels.end());
  size.photo_pixels = Median(std::move(pixels));
  verdict.expected_memory_mib = static_cast<double>(ForetoldBytes(options, plan, size)) / kMib;
}

void AddAdvice(FlightVerdict& verdict) {
  if (verdict.photos_placeable >= 3 && verdict.forward_overlap && *verdict.forward_overlap < 0.4) {
    verdict.warnings.push_back(
        {RemarkCode::kLittleOverlap, {{"overlap_percent", 100.0 * *verdict.forward_overlap}}});
  }
}

}  // namespace

std::optional<MapStatus> ForeseenStatus(const FlightVerdict& verdict) {
  const MapStatus status = verdict.by_records.status;
  const bool becomes_map = verdict.photos_placeable + verdict.photos_by_images > 0;
  const bool is_decided = status == MapStatus::kDoubtful || status == MapStatus::kUnplaced;
  return becomes_map && is_decided && verdict.gcp_lists.empty() ? std::optional(status) : std::nullopt;
}

Result<FlightVerdict> InspectFlight(const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                    Progress& progress, const geo::DemSource* dem) {
  auto flight = flight::ReadFlight(files, options.threads, progress);
  if (!flight) return flight.error();
  FlightVerdict verdict;
  const double input_megapixels = DescribePictures(*flight, verdict);
  // Of each capture of several bands one photo is placed.
  bands::SetBandsApart(*flight, options.threads);
  const Result<void> compared = poses::CompareSources(*flight);
  verdict.lists = flight->list_uses;
  verdict.photos_readable = static_cast<int>(flight->photos.size());
  for (const flight::FlightLog& log : flight->logs) verdict.logs.push_back(flight::DescribeLog(log));
  for (const flight::GcpList& list : flight->gcp_lists) {
    verdict.gcp_lists.push_back(fmt::format("{}: {}, {}", list.file_name,
                                            Counted(list.points.size(), "point"),
                                            Counted(list.sightings.size(), "sighting")));
  }
  verdict.elevation_models = flight->elevation_models;
  verdict.left_out = flight->left_out;
  verdict.warnings = flight->warnings;
  if (!compared) {
    verdict.warnings.push_back(flight::WhyOf(compared.error()));
    return verdict;
  }
  constexpr bool kKeepUnplaced = true;
  auto posed = poses::EstimatePoses(
      *flight, {options.origin, options.landed_at_start, dem, kKeepUnplaced, options.takeoff_height_amsl_m});
  if (!posed) {
    // A flight of films alone has its photos when the map is made.
    if (flight->films.empty() || !flight->photos.empty())
      verdict.warnings.push_back(flight::WhyOf(posed.error()));
    return verdict;
  }
  verdict.photos_by_images = static_cast<int>(posed->unplaced.size());
  CountSources(*posed, *flight, verdict);
  verdict.poses = posed->report;
  if (posed->photos.empty()) {
    verdict.warnings = posed->warnings;
    verdict.warnings.push_back(flight->gcp_lists.empty() ? RemarkCode::kAllByImages
                                                         : RemarkCode::kAllByImagesAndControl);
    return verdict;
  }
  const alignment::AlignedFlight placed = alignment::AlignByPoseOnly(*posed);
  verdict.photos_placeable = static_cast<int>(placed.photos.size());
  verdict.left_out = placed.left_out;
  verdict.warnings = placed.warnings;
  if (verdict.photos_by_images > 0)
    verdict.warnings.push_back({RemarkCode::kSomeByImages, {{"photos", verdict.photos_by_images}}});
  verdict.height_rule = posed->report.height_rule;
  verdict.lowest_m = placed.photos.front().height_above_ground_m;
  for (const auto& photo : placed.photos) {
    verdict.lowest_m = std::min(verdict.lowest_m, photo.height_above_ground_m);
    verdict.highest_m = std::max(verdict.highest_m, photo.height_above_ground_m);
  }
  verdict.by_records = QualityByRecords(*posed, placed);
  DescribeCoverage(placed, verdict);
  const auto plan =
      render::PlanMosaic(placed, ground::GroundSurface::Plane(placed.ground_z_in_enu_m), PlanWithin(options));
  if (!plan) {
    verdict.warnings.push_back(flight::WhyOf(plan.error()));
    return verdict;
  }
  Foretell(options, placed, *plan, input_megapixels, verdict);
  AddAdvice(verdict);
  return verdict;
}

}  // namespace skyquilt::pipeline
