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

}  // namespace

Result<TileNumbers> ParseTileNumbers(std::string_view z, std::string_view x,
                                     std::string_view y_and_extension) {
  TileNumbers numbers;
  const std::size_t dot = y_and_extension.find('.');
  if (dot != std::string_view::npos) {
    numbers.format = image::PictureFormatNamed(y_and_extension.substr(dot + 1));
    if (!numbers.format) {
      return Error{ErrorCode::kInvalidArgument,
                   "A tile is asked for without extension, or with one of " +
                       image::ListedFormats(&image::PictureFormatRow::extension, ".") + "."};
    }
  }
  std::string_view y = y_and_extension.substr(0, dot);
  constexpr std::string_view kDouble = "@2x";
  numbers.is_double = y.ends_with(kDouble);
  if (numbers.is_double) y.remove_suffix(kDouble.size());
  const std::optional<std::int64_t> zoom = ParseTileNumber(z);
  const std::optional<std::int64_t> column = ParseTileNumber(x);
  const std::optional<std::int64_t> row = ParseTileNumber(y);
  if (!zoom || !column || !row) {
    return Error{ErrorCode::kInvalidArgument, "A tile's address is three plain numbers: zoom/column/row."};
  }
  numbers.z = *zoom;
  numbers.x = *column;
  numbers.y = *row;
  return numbers;
}

Result<TilePath> ParseTilePath(std::string_view z, std::string_view x, std::string_view y_and_extension) {
  SKYQUILT_TRY_ASSIGN(const TileNumbers numbers, ParseTileNumbers(z, x, y_and_extension));
  TilePath path;
  SKYQUILT_TRY_ASSIGN(path.tile, geo::TileId::Make(numbers.z, numbers.x, numbers.y));
  path.format = numbers.format;
  path.is_double = numbers.is_double;
  return path;
}

}  // namespace skyquilt::api
