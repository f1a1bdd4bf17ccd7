#include "server/jobs/stitch_job.h"

#include <memory>
#include <system_error>
#include <utility>

#include "core/base/parallel_for.h"
#include "core/base/scoped_timer.h"
#include "core/base/trace.h"
#include "core/base/try.h"
#include "core/flight/photos/photo_decoder.h"
#include "core/flight/remarks/because.h"
#include "core/pipeline/build_mosaic.h"
#include "core/pipeline/memory_budget.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/report/judge_map.h"
#include "core/pipeline/report/locate.h"
#include "core/pipeline/report/odm_exports.h"
#include "core/render/blocks/render_layers.h"
#include "server/inputs/film_frames.h"
#include "server/inputs/open_elevation_model.h"
#include "server/surface/write_surface.h"
#include "server/tileset_metadata.h"
#include "storage/exports/cog_writer.h"
#include "storage/exports/kmz_writer.h"
#include "storage/exports/pmtiles_writer.h"
#include "storage/exports/thumbnail_writer.h"
#include "storage/exports/warped/warp_tiles.h"
#include "storage/files/publish_file.h"
#include "storage/rasters/bands_writer.h"
#include "storage/tilesets/map_keeper.h"
#include "storage/tilesets/mbtiles_reader.h"
#include "storage/tilesets/mbtiles_writer.h"

namespace skyquilt::server {
namespace {

constexpr int kThumbnailPx = 512;

// A cancelled or failed flight leaves no product behind; what an earlier run made stays until it is replaced.
Result<void> MakeFolder(const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) return storage::FileError("cannot make", folder, failed.value());
  return {};
}

Result<void> WriteUtm(const std::filesystem::path& mbtiles, const StitchJobOptions& options,
                      const pipeline::MosaicReport& report, const std::filesystem::path& out_dir,
                      Progress& progress) {
  const double pixel_m = options.mosaic.OutputGsdM(report.gsd_m);
  const storage::WarpTilesOptions utm{.bounds = report.bounds,
                                      .min_zoom = report.min_zoom,
                                      .max_zoom = report.max_zoom,
                                      .target = {.pixel_x = pixel_m, .pixel_y = pixel_m},
                                      .jpeg_quality = options.mosaic.jpeg_quality,
                                      .threads = options.mosaic.threads};
  return storage::WriteUtmGeotiff(mbtiles, out_dir / "mosaic_utm.tif", utm, progress);
}

// Another format that is not written now must not stay of an earlier map: it would pass for this one.
Result<void> RemoveUnwritten(const StitchJobOptions& options, const std::filesystem::path& out_dir) {
  for (const auto& [name, is_written] :
       {std::pair{"mosaic.pmtiles", options.write_pmtiles}, std::pair{"mosaic.tif", options.write_cog},
        std::pair{"mosaic.kmz", options.write_kmz}, std::pair{"mosaic_utm.tif", options.mosaic.write_utm}}) {
    std::error_code failed;
    if (!is_written) std::filesystem::remove(out_dir / name, failed);
    if (failed) return storage::FileError("cannot remove", out_dir / name, failed.value());
  }
  return {};
}

// The tileset in the other formats that were asked for.
Result<void> Export(const std::filesystem::path& mbtiles, const StitchJobOptions& options,
                    const pipeline::MosaicReport& report, const std::filesystem::path& out_dir,
                    Progress& progress) {
  SKYQUILT_TRY(RemoveUnwritten(options, out_dir));
  if (options.write_pmtiles) {
    const TraceSpan span("write mosaic.pmtiles");
    SKYQUILT_TRY(storage::WritePmtiles(mbtiles, out_dir / "mosaic.pmtiles", progress));
  }
  if (options.write_cog) {
    const TraceSpan span("write mosaic.tif");
    const storage::CogOptions cog{options.mosaic.jpeg_quality, options.mosaic.threads};
    SKYQUILT_TRY(storage::WriteCog(mbtiles, out_dir / "mosaic.tif", cog, progress));
  }
  SKYQUILT_TRY(storage::WriteTilesThumbnail(mbtiles, out_dir / "thumbnail.png", kThumbnailPx));
  if (options.write_kmz) SKYQUILT_TRY(storage::WriteKmz(mbtiles, out_dir / "mosaic.kmz", progress));
  return options.mosaic.write_utm ? WriteUtm(mbtiles, options, report, out_dir, progress) : Result<void>();
}

// The layers that were asked for, each a tileset of its own, and what their colours mean. Those of an earlier
// run of which nobody asked go.
Result<void> WriteLayers(const pipeline::BuiltMosaic& built, const pipeline::MosaicOptions& options,
                         const std::filesystem::path& out_dir, Progress& progress) {
  std::error_code gone;  // what cannot be removed shows up when it is written
  for (const render::MapLayer layer : render::kMapLayers) {
    std::filesystem::remove(out_dir / render::LayerFileName(layer), gone);
  }
  std::filesystem::remove(out_dir / "layers.json", gone);
  if (options.layers.empty()) return {};
  std::vector<std::unique_ptr<storage::MbtilesWriter>> writers;
  std::vector<render::LayerSink> sinks;
  for (const render::MapLayer layer : options.layers) {
    SKYQUILT_TRY_ASSIGN(auto writer, storage::MbtilesWriter::Create(out_dir / render::LayerFileName(layer)));
    writers.push_back(std::move(writer));
    sinks.push_back({layer, *writers.back()});
  }
  const alignment::ErrorsKnown known = pipeline::ErrorsKnownOf(built.report.quality.absolute);
  SKYQUILT_TRY_ASSIGN(
      const render::HeightRange heights,
      render::RenderLayers(built.flight, built.ShownGround(), built.seams, built.plan, sinks, options.threads,
                           progress, pipeline::RaisedM(built.report), known));
  const render::LayerZooms zooms = render::ZoomsOfLayers(built.plan);
  for (std::size_t i = 0; i < sinks.size(); ++i) {
    storage::TilesetMetadata metadata = TilesetMetadataOf(built.report);
    metadata.name += std::string(", ") + render::NameOf(sinks[i].layer);
    metadata.description = "Layer of the map; layers.json says what its colours mean";
    metadata.min_zoom = zooms.min_zoom;
    metadata.max_zoom = zooms.max_zoom;
    metadata.tile_size_px = render::kLayerTilePx;
    SKYQUILT_TRY(writers[i]->Publish(metadata));
  }
  std::vector<std::string> photo_names;
  for (const alignment::AlignedPhoto& photo : built.flight.photos) photo_names.push_back(photo.photo.name);
  return storage::WriteFileAtomically(out_dir / "layers.json",
                                      render::LayersJson(options.layers, photo_names, heights));
}

// The raster of bands, where the flight has bands. A map without it is still a map.
Result<void> WriteBands(pipeline::BuiltMosaic& built, const pipeline::MosaicOptions& options,
                        const flight::PhotoSource& photos, const std::filesystem::path& out_dir,
                        Progress& progress) {
  const std::filesystem::path path = out_dir / "bands.tif";
  std::error_code gone;  // what cannot be removed shows up when it is written
  std::filesystem::remove(path, gone);
  if (!built.bands) return {};
  storage::BandsWriter writer(path, options.threads, progress);
  Result<pipeline::BuiltBands> bands =
      pipeline::BuildBands(*built.bands, built.ShownGround(), options, photos, writer, progress);
  if (!bands && bands.error().code == ErrorCode::kUnprocessable) {
    built.report.warnings.push_back({flight::RemarkCode::kNoBands, {{"why", flight::WhyOf(bands.error())}}});
    return {};
  }
  if (!bands) return bands.error();
  SKYQUILT_TRY(writer.Publish());
  built.report.bands = std::move(bands->report);
  built.report.warnings.insert(built.report.warnings.end(), bands->warnings.begin(), bands->warnings.end());
  return {};
}

Result<void> WriteOtherFiles(pipeline::BuiltMosaic& built, const StitchJobOptions& options,
                             const flight::PhotoSource& photos, const std::filesystem::path& out_dir,
                             Progress& progress) {
  progress.BeginStage("export");
  pipeline::StageTiming exported_in{"export", 0.0, 0.0};
  {
    ScopedTimer timer(exported_in.wall_s);
    ScopedCpuTimer cpu_timer(exported_in.cpu_s);
    SKYQUILT_TRY(Export(out_dir / "mosaic.mbtiles", options, built.report, out_dir, progress));
    SKYQUILT_TRY(WriteLayers(built, options.mosaic, out_dir, progress));
    SKYQUILT_TRY(WriteBands(built, options.mosaic, photos, out_dir, progress));
  }
  built.report.timings.push_back(exported_in);
  if (options.mosaic.heights == pipeline::MapHeights::kNone) return {};
  return WriteSurface(built, options.mosaic, photos, out_dir, progress);
}

// Positions near 0, 0 of a map that lies nowhere are of no use to other engines, which would believe them.
Result<void> WriteGeoTxt(const pipeline::BuiltMosaic& built, alignment::ErrorsKnown known,
                         const std::filesystem::path& path) {
  if (built.report.is_placed) {
    return storage::WriteFileAtomically(
        path, pipeline::OdmGeoTxt(built.flight, pipeline::RaisedM(built.report), known));
  }
  std::error_code gone;  // that of an earlier run
  std::filesystem::remove(path, gone);
  return {};
}

Result<void> WriteReports(const pipeline::BuiltMosaic& built, const std::filesystem::path& out_dir) {
  const double raised_m = pipeline::RaisedM(built.report);
  const alignment::ErrorsKnown known = pipeline::ErrorsKnownOf(built.report.quality.absolute);
  SKYQUILT_TRY(WriteGeoTxt(built, known, out_dir / "geo.txt"));
  for (const auto& [name, text] :
       {std::pair{"photos.geojson",
                  pipeline::PhotosGeoJson(built.flight, built.ground, built.report.quality.absolute)},
        std::pair{"cameras.json", pipeline::OdmCamerasJson(built.flight)},
        std::pair{"locate.json", pipeline::LocateJson(built.flight, built.ground, raised_m, known)},
        std::pair{"report.json", pipeline::ReportJson(built.report)}}) {
    SKYQUILT_TRY(storage::WriteFileAtomically(out_dir / name, text));
  }
  return {};
}

void ForgetEarlierRuns(const std::filesystem::path& out_dir) {
  std::error_code gone;  // what cannot be removed is of no use to the next run either
  for (const char* name : {"mosaic.state", "mosaic.state.tmp", "mosaic.state.part"}) {
    std::filesystem::remove(out_dir / name, gone);
  }
}

}  // namespace

Result<std::vector<flight::InputFile>> FilesOfMap(const std::filesystem::path& out_dir) {
  SKYQUILT_TRY_ASSIGN(const std::string bytes, storage::MapKeeper::FactsOf(out_dir));
  SKYQUILT_TRY_ASSIGN(const pipeline::FlightFacts facts, pipeline::ParseFacts(bytes));
  std::vector<flight::InputFile> films, files;
  for (FilmSource& source : SourcesOfFrames(out_dir)) films.push_back(std::move(source.file));
  for (const pipeline::NamedDigest& input : facts.inputs) {
    if (!IsFrameOf(out_dir, input.file)) files.push_back(input.file);
  }
  // Frames are taken from their films again. Where the map has none, those of one before it lie there still.
  if (files.size() < facts.inputs.size()) files.insert(files.begin(), films.begin(), films.end());
  return files;
}

Result<void> TakeOptionsOfMap(const std::filesystem::path& out_dir, const std::set<std::string>& said,
                              pipeline::MosaicOptions& options) {
  SKYQUILT_TRY_ASSIGN(const std::string bytes, storage::MapKeeper::FactsOf(out_dir));
  SKYQUILT_TRY_ASSIGN(const pipeline::FlightFacts facts, pipeline::ParseFacts(bytes));
  const auto is_unsaid = [&](const std::string& name) { return !said.contains(name); };
  options.TakeWords(facts.asked, is_unsaid);
  const auto dem = facts.asked.find("--dem");
  if (is_unsaid("--dem") && dem != facts.asked.end() && !dem->second.empty()) {
    return Error{ErrorCode::kConflict,
                 "The map was made over the elevation model " + dem->second + "; give it again with --dem."};
  }
  if (is_unsaid("--gsd") && facts.appearance && facts.appearance->is_gsd_asked) {
    options.gsd_m = facts.appearance->gsd_m;
    options.any_gsd = true;  // however far from the photos it is, it was taken for what is meant
  }
  if (is_unsaid("--boundary")) options.boundary = facts.boundary;
  std::error_code none;
  for (const render::MapLayer layer : render::kMapLayers) {
    if (is_unsaid("--layers") && std::filesystem::exists(out_dir / render::LayerFileName(layer), none))
      options.layers.push_back(layer);
  }
  if (!options.title.empty()) return {};
  if (const auto map = storage::MbtilesReader::Open(out_dir / "mosaic.mbtiles")) {
    const auto name = (*map)->metadata().find("name");
    if (name != (*map)->metadata().end()) options.title = name->second;
  }
  return {};
}

Result<pipeline::MosaicReport> StitchToDirectory(const std::vector<flight::InputFile>& files,
                                                 const StitchJobOptions& options,
                                                 const std::filesystem::path& out_dir, Progress& progress) {
  SKYQUILT_TRY(MakeFolder(out_dir));
  if (options.is_fresh) ForgetEarlierRuns(out_dir);
  pipeline::FoundFiles found;
  storage::MapParts parts;
  if (!options.facts_file.empty()) {
    SKYQUILT_TRY_ASSIGN(parts.facts, storage::ReadWholeFile(options.facts_file));
    SKYQUILT_TRY_ASSIGN(found.digests, pipeline::DigestsOfFacts(parts.facts));
    parts.folders = options.part_dirs;
  }
  SKYQUILT_TRY_ASSIGN(auto keeper,
                      storage::MapKeeper::Create(out_dir, options.previous_dir, std::move(parts)));
  const flight::FilePhotoSource photos(pipeline::MostDecodeBytes(options.mosaic));
  SKYQUILT_TRY_ASSIGN(const video::FlightFiles given,
                      TakeFilmFrames(files, out_dir, ThreadCount(options.mosaic.threads), progress));
  SKYQUILT_TRY_ASSIGN(const auto elevations, OpenElevationModel(options.mosaic.dem_path, given.files));
  SKYQUILT_TRY_ASSIGN(pipeline::BuiltMosaic built,
                      pipeline::BuildMosaic(given.files, options.mosaic, photos, *keeper, progress,
                                            elevations.source.get(), keeper.get(), std::move(found)));
  built.report.warnings.insert(built.report.warnings.end(), given.warnings.begin(), given.warnings.end());
  built.report.warnings.insert(built.report.warnings.end(), elevations.warnings.begin(),
                               elevations.warnings.end());
  SKYQUILT_TRY(keeper->Publish(TilesetMetadataOf(built.report)));
  // What the map lies in is finished: a further file that cannot be written leaves it with its report.
  const Result<void> others = WriteOtherFiles(built, options, photos, out_dir, progress);
  SKYQUILT_TRY(WriteReports(built, out_dir));
  if (!others) return others.error();
  return std::move(built.report);
}

}  // namespace skyquilt::server
