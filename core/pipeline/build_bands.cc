#include "core/pipeline/build_bands.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <set>
#include <utility>

#include "core/base/try.h"
#include "core/geo/lat_lon.h"
#include "core/pipeline/memory_budget.h"
#include "core/render/bands/measure_targets.h"
#include "core/render/bands/register_bands.h"
#include "core/render/bands/render_bands.h"
#include "core/render/exposure/estimate_exposure.h"
#include "core/render/plan_mosaic.h"

namespace skyquilt::pipeline {
namespace {

std::set<std::string> ReferencesOf(const bands::Captures& captures) {
  std::set<std::string> names;
  for (const bands::Capture& capture : captures.captures) names.insert(capture.reference);
  return names;
}

bands::BandsReport Describe(const BandedMap& map, const bands::Captures& captures,
                            const render::BandCameras& cameras, double gsd_m) {
  bands::BandsReport report;
  report.reference_band = captures.reference_band;
  report.captures = static_cast<int>(map.references.photos.size());
  report.captures_total = static_cast<int>(captures.captures.size());
  report.gsd_m = gsd_m;
  for (std::size_t i = 0; i < captures.bands.size(); ++i) {
    const render::BandRegistration& registration = cameras.registrations[i];
    report.bands.push_back({captures.bands[i], registration.pictures, registration.measured,
                            registration.patches, registration.residual_px});
  }
  return report;
}

// Ground of known reflectance outweighs panels: it was seen from the air, in the flight's own light.
void CalibrateByTargets(const BandedMap& map, const ground::GroundSurface& ground,
                        const flight::PhotoSource& source, bands::Captures& captures,
                        render::BandCameras& cameras) {
  if (captures.targets.empty()) return;
  const render::TargetFactors factors =
      render::MeasureTargets(map.references, ground, captures, cameras, source);
  cameras.warnings.insert(cameras.warnings.end(), factors.warnings.begin(), factors.warnings.end());
  for (std::size_t i = 0; i < captures.bands.size(); ++i) {
    const std::vector<double>& all = factors.by_band[i];
    if (all.empty()) continue;
    const double factor = bands::ScaleBand(
        captures, captures.bands[i].name, {.by_group = {{"", all}}}, bands::HeldAgainst::kTargets,
        fmt::format("by {} target{} on the ground", all.size(), all.size() == 1 ? "" : "s"),
        cameras.warnings);
    for (render::BandedCapture& capture : cameras.captures) {
      if (capture.cameras[i]) capture.cameras[i]->radiometry.per_level *= factor;
    }
  }
}

}  // namespace

double MaxLookRad(const alignment::AlignedPhoto& photo, const MosaicOptions& options) {
  constexpr double kUntiedLookRad = 55.0 * std::numbers::pi / 180.0;
  return std::min(geo::DegToRad(options.max_look_deg), std::max(photo.tied_look_rad, kUntiedLookRad));
}

void DrawColourAlone(const bands::Captures& captures, alignment::AlignedFlight& flight) {
  const std::set<std::string> references = ReferencesOf(captures);
  const auto is_reference = [&](const alignment::AlignedPhoto& photo) {
    return references.contains(photo.photo.name);
  };
  const auto in_bands = std::count_if(flight.photos.begin(), flight.photos.end(), is_reference);
  const auto in_colour = static_cast<std::ptrdiff_t>(flight.photos.size()) - in_bands;
  // Some photos in colour beside a flight of bands, of the take-off say, are no map of it.
  if (in_bands == 0 || 2 * in_colour < in_bands) return;
  for (alignment::AlignedPhoto& photo : flight.photos) {
    if (is_reference(photo)) photo.max_look_rad = 0.0;
  }
}

std::optional<BandedMap> BandedMapOf(const FlightFacts& facts, bands::Captures captures,
                                     const MosaicOptions& options) {
  if (captures.empty()) return std::nullopt;
  const std::set<std::string> references = ReferencesOf(captures);
  BandedMap map;
  map.references = facts.flight;
  map.references.photos.clear();
  for (std::size_t i = 0; i < facts.flight.photos.size(); ++i) {
    if (!references.contains(facts.flight.photos[i].photo.name)) continue;
    alignment::AlignedPhoto& reference = map.references.photos.emplace_back(facts.flight.photos[i]);
    reference.max_look_rad = MaxLookRad(reference, options);  // drawn in colour or not
    map.thumbnails.push_back(facts.thumbnails[i]);
  }
  if (map.references.photos.empty()) return std::nullopt;
  map.boundary = facts.boundary;
  map.captures = std::move(captures);
  return map;
}

Result<BuiltBands> BuildBands(const BandedMap& map, const ground::GroundSurface& ground,
                              const MosaicOptions& options, const flight::PhotoSource& source,
                              bands::BandSink& sink, Progress& progress) {
  render::PlanOptions plan_options = PlanWithin(options);
  plan_options.boundary = map.boundary ? &*map.boundary : nullptr;
  plan_options.not_finer_than_photos = true;  // bands are coarser than colour as a rule
  SKYQUILT_TRY_ASSIGN(const render::MosaicPlan plan,
                      render::PlanMosaic(map.references, ground, plan_options));
  const RenderBudget budget = BudgetFor(options, plan);
  const std::int64_t left_bytes = std::max(
      budget.cache_bytes / 4, budget.cache_bytes - render::BandBlockBytes(plan, map.captures.bands.size()));
  SKYQUILT_TRY_ASSIGN(render::BandCameras cameras,
                      render::RegisterBands(map.references, ground, map.captures, source,
                                            {options.threads, left_bytes}, progress));
  bands::Captures captures = map.captures;
  CalibrateByTargets(map, ground, source, captures, cameras);
  if (auto unheld = bands::BandsHeldAgainstNothing(captures)) cameras.warnings.push_back(*std::move(unheld));
  const render::ExposureModel exposure = render::EstimateExposure(map.references, ground, map.thumbnails);
  render::SeamOptions seam_options;
  seam_options.threads = options.threads;
  const render::SeamMap seams =
      render::BuildSeamMap(map.references, ground, plan, exposure, map.thumbnails, seam_options);
  SKYQUILT_TRY(render::RenderBands({map.references, ground, seams, plan, cameras, captures}, source,
                                   {options.threads, left_bytes}, sink, progress));
  BuiltBands built{Describe(map, captures, cameras, plan.gsd_m), cameras.warnings};
  const int missing = built.report.captures_total - built.report.captures;
  if (missing > 0) {
    built.warnings.push_back({flight::RemarkCode::kCapturesNotPlaced,
                              {{"missing", missing}, {"captures", built.report.captures_total}}});
  }
  return built;
}

}  // namespace skyquilt::pipeline
