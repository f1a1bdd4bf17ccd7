// What every piece of work by GDAL needs: its drivers, its words, its progress as a share of ours, and its
// last error as ours. One thread, but for RegisterGdalOnce.
#pragma once

#include <cpl_error.h>
#include <cpl_string.h>

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <string>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/rasters/merc_grid.h"

class GDALDataset;

namespace skyquilt::storage {

// Makes GDAL ready for the formats it reads and writes here, with a small block cache and
// no side files. Any thread, any number of times.
void RegisterGdalOnce();

// While it lives, GDAL's and PROJ's words on this thread are kept for our own sentences and not
// printed; afterwards they are forgotten. One thread; they nest.
class QuietGdal {
 public:
  QuietGdal() {
    CPLErrorReset();
    CPLPushErrorHandler(CPLQuietErrorHandler);
  }
  ~QuietGdal() {
    CPLPopErrorHandler();
    CPLErrorReset();
  }
  QuietGdal(const QuietGdal&) = delete;
  QuietGdal& operator=(const QuietGdal&) = delete;
};

// The share of the whole that a step of it is.
struct GdalStep {
  Progress& progress;
  const char* message;
  double from = 0.0, to = 1.0;
};

// A GDALProgressFunc; `step` points to a GdalStep. 0 (stop) once the job is cancelled.
int ForwardGdalProgress(double fraction, const char* message, void* step);

// Of the last call, as a file that could not be written: kCancelled, kOutOfSpace, kIo.
Error LastGdalError(const Progress& progress);

// An empty GeoTIFF of floats on pixels of the web map (EPSG:3857), for what comes block by block: tiled,
// compressed without loss, a step on the way to a cloud-optimised one. Blocks that nobody writes take no
// room.
Result<std::unique_ptr<GDALDataset>> CreateMercFloats(const std::filesystem::path& path, const MercGrid& grid,
                                                      int bands, const Progress& progress);

// Closing writes what is left; an error there is an error of the file.
bool IsClosedWell(std::unique_ptr<GDALDataset> written);

// For GDAL's programs, as a shell would give them.
void AddGdalWords(CPLStringList& words, std::initializer_list<std::string> more);
// "NUM_THREADS=4"; 0: all cores.
std::string GdalThreads(int threads);
// What gdal_translate makes of `source`, written to its end. `step`: null where nobody waits for it. False:
// ask for the last error.
bool TranslateRaster(GDALDataset& source, const char* path, CPLStringList words, GdalStep* step);

}  // namespace skyquilt::storage
