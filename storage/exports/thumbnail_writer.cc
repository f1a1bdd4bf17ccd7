#include "storage/exports/thumbnail_writer.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal_priv.h>
#include <gdal_utils.h>

#include <algorithm>
#include <memory>
#include <string>

#include "storage/rasters/register_gdal.h"
#include "storage/tilesets/publish_file.h"

namespace skyquilt::storage {

Result<void> WriteThumbnail(const std::filesystem::path& cog, const std::filesystem::path& path,
                            int longer_side_px) {
  RegisterGdalOnce();
  CPLErrorReset();
  const auto failed = [] {
    const std::string detail = CPLGetLastErrorMsg();
    return Error{ErrorCode::kIo, "The thumbnail of the map cannot be written: " + detail + ".", detail};
  };
  const std::unique_ptr<GDALDataset> map(GDALDataset::Open(cog.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!map) return failed();
  const int longer_px = std::max(map->GetRasterXSize(), map->GetRasterYSize());
  const double shrink = std::min(1.0, static_cast<double>(longer_side_px) / longer_px);
  const auto side = [&](int side_px) {
    return std::to_string(std::max(1, static_cast<int>(side_px * shrink)));
  };
  CPLStringList words;
  for (const std::string& word :
       {std::string("-of"), std::string("PNG"), std::string("-r"), std::string("average"),
        std::string("-outsize"), side(map->GetRasterXSize()), side(map->GetRasterYSize())})
    words.AddString(word.c_str());
  if (map->GetRasterCount() == 3) {
    for (const char* word : {"-b", "1", "-b", "2", "-b", "3", "-b", "mask"}) words.AddString(word);
  }
  const std::unique_ptr<GDALTranslateOptions, void (*)(GDALTranslateOptions*)> translate(
      GDALTranslateOptionsNew(words.List(), nullptr), GDALTranslateOptionsFree);
  if (!translate) return failed();
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  std::unique_ptr<GDALDataset> written(GDALDataset::FromHandle(
      GDALTranslate(temporary.c_str(), GDALDataset::ToHandle(map.get()), translate.get(), nullptr)));
  if (!written) return failed();
  CPLErrorReset();
  written.reset();
  if (CPLGetLastErrorType() >= CE_Failure) return failed();
  return PublishFile(temporary, path);
}

}  // namespace skyquilt::storage
