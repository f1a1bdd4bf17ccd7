#include "storage/exports/custom/clip_tileset.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/image/fringe_encoder.h"
#include "core/image/picture_codec.h"
#include "storage/exports/custom/export_request.h"
#include "storage/exports/fringe_tile.h"
#include "storage/exports/stored_tiles.h"
#include "storage/tilesets/mbtiles_reader.h"
#include "storage/tilesets/mbtiles_writer.h"

namespace skyquilt::storage {
namespace {

// Nothing beyond the boundary. False: nothing at all.
bool Cut(const std::vector<std::uint8_t>& inside, image::RgbaImage& tile) {
  bool is_covered = false;
  std::uint8_t* pixel = tile.rgba.data();
  for (std::size_t i = 0; i < inside.size(); ++i, pixel += 4) {
    if (inside[i] == 0) std::fill(pixel, pixel + 4, std::uint8_t{0});
    is_covered |= pixel[3] != 0;
  }
  return is_covered;
}

class Clip {
 public:
  Clip(const ClipOptions& options, int tile_size_px, image::TileEncoding encoding, MbtilesWriter& writer)
      : options_(options), tile_size_px_(tile_size_px), encoding_(encoding), writer_(writer) {}

  Result<void> Take(const geo::TileId& tile, std::string_view bytes) {
    const auto format = image::PictureFormatOf(bytes);
    if (!format) return Error{ErrorCode::kCorrupt, "A stored tile is no picture. Make the map again.", ""};
    const Cover cover = CoverOf(tile);
    if (cover == Cover::kNone) return {};
    if (cover == Cover::kAll)
      return Put(tile, *format, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    SKYQUILT_TRY_ASSIGN(image::RgbaImage picture, DecodeTile(bytes, tile_size_px_));
    if (!Cut(inside_, picture)) return {};
    switch (encoding_) {
      case image::TileEncoding::kWebp:
        return Put(tile, image::PictureFormat::kWebp,
                   image::EncodeWebp(image::RowsOf(picture), static_cast<float>(options_.quality)));
      case image::TileEncoding::kJpegWebp:
        return Put(tile, image::PictureFormat::kWebp, image::EncodeFringe(picture, options_.quality));
      case image::TileEncoding::kJpegPng:
        return Put(tile, image::PictureFormat::kPng,
                   image::EncodePicture(std::move(picture), image::PictureFormat::kPng));
    }
    SKYQUILT_CHECK(false, "an encoding outside the list");
  }
  bool is_empty() const { return min_zoom_ > max_zoom_; }
  int min_zoom() const { return min_zoom_; }
  int max_zoom() const { return max_zoom_; }

 private:
  Cover CoverOf(const geo::TileId& tile) {
    if (options_.boundary == nullptr) return Cover::kAll;
    if (!on_zoom_ || zoom_ != tile.z()) {
      on_zoom_.emplace(*options_.boundary, tile.z(), tile_size_px_);
      zoom_ = tile.z();
    }
    return on_zoom_->Mask(tile, inside_);
  }
  Result<void> Put(const geo::TileId& tile, image::PictureFormat format,
                   std::span<const std::uint8_t> bytes) {
    min_zoom_ = std::min(min_zoom_, tile.z());
    max_zoom_ = std::max(max_zoom_, tile.z());
    return writer_.Put(tile, format, bytes);
  }

  const ClipOptions& options_;
  const int tile_size_px_;
  const image::TileEncoding encoding_;
  MbtilesWriter& writer_;
  std::optional<BoundaryOnZoom> on_zoom_;
  int zoom_ = 0;
  std::vector<std::uint8_t> inside_;
  int min_zoom_ = geo::kMaxZoom + 1;
  int max_zoom_ = -1;
};

}  // namespace

Result<void> ClipTileset(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                         const ClipOptions& options, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const auto reader, MbtilesReader::Open(mbtiles));
  const auto& metadata = reader->metadata();
  SKYQUILT_TRY_ASSIGN(const MapFacts facts, FactsOfTileset(metadata));
  SKYQUILT_TRY_ASSIGN(auto db, SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable));
  SKYQUILT_TRY_ASSIGN(const std::int64_t count, CountTiles(db));
  SKYQUILT_TRY_ASSIGN(auto writer, MbtilesWriter::Create(path));
  Clip clip(options, facts.tile_size_px, EncodingOf(metadata), *writer);
  SKYQUILT_TRY_ASSIGN(auto walk, TileWalk::Of(db));
  for (std::int64_t done = 1;; ++done) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The export was cancelled.", ""};
    SKYQUILT_TRY_ASSIGN(const bool more, walk.Next());
    if (!more || walk.tile().z() > options.max_zoom) break;
    SKYQUILT_TRY(clip.Take(walk.tile(), walk.bytes()));
    progress.Report(static_cast<double>(done) / static_cast<double>(count), "cutting tiles");
  }
  if (clip.is_empty())
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kExportNothingWithin);
  TilesetMetadata written;
  written.name = TilesetText(metadata, "name");
  written.description = TilesetText(metadata, "description");
  written.attribution = TilesetText(metadata, "attribution");
  written.generator = "Skyquilt";
  written.bounds =
      options.boundary == nullptr ? facts.bounds : Common(facts.bounds, options.boundary->Bounds()).OnEarth();
  written.min_zoom = clip.min_zoom();
  written.max_zoom = clip.max_zoom();
  written.tile_size_px = facts.tile_size_px;
  return writer->Publish(written);
}

}  // namespace skyquilt::storage
