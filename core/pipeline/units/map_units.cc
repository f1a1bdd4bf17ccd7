#include "core/pipeline/units/map_units.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/try.h"
#include "core/pipeline/memory_budget.h"
#include "core/pipeline/place_flight.h"
#include "core/pipeline/report/cbor_values.h"
#include "core/pipeline/stage_runner.h"
#include "core/render/blocks/block_weights.h"
#include "core/render/blocks/weigh_block.h"
#include "core/render/render_tiles.h"

namespace skyquilt::pipeline {
namespace {

using Cbor = nlohmann::json;

// Raised whenever the meaning or a name changes.
constexpr int kShownVersion = 1;

}  // namespace

std::set<std::string> ShownPhotos::NamesIn(const UnitRange& blocks) const {
  std::set<std::string> shown;
  for (std::size_t i = blocks.first; i < std::min(blocks.end, of_blocks.size()); ++i)
    for (const std::uint32_t photo : of_blocks[i]) shown.insert(names[photo]);
  return shown;
}

ShownPhotos FindShown(const FlightFacts& facts, const PlannedMap& planned) {
  ShownPhotos shown;
  for (const alignment::AlignedPhoto& photo : facts.flight.photos) shown.names.push_back(photo.photo.name);
  for (const render::RenderBlock& block : planned.plan.blocks) {
    const render::BlockCells cells(planned.seams, block.tile, planned.plan.block_levels);
    shown.of_blocks.push_back(cells.PhotosOf(block));
  }
  return shown;
}

std::string WriteShown(const ShownPhotos& shown) {
  Cbor names = Cbor::array(), blocks = Cbor::array();
  for (const std::string& name : shown.names) names.push_back(CborOfText<Cbor>(name));
  for (const auto& photos : shown.of_blocks) blocks.push_back(CborOfValues<Cbor>(photos));
  const std::vector<std::uint8_t> bytes =
      Cbor::to_cbor({{"version", kShownVersion}, {"names", std::move(names)}, {"blocks", std::move(blocks)}});
  return {bytes.begin(), bytes.end()};
}

Result<ShownPhotos> ParseShown(std::string_view bytes) {
  const auto broken = [](const char* why) {
    return Error{ErrorCode::kCorrupt,
                 "What is known of a part of the map is damaged. Stitch the flight again.", why};
  };
  try {
    const Cbor json = Cbor::from_cbor(bytes);
    if (json.at("version") != kShownVersion) return broken("another version wrote it");
    ShownPhotos shown;
    for (const Cbor& name : json.at("names")) shown.names.push_back(TextOfCbor(name));
    for (const Cbor& photos : json.at("blocks")) {
      shown.of_blocks.push_back(ValuesOfCbor<std::uint32_t>(photos));
      for (const std::uint32_t photo : shown.of_blocks.back())
        if (photo >= shown.names.size()) return broken("a block shows a photo that is not there");
    }
    return shown;
  } catch (const Cbor::exception& failure) {
    return broken(failure.what());
  }
}

Result<PlacedUnit> PlaceFound(const std::vector<flight::InputFile>& files, FoundFiles found,
                              const MosaicOptions& options, const flight::PhotoSource& source,
                              const geo::DemSource* dem, Progress& progress) {
  SKYQUILT_TRY(options.Validate());
  MosaicReport report;
  StageRunner stages(report, progress);
  SKYQUILT_TRY_ASSIGN(auto placed,
                      PlaceFlight(files, options, source, dem, nullptr, stages, progress, std::move(found)));
  SKYQUILT_TRY_ASSIGN(const PlannedMap planned, PlanMap(placed.facts, placed.gsd_m, options, stages));
  placed.facts.appearance = planned.Appearance();
  return PlacedUnit{WriteFacts(placed.facts), FindShown(placed.facts, planned), planned.plan.blocks.size(),
                    std::move(report.timings)};
}

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
