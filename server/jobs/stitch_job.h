// StitchToDirectory: one flight from files to finished products in a folder: mosaic.mbtiles, thumbnail.png,
// bands.tif for cameras of several bands, mosaic.pmtiles, mosaic.tif (COG), mosaic_utm.tif, mosaic.kmz,
// dsm.tif with dsm_photos.tif and dsm_hillshade.tif, dtm.tif with dtm_ground.tif and contours, and
// layer_*.mbtiles with layers.json by option, report.json, photos.geojson, and for OpenDroneMap cameras.json
// and, of a map with a place on Earth, geo.txt, each written under a temporary name and published by rename.
// Of what is not written nothing stays of an earlier map, but for heights.
// What both the `stitch` command and the worker run. Blocking; one call at a time per process (it uses all
// the threads asked for). Errors: kUnprocessable (no photo could be placed), kCancelled, kOutOfSpace, kIo; of
// a file beside the finished map only after its reports are written.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/read_flight.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/mosaic_report.h"

namespace skyquilt::server {

struct StitchJobOptions {
  pipeline::MosaicOptions mosaic;
  // The same pyramid once more; a server makes both from the tiles as they are asked for.
  bool write_cog = false;
  bool write_pmtiles = false;
  bool write_kmz = false;
  bool is_fresh = false;  // nothing is taken from earlier runs
  // A finished map of the same flight: what has not changed is taken from it. Empty: that of the folder
  // itself.
  std::filesystem::path previous_dir;
  // What other processes made of the same flight: its facts, and folders with ranges of the map's blocks.
  std::filesystem::path facts_file = {};  // empty: nothing
  std::vector<std::filesystem::path> part_dirs = {};
};

Result<pipeline::MosaicReport> StitchToDirectory(const std::vector<flight::InputFile>& files,
                                                 const StitchJobOptions& options,
                                                 const std::filesystem::path& out_dir, Progress& progress);

// The files of the finished map in a folder, to which others may be added. Errors: kNotFound (no map with a
// memory), kCorrupt.
Result<std::vector<flight::InputFile>> FilesOfMap(const std::filesystem::path& out_dir);
// What it was made with, a ground size that was asked for, boundary, layers and title too, which stays so
// when photos are added: into `options`, but what `said` has ("--quality"). Errors: as FilesOfMap; kConflict
// (an elevation model of which nothing is said, and where it lies is not known).
Result<void> TakeOptionsOfMap(const std::filesystem::path& out_dir, const std::set<std::string>& said,
                              pipeline::MosaicOptions& options);

}  // namespace skyquilt::server
