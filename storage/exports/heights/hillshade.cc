#include "storage/exports/heights/hillshade.h"

#include <cpl_error.h>
#include <gdal_priv.h>
#include <gdal_utils.h>

#include <memory>
#include <utility>

#include "storage/files/publish_file.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {

Result<void> WriteHillshade(const std::filesystem::path& heights, int threads, Progress& progress) {
  RegisterGdalOnce();
  CPLErrorReset();
  const std::unique_ptr<GDALDataset> source(
      GDALDataset::Open(heights.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!source) return LastGdalError(progress);
  const std::filesystem::path path = heights.parent_path() / "dsm_hillshade.tif";
  const TemporaryFile made(path, ".tmp");
  CPLStringList words;
  AddGdalWords(words, {"-of", "COG", "-multidirectional", "-compute_edges", "-co", "COMPRESS=DEFLATE"});
  AddGdalWords(words, {"-co", "PREDICTOR=YES", "-co", "OVERVIEW_RESAMPLING=AVERAGE", "-co",
                       "BIGTIFF=IF_SAFER", "-co", GdalThreads(threads)});
  using Options = GDALDEMProcessingOptions;
  const std::unique_ptr<Options, void (*)(Options*)> options(
      GDALDEMProcessingOptionsNew(words.List(), nullptr), GDALDEMProcessingOptionsFree);
  if (!options) return LastGdalError(progress);
  GdalStep step{progress, "writing dsm_hillshade.tif"};
  GDALDEMProcessingOptionsSetProgress(options.get(), ForwardGdalProgress, &step);
  std::unique_ptr<GDALDataset> written(GDALDataset::FromHandle(GDALDEMProcessing(
      made.c_str(), GDALDataset::ToHandle(source.get()), "hillshade", nullptr, options.get(), nullptr)));
  if (!written || !IsClosedWell(std::move(written))) return LastGdalError(progress);
  return PublishFile(made.path(), path);
}

}  // namespace skyquilt::storage
