#include "core/pipeline/units/render_unit.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "core/base/try.h"
#include "core/pipeline/memory_budget.h"
#include "core/pipeline/plan_map.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/stage_runner.h"
#include "core/render/blocks/weigh_block.h"
#include "core/render/render_tiles.h"

namespace skyquilt::pipeline {
namespace {

// The digests of the placed photos' files, and where these lie here.
std::vector<Digest> Locate(const std::vector<flight::InputFile>& files, FlightFacts& facts) {
  std::map<std::string, Digest> digests;
  for (const NamedDigest& input : facts.inputs) digests.emplace(input.file.name, input.digest);
  std::map<std::string, std::filesystem::path> paths;
  for (const flight::InputFile& file : files) paths.emplace(file.name, file.path);
  std::vector<Digest> ordered;
  for (alignment::AlignedPhoto& photo : facts.flight.photos) {
    ordered.push_back(digests[photo.photo.name]);
    photo.photo.path = paths[photo.photo.name];  // empty for what the range does not show
    photo.photo.intrinsics = photo.intrinsics;   // the size is what decoding looks at
  }
  return ordered;
}

}  // namespace

Result<RenderedUnit> RenderRange(std::string_view facts_bytes, const UnitRange& blocks,
                                 const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                 const flight::PhotoSource& source, pyramid::TileSink& sink,
                                 pyramid::MapMemory& memory, Progress& progress) {
  SKYQUILT_TRY(options.Validate());
  SKYQUILT_TRY_ASSIGN(FlightFacts facts, ParseFacts(facts_bytes));
  if (!facts.appearance) {
    return Error{ErrorCode::kCorrupt, "What is known of the flight does not say how its map looks.", ""};
  }
  const std::vector<Digest> digests = Locate(files, facts);
  MosaicReport report;
  StageRunner stages(report, progress);
  SKYQUILT_TRY_ASSIGN(PlannedMap planned, PlanMap(facts, {}, options, stages, blocks));
  render::MosaicPlan& plan = planned.plan;
  const RenderBudget budget = BudgetFor(options, plan);
  // Of these blocks no overviews.
  plan.min_zoom = std::max(plan.min_zoom, plan.base_zoom - plan.block_levels);
  render::PhotoCache cache(source, budget.cache_bytes);
  auto rendered = stages.Run("render", [&] {
    const std::vector<image::PixelBox> shown =
        render::ShownRegions(facts.flight, facts.ground, planned.seams);
    for (std::size_t i = 0; i < shown.size(); ++i) cache.Expect(i, shown[i]);
    const render::RenderContext context{facts.flight,  facts.ground, planned.exposure,
                                        planned.seams, plan,         cache};
    const render::RenderOptions render_options{budget.threads, {options.encoding, options.jpeg_quality}};
    const render::RenderMemory render_memory{memory, digests};
    return render::RenderTiles(context, render_options, sink, progress, &render_memory);
  });
  if (!rendered) return rendered.error();
  return RenderedUnit{rendered->tiles, plan.min_zoom, plan.base_zoom, plan.tile_size_px,
                      std::move(report.timings)};
}

}  // namespace skyquilt::pipeline
