#include "core/image/picture_format.h"

#include <algorithm>

#include "core/base/check.h"

namespace skyquilt::image {
namespace {

template <typename Fits>
std::optional<PictureFormat> FirstThat(const Fits& fits) {
  const auto row = std::find_if(kPictureFormats.begin(), kPictureFormats.end(), fits);
  if (row == kPictureFormats.end()) return std::nullopt;
  return row->format;
}

const PictureFormatRow& RowOf(PictureFormat format) {
  const auto row = std::find_if(kPictureFormats.begin(), kPictureFormats.end(),
                                [&](const auto& known) { return known.format == format; });
  SKYQUILT_CHECK(row != kPictureFormats.end(), "a picture format outside the table");
  return *row;
}

}  // namespace

std::optional<PictureFormat> PictureFormatOf(std::string_view bytes) {
  return FirstThat([&](const auto& row) {
    return bytes.starts_with(row.begins) &&
           (row.at_8.empty() || (bytes.size() >= 8 && bytes.substr(8).starts_with(row.at_8)));
  });
}

bool IsWebpWithAlpha(std::string_view bytes) {
  if (PictureFormatOf(bytes) != PictureFormat::kWebp) return false;
  // Behind the name of the first chunk and its four bytes of length.
  constexpr std::size_t kFlagsAt = 20, kLosslessFlagsAt = 24;
  constexpr int kAlpha = 0x10;
  const std::string_view chunk = bytes.substr(12, 4);
  if (chunk == "VP8X") return bytes.size() > kFlagsAt && (bytes[kFlagsAt] & kAlpha) != 0;
  if (chunk == "VP8L") return bytes.size() > kLosslessFlagsAt && (bytes[kLosslessFlagsAt] & kAlpha) != 0;
  return false;
}

const char* ContentTypeOf(PictureFormat format) { return RowOf(format).content_type; }

const char* ExtensionOf(PictureFormat format) { return RowOf(format).extension; }

int PmtilesTypeOf(PictureFormat format) { return RowOf(format).pmtiles_type; }

int MbtilesCodeOf(PictureFormat format) { return RowOf(format).mbtiles_code; }

std::optional<PictureFormat> PictureFormatNamed(std::string_view word) {
  return FirstThat([&](const auto& row) { return word == row.extension || word == row.name; });
}

std::optional<PictureFormat> PictureFormatOfPmtiles(int type) {
  return FirstThat([&](const auto& row) { return row.pmtiles_type == type && type > 0; });
}

std::optional<PictureFormat> PictureFormatOfMbtiles(std::int64_t code) {
  return FirstThat([&](const auto& row) { return row.mbtiles_code == code; });
}

std::string ListedFormats(const char* PictureFormatRow::*word, std::string_view before) {
  std::string list;
  for (const PictureFormatRow& row : kPictureFormats) {
    if (!list.empty()) list += &row == &kPictureFormats.back() ? " and " : ", ";
    list.append(before).append(row.*word);
  }
  return list;
}

}  // namespace skyquilt::image
