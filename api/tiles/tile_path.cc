#include "api/tiles/tile_path.h"

#include "core/base/try.h"

namespace skyquilt::api {
namespace {

constexpr std::size_t kMaxDigits = 10;  // 2^30 has ten

std::optional<std::int64_t> ParseTileNumber(std::string_view text) {
  if (text.empty() || text.size() > kMaxDigits) return std::nullopt;
  std::int64_t number = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    number = number * 10 + (c - '0');
  }
  return number;
}

std::optional<image::PictureFormat> ParseExtension(std::string_view extension) {
  if (extension == "jpg" || extension == "jpeg") return image::PictureFormat::kJpeg;
  if (extension == "png") return image::PictureFormat::kPng;
  if (extension == "webp") return image::PictureFormat::kWebp;
  return std::nullopt;
}

}  // namespace

Result<TilePath> ParseTilePath(std::string_view z, std::string_view x, std::string_view y_and_extension) {
  TilePath path;
  const std::size_t dot = y_and_extension.find('.');
  if (dot != std::string_view::npos) {
    path.format = ParseExtension(y_and_extension.substr(dot + 1));
    if (!path.format) {
      return Error{ErrorCode::kInvalidArgument,
                   "A tile is asked for as .jpg, .png, .webp or without extension.", ""};
    }
  }
  std::string_view y = y_and_extension.substr(0, dot);
  constexpr std::string_view kDouble = "@2x";
  path.is_double = y.ends_with(kDouble);
  if (path.is_double) y.remove_suffix(kDouble.size());
  const std::optional<std::int64_t> zoom = ParseTileNumber(z);
  const std::optional<std::int64_t> column = ParseTileNumber(x);
  const std::optional<std::int64_t> row = ParseTileNumber(y);
  if (!zoom || !column || !row) {
    return Error{ErrorCode::kInvalidArgument, "A tile's address is three plain numbers: zoom/column/row.",
                 ""};
  }
  SKYQUILT_TRY_ASSIGN(const geo::TileId tile, geo::TileId::Make(*zoom, *column, *row));
  path.tile = tile;
  return path;
}

}  // namespace skyquilt::api
