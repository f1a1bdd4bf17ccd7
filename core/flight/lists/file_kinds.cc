#include "core/flight/lists/file_kinds.h"

#include <algorithm>
#include <iterator>
#include <string>

#include "core/flight/aside/aside.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/metadata/exif_table.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

// TIFF 6.0.
constexpr std::uint16_t kSamplesPerPixel = 277;
constexpr std::uint16_t kSampleFormat = 339;
constexpr double kSigned = 2.0;
constexpr double kFloatingPoint = 3.0;

}  // namespace

bool IsElevationModel(ByteSource& source) {
  if (!IsTiff(source.ReadUpTo(0, 4))) return false;
  const Result<ExifTable> tags = ReadTiffTags(source);
  if (!tags || !IsGeoTiff(*tags)) return false;
  const double format = tags->Number(ExifIfd::kImage, kSampleFormat).value_or(1.0);
  return tags->Number(ExifIfd::kImage, kSamplesPerPixel).value_or(1.0) == 1.0 &&
         (format == kSigned || format == kFloatingPoint);
}

Result<void> CheckTiffDirectories(const std::filesystem::path& path) {
  constexpr int kMaxDirectories = 64;  // the raster, its overviews, and their masks
  const auto source = OpenFileBytes(path);
  if (!source || !IsTiff((*source)->ReadUpTo(0, 4))) return {};  // whoever reads it says what is wrong
  const Result<int> count = CountTiffDirectories(**source, kMaxDirectories);
  if (!count || *count <= kMaxDirectories) return {};
  return Because(ErrorCode::kUnsupportedFormat,
                 {RemarkCode::kElevationsOfMorePictures,
                  {{"model", path.filename().string()}, {"most", kMaxDirectories}}});
}

std::vector<InputFile> ElevationModelsAmong(const std::vector<InputFile>& files) {
  std::vector<InputFile> models;
  for (const InputFile& file : files) {
    const auto source = OpenFileBytes(file.path);
    if (source && IsElevationModel(**source)) models.push_back(file);
  }
  std::stable_sort(models.begin(), models.end(),
                   [](const InputFile& a, const InputFile& b) { return a.name < b.name; });
  return models;
}

bool LooksLikeFilm(std::string_view head) {
  if (head.size() < kFilmHeadBytes || head.substr(4, 4) != "ftyp") return false;
  return BoxedPictureOf(head) == BoxedPicture::kNone && head.substr(8, 4) != "crx ";
}

std::optional<Remark> LeaveOutFilmPreviews(std::vector<InputFile>& films) {
  const auto previews = std::stable_partition(films.begin(), films.end(), [](const InputFile& film) {
    const std::string name = LowerCase(film.name);
    return !name.ends_with(".lrf") && !name.ends_with(".lrv");
  });
  if (previews == films.begin() || previews == films.end()) return std::nullopt;
  Remark left{RemarkCode::kFilmPreviews,
              {{"files", std::distance(previews, films.end())}, {"file", previews->name}}};
  films.erase(previews, films.end());
  return left;
}

}  // namespace skyquilt::flight
