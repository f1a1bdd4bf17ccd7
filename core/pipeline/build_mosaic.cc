#include "core/pipeline/build_mosaic.h"

#include <sys/resource.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "core/alignment/align_by_features.h"
#include "core/alignment/align_by_pose.h"
#include "core/alignment/align_directly.h"
#include "core/alignment/align_flight.h"
#include "core/base/scoped_timer.h"
#include "core/geo/web_mercator.h"
#include "core/ground/dem_grid.h"
#include "core/ground/ground_surface.h"
#include "core/ground/model_ground.h"
#include "core/pipeline/check_photos.h"
#include "core/pipeline/control_points.h"
#include "core/poses/estimate_poses.h"
#include "core/render/estimate_exposure.h"
#include "core/render/measure_seams.h"
#include "core/render/plan_mosaic.h"
#include "core/render/render_tiles.h"
#include "core/render/seam_map.h"

namespace skyquilt::pipeline {
namespace {

// Runs one stage: says so, times it, and stops between stages when the user asked to.
class StageRunner {
 public:
  StageRunner(MosaicReport& report, Progress& progress) : report_(report), progress_(progress) {}

  template <typename Stage>
  auto Run(const char* name, Stage&& stage) {
    progress_.BeginStage(name);
    report_.timings.push_back({name, 0.0, 0.0});
    ScopedTimer timer(report_.timings.back().wall_s);
    ScopedCpuTimer cpu_timer(report_.timings.back().cpu_s);
    return stage();
  }

 private:
  MosaicReport& report_;
  Progress& progress_;
};

std::int64_t PeakMemoryBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

std::array<double, 4> DegreeBounds(const geo::Bounds2& bounds_in_merc) {
  const geo::LatLon south_west = geo::LatLonFromMerc(bounds_in_merc.min);
  const geo::LatLon north_east = geo::LatLonFromMerc(bounds_in_merc.max);
  return {south_west.lon_deg, south_west.lat_deg, north_east.lon_deg, north_east.lat_deg};
}

// The thumbnails in the order of the placed photos.
std::vector<render::Thumbnail> ThumbnailsOf(const alignment::AlignedFlight& flight,
                                            const std::vector<render::Thumbnail>& thumbnails) {
  std::map<std::string, const render::Thumbnail*> by_name;
  for (const render::Thumbnail& thumbnail : thumbnails) by_name[thumbnail.photo_name] = &thumbnail;
  std::vector<render::Thumbnail> ordered;
  ordered.reserve(flight.photos.size());
  for (const alignment::AlignedPhoto& photo : flight.photos) ordered.push_back(*by_name.at(photo.photo.name));
  return ordered;
}

void DescribePhotos(const alignment::AlignedFlight& flight, MosaicReport& report) {
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    ++(photo.placement == alignment::Placement::kAligned ? report.photos_aligned : report.photos_pose_only);
  }
  report.left_out_photos = flight.left_out;
  std::sort(report.left_out_photos.begin(), report.left_out_photos.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  report.photos_left_out = static_cast<int>(report.left_out_photos.size());
  report.photos_total = static_cast<int>(flight.photos.size()) + report.photos_left_out;
}

}  // namespace

Result<BuiltMosaic> BuildMosaic(const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                const PhotoSource& photo_source, TileSink& sink, Progress& progress,
                                const DemSource* dem) {
  if (auto valid = options.Validate(); !valid) return valid.error();
  MosaicReport report;
  report.title = options.title;
  StageRunner stages(report, progress);

  auto flight = stages.Run("read", [&] { return flight::ReadFlight(files, {options.threads}, progress); });
  if (!flight) return flight.error();

  auto checked = stages.Run("check", [&] {
    return CheckPhotos(*std::move(flight), photo_source, options.threads, progress);
  });
  if (!checked) return checked.error();

  auto posed = stages.Run("pose", [&] { return poses::EstimatePoses(checked->flight, {options.origin, options.landed_at_start, dem}); });
  if (!posed) return posed.error();

  alignment::AlignReport align_report;
  auto aligned = stages.Run("align", [&]() -> Result<alignment::AlignedFlight> {
    alignment::AlignOptions align_options;
    align_options.threads = options.threads;
    align_options.control = ControlPointsOf(checked->flight.gcp_lists);
    switch (options.method) {
      case AlignMethod::kImu:
        return alignment::AlignByPoseOnly(*posed);
      case AlignMethod::kFeatures:
        return alignment::AlignByFeatures(*posed, photo_source, align_options, align_report, progress);
      case AlignMethod::kDirect:
        return alignment::AlignDirectly(*posed, photo_source, align_options, align_report, progress);
      case AlignMethod::kAuto:
        break;
    }
    return alignment::AlignFlight(*posed, photo_source, align_options, align_report, progress);
  });
  if (!aligned) return aligned.error();

  ground::ModelGroundReport ground_report;
  const ground::GroundSurface ground =
      stages.Run("ground", [&] {
        std::optional<ground::ElevationModel> model;
        if (dem != nullptr && posed->dem_zero_m) model = {dem, *posed->dem_zero_m};
        return ground::ModelGround(*aligned, ground_report, model);
      });

  auto plan = stages.Run("plan", [&] { return render::PlanMosaic(*aligned, ground, {options.gsd_m, options.feather_m}); });
  if (!plan) return plan.error();

  const std::vector<render::Thumbnail> thumbnails = ThumbnailsOf(*aligned, checked->thumbnails);
  const render::ExposureModel exposure =
      stages.Run("expose", [&] { return render::EstimateExposure(*aligned, ground, thumbnails); });
  const render::SeamMap seams = stages.Run("seam", [&] {
    return render::BuildSeamMap(*aligned, ground, *plan, exposure, thumbnails, {.threads = options.threads});
  });
  render::PhotoCache cache(photo_source, options.PhotoCacheBytes());
  auto rendered = stages.Run("render", [&] {
    const render::RenderContext context{*aligned, ground, exposure, seams, *plan, cache};
    const render::RenderOptions render_options{
        options.threads, {options.encoding == TileEncoding::kWebp, options.jpeg_quality}};
    return render::RenderTiles(context, render_options, sink, progress);
  });
  if (!rendered) return rendered.error();
  if (rendered->base_tiles == 0) {
    return Error{ErrorCode::kUnprocessable, "the photos were placed, but none of them shows any ground", ""};
  }

  const render::SeamShift seam_shift = stages.Run("measure", [&] {
    render::MeasureSeamsOptions measure;
    measure.threads = options.threads;
    measure.output_pixel_m = render::OutputPixelM(*plan, *aligned);
    return render::MeasureSeams(*aligned, ground, cache, measure, progress);
  });

  DescribePhotos(*aligned, report);
  report.seams_json = render::SeamShiftJson(seam_shift);
  report.warnings = aligned->warnings;
  if (options.method != AlignMethod::kImu) report.alignment_json = alignment::AlignReportJson(align_report);
  report.ground_json = ground::ModelGroundReportJson(ground_report);
  report.height_rule = posed->report.height_rule;
  report.poses_json = poses::PoseReportJson(posed->report);
  report.is_placed = posed->is_placed;
  report.gsd_m = plan->gsd_m;
  const double lat_deg = aligned->frame.origin().lat_deg;
  const double ground_per_merc = geo::GroundMetresPerMercMetre(lat_deg);
  report.area_m2 = rendered->covered_merc_m2 * ground_per_merc * ground_per_merc;
  report.bounds = DegreeBounds(rendered->covered_in_merc);
  report.min_zoom = plan->min_zoom;
  report.max_zoom = plan->base_zoom;
  report.tile_size_px = plan->tile_size_px;
  report.tile_count = rendered->tiles;
  report.peak_memory_bytes = PeakMemoryBytes();
  return BuiltMosaic{*std::move(aligned), ground, std::move(report)};
}

}  // namespace skyquilt::pipeline
