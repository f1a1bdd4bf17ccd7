#include "server/jobs/stitch_unit.h"

#include <fmt/format.h>

#include "core/base/process/large_blocks_apart.h"
#include "core/base/try.h"
#include "core/flight/photos/photo_decoder.h"
#include "core/pipeline/check_photos.h"
#include "core/pipeline/memory_budget.h"
#include "core/pipeline/units/map_units.h"
#include "server/inputs/open_elevation_model.h"
#include "storage/files/publish_file.h"
#include "storage/tilesets/map_keeper.h"

namespace skyquilt::server {
namespace {

template <typename Timings>
std::vector<std::pair<std::string, double>> StagesOf(const Timings& timings) {
  std::vector<std::pair<std::string, double>> stages_s;
  for (const auto& timing : timings) stages_s.emplace_back(timing.stage, timing.wall_s);
  return stages_s;
}

Result<UnitDone> Look(const std::vector<flight::InputFile>& files, const std::filesystem::path& out_dir,
                      const pipeline::MosaicOptions& options, const flight::PhotoSource& source,
                      Progress& progress) {
  progress.BeginStage("check");
  SKYQUILT_TRY_ASSIGN(const pipeline::FoundFiles found,
                      pipeline::FindInPhotos(files, options, source, progress));
  SKYQUILT_TRY(storage::WriteFileAtomically(out_dir / kFoundFile, pipeline::WriteFound(found)));
  return UnitDone{};
}

Result<UnitDone> Place(const std::vector<flight::InputFile>& files, int looks, const UnitFiles& units,
                       const std::filesystem::path& out_dir, const pipeline::MosaicOptions& options,
                       const flight::PhotoSource& source, Progress& progress) {
  const LargeBlocksApart features_apart(true);
  pipeline::FoundFiles found;
  for (int number = 0; number < looks; ++number) {
    SKYQUILT_TRY_ASSIGN(const std::string bytes, storage::ReadWholeFile(units.Found(number)));
    SKYQUILT_TRY(pipeline::ParseFound(bytes, found));
  }
  SKYQUILT_TRY_ASSIGN(const auto elevations, OpenElevationModel(options.dem_path, files));
  SKYQUILT_TRY_ASSIGN(
      const pipeline::PlacedUnit placed,
      pipeline::PlaceFound(files, std::move(found), options, source, elevations.source.get(), progress));
  SKYQUILT_TRY(storage::WriteFileAtomically(out_dir / kFactsFile, placed.facts));
  SKYQUILT_TRY(storage::WriteFileAtomically(out_dir / kShownFile, pipeline::WriteShown(placed.shown)));
  return UnitDone{static_cast<std::int64_t>(placed.blocks), StagesOf(placed.timings)};
}

Result<UnitDone> Render(const std::vector<flight::InputFile>& files, const UnitToDo& todo,
                        const UnitFiles& units, const std::filesystem::path& out_dir,
                        const pipeline::MosaicOptions& options, const flight::PhotoSource& source,
                        Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const std::string facts, storage::ReadWholeFile(units.Facts()));
  SKYQUILT_TRY_ASSIGN(const auto keeper, storage::MapKeeper::Create(out_dir, {}));
  const pipeline::UnitRange blocks =
      pipeline::RangeOf(static_cast<std::size_t>(todo.number), static_cast<std::size_t>(todo.count),
                        static_cast<std::size_t>(todo.blocks));
  SKYQUILT_TRY_ASSIGN(
      const pipeline::RenderedUnit rendered,
      pipeline::RenderRange(facts, blocks, files, options, source, *keeper, *keeper, progress));
  storage::TilesetMetadata metadata;
  metadata.name = fmt::format("Blocks {} to {} of a map", blocks.first, blocks.end);
  metadata.tile_size_px = rendered.tile_size_px;
  metadata.min_zoom = rendered.min_zoom;
  metadata.max_zoom = rendered.max_zoom;
  SKYQUILT_TRY(keeper->Publish(metadata));
  return UnitDone{0, StagesOf(rendered.timings)};
}

}  // namespace

Result<UnitDone> StitchUnit(const std::vector<flight::InputFile>& files, const UnitToDo& todo,
                            const UnitFiles& units, const std::filesystem::path& out_dir,
                            const pipeline::MosaicOptions& options, Progress& progress) {
  const flight::FilePhotoSource source(pipeline::MostDecodeBytes(options));
  switch (todo.kind) {
    case UnitKind::kLook:
      return Look(files, out_dir, options, source, progress);
    case UnitKind::kPlace:
      return Place(files, todo.looks, units, out_dir, options, source, progress);
    case UnitKind::kRender:
      break;
  }
  return Render(files, todo, units, out_dir, options, source, progress);
}

}  // namespace skyquilt::server
