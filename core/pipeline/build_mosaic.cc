#include "core/pipeline/build_mosaic.h"

#include <sys/resource.h>

#include <algorithm>
#include <utility>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"
#include "core/pipeline/append_photos.h"
#include "core/pipeline/memory_budget.h"
#include "core/pipeline/place_flight.h"
#include "core/pipeline/plan_map.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/report/judge_map.h"
#include "core/pipeline/stage_runner.h"
#include "core/render/blocks/measure_seams.h"
#include "core/render/blocks/render_block.h"
#include "core/render/blocks/weigh_block.h"
#include "core/render/render_tiles.h"
#include "core/render/seams/seam_shift.h"

namespace skyquilt::pipeline {
namespace {

std::int64_t PeakMemoryBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

void DescribePhotos(const alignment::AlignedFlight& flight, MosaicReport& report) {
  std::vector<const flight::Photo*> photos;
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    ++(photo.placement == alignment::Placement::kAligned ? report.photos_aligned : report.photos_pose_only);
    photos.push_back(&photo.photo);
  }
  report.captured = CaptureSpanOf(photos);
  report.left_out_photos = flight.left_out;
  std::sort(report.left_out_photos.begin(), report.left_out_photos.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  report.photos_left_out = static_cast<int>(report.left_out_photos.size());
  report.photos_total = static_cast<int>(flight.photos.size()) + report.photos_left_out;
}

// Tiles so large that not one fits in the memory, or that nobody decodes, stay coarser.
void WarnOfCoarserPixels(const render::MosaicPlan& plan, const alignment::AlignedFlight& flight,
                         const std::optional<double>& gsd_m, MosaicReport& report) {
  const double wanted_m = gsd_m.value_or(plan.gsd_m), pixel_m = render::OutputPixelM(plan, flight);
  if (pixel_m <= 1.001 * wanted_m) return;
  flight::Remark coarser{flight::RemarkCode::kCoarserPixels,
                         {{"pixel_mm", 1e3 * pixel_m}, {"wanted_mm", 1e3 * wanted_m}}};
  if (plan.tile_size_px == image::kMaxPictureSidePx) {
    coarser.code = flight::RemarkCode::kFinestPixels;
    coarser.values.emplace("side_px", plan.tile_size_px);
  }
  report.warnings.push_back(std::move(coarser));
}

// What the report says of the finished map.
void DescribeMap(const FlightFacts& facts, const PlannedMap& planned,
                 const std::optional<MapSurface>& surface, const render::SeamShift& seam_shift,
                 const render::RenderReport& rendered, MosaicReport& report) {
  const alignment::AlignedFlight& aligned = facts.flight;
  const render::MosaicPlan& plan = planned.plan;
  DescribePhotos(aligned, report);
  report.seam_shift = seam_shift;
  report.warnings = aligned.warnings;
  if (GroundAsked(facts) == MapGround::kAuto) report.ground_choice = facts.ground_choice;
  if (surface) TellSurface(surface->cell_m, surface->measured_share, report);
  WarnOfCoarserPixels(plan, aligned, planned.gsd_m, report);
  report.align_report = facts.align_report;
  report.ground_report = facts.ground_report;
  report.height_rule = facts.height_rule;
  report.poses_report = facts.poses_report;
  report.is_placed = facts.is_placed;
  report.gsd_m = FinestShownM(plan, planned.gsd_m, aligned);
  const JudgedMap judged{.flight = aligned,
                         .poses = facts.poses_report,
                         .alignment = facts.align_report ? &*facts.align_report : nullptr,
                         .seams = seam_shift,
                         .gsd_m = report.gsd_m,
                         .photo_gsd_m = plan.gsd_m,
                         .is_placed = facts.is_placed,
                         .is_by_images = facts.is_by_images,
                         .is_by_hand = facts.is_by_hand};
  report.quality = JudgeMap(judged);
  for (flight::Remark& remark : RemarksOnPositions(judged)) report.warnings.push_back(std::move(remark));
  report.area_m2 = rendered.covered_m2;
  report.bounds = geo::LatLonBoundsFromMerc(rendered.covered_in_merc).OnEarth();
  report.min_zoom = plan.min_zoom;
  report.max_zoom = plan.base_zoom;
  report.tile_size_px = plan.tile_size_px;
  report.tile_count = rendered.tiles;
  report.blocks = rendered.blocks;
  report.blocks_kept = rendered.blocks_kept;
  report.peak_memory_bytes = PeakMemoryBytes();
}

}  // namespace

Result<BuiltMosaic> BuildMosaic(const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                const flight::PhotoSource& photo_source, pyramid::TileSink& sink,
                                Progress& progress, const geo::DemSource* dem, pyramid::MapMemory* memory,
                                FoundFiles found) {
  SKYQUILT_TRY(options.Validate());
  MosaicReport report;
  report.title = options.title;
  StageRunner stages(report, progress);

  SKYQUILT_TRY_ASSIGN(auto placed, PlaceFlight(files, options, photo_source, dem, memory, stages, progress,
                                               std::move(found)));
  FlightFacts& facts = placed.facts;
  const alignment::AlignedFlight& aligned = facts.flight;
  const ground::GroundSurface& ground = facts.ground;
  // A killed run goes on from here; the appearance of the map is added before it is rendered.
  if (memory != nullptr) {
    SKYQUILT_TRY(memory->Remember(WriteFacts(facts)));
  }

  std::optional<MapSurface> surface;
  if (StandsUpright(facts)) {
    SKYQUILT_TRY_ASSIGN(surface, stages.Run("surface", [&] {
      const std::optional<double> gsd_m = options.gsd_m ? options.gsd_m : placed.gsd_m;
      return MatchMapSurface(facts, gsd_m, options, photo_source, progress);
    }));
  }
  const ground::GroundSurface& shown_ground = surface ? surface->ground : ground;
  SKYQUILT_TRY_ASSIGN(PlannedMap planned, PlanMap(facts, placed.gsd_m, options, stages, {},
                                                  surface ? &surface->ground : nullptr));
  const render::MosaicPlan& plan = planned.plan;
  const render::SeamMap& seams = planned.seams;
  const RenderBudget budget = BudgetFor(options, plan);
  const std::size_t finished = facts.appearance ? facts.appearance->exposure.photos.size() : 0;
  // As of another appearance: a killed run that goes on measures all of them.
  const std::optional<render::SeamShift> seams_before = std::exchange(facts.seams, std::nullopt);
  if (memory != nullptr) {
    facts.appearance = planned.Appearance();
    SKYQUILT_TRY(memory->Remember(WriteFacts(facts)));
  }
  render::PhotoCache cache(photo_source, budget.cache_bytes);
  render::MeasureSeamsOptions measure;
  measure.threads = options.threads;
  measure.output_pixel_m = render::OutputPixelM(plan, aligned);
  // Where only some photos are new, and the seams of the others are known, those beside the new ones are
  // measured, from a cache of their own.
  std::optional<alignment::AlignedFlight> around;
  if (finished != 0 && finished != aligned.photos.size() && seams_before && render::TellOfMap(*seams_before))
    around = AddedAndAround(aligned, finished);
  std::optional<render::SeamPatches> patches;
  auto rendered = stages.Run("render", [&]() -> Result<render::RenderReport> {
    const std::vector<image::PixelBox> shown = render::ShownRegions(aligned, shown_ground, seams);
    for (std::size_t i = 0; i < shown.size(); ++i) cache.Expect(i, shown[i]);
    patches.emplace(around ? *around : aligned, shown_ground, measure);
    if (!around) patches->WatchFor(cache);
    const render::RenderContext context{aligned, shown_ground, planned.exposure, seams, plan, cache};
    const render::RenderOptions render_options{budget.threads, {options.encoding, options.jpeg_quality}};
    if (memory == nullptr) return render::RenderTiles(context, render_options, sink, progress);
    const render::RenderMemory render_memory{*memory, placed.digests};
    return render::RenderTiles(context, render_options, sink, progress, &render_memory);
  });
  if (!rendered) return rendered.error();
  if (rendered->base_tiles == 0) {
    return flight::Because(ErrorCode::kUnprocessable, facts.boundary
                                                          ? flight::RemarkCode::kFailNoGroundInBoundary
                                                          : flight::RemarkCode::kFailNoGround);
  }

  const render::SeamShift seam_shift = stages.Run("measure", [&] {
    if (!around) return patches->Measure(cache, progress);
    render::PhotoCache part_cache(photo_source, budget.cache_bytes / 2);
    patches->WatchFor(part_cache);
    return patches->Measure(part_cache, progress);
  });
  facts.seams = around ? render::WorseOf(*seams_before, seam_shift) : seam_shift;
  if (memory != nullptr) {
    SKYQUILT_TRY(memory->Remember(WriteFacts(facts)));
  }

  DescribeMap(facts, planned, surface, *facts.seams, *rendered, report);
  std::optional<BandedMap> banded = BandedMapOf(facts, std::move(placed.captures), options);
  BuiltMosaic built{aligned,
                    ground,
                    std::move(planned.plan),
                    std::move(planned.seams),
                    std::move(surface),
                    std::move(banded),
                    std::move(report)};
  TellPhotos(built.report.quality, built.flight);
  return built;
}

}  // namespace skyquilt::pipeline
