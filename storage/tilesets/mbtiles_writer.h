// MbtilesWriter: a TileSink that builds one MBTiles 1.3 file. Tiles are stored once however often they occur;
// the key of the bytes is also their ETag. Written under `<path>.tmp` and published by
// rename after fsync, so a crash leaves no half file under the final name; what a killed process leaves under
// the temporary one is whole up to the last Commit. One thread at a time. Format:
// https://github.com/mapbox/mbtiles-spec 1.3 (rows counted from the south); deduplicated as tiles_shallow +
// tiles_data behind a view `tiles`. tiles_shallow also has how many bytes each tile takes and of which format
// it is (0 JPEG, 1 WebP, 2 PNG), so that what other formats would look like is known without a look at the
// tiles (storage/exports/stored_tiles.h). Errors: kOutOfSpace, kIo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "core/geo/lat_lon_bounds.h"
#include "core/pyramid/tile_sink.h"

namespace skyquilt::storage {

// The key of a tile's bytes in tiles_data; where other bytes have it, theirs is the next that is free.
std::int64_t ContentIdOf(std::span<const std::uint8_t> bytes);

struct TilesetMetadata {
  std::string name;
  std::string description;
  std::string attribution;
  geo::LatLonBounds bounds;
  int min_zoom = 0;
  int max_zoom = 0;
  int tile_size_px = 256;
  std::string version = "1";
  std::string generator;
};

class MbtilesWriter final : public pyramid::TileSink {
 public:
  static Result<std::unique_ptr<MbtilesWriter>> Create(const std::filesystem::path& path);
  ~MbtilesWriter() override;  // removes the temporary file unless Publish succeeded

  Result<void> Put(const geo::TileId& tile, image::PictureFormat format,
                   std::span<const std::uint8_t> bytes) override;
  // Tiles put so far survive the process.
  Result<void> Commit();
  // Writes the metadata, checks the file and gives it its name.
  Result<void> Publish(const TilesetMetadata& metadata);

 private:
  struct State;
  explicit MbtilesWriter(std::unique_ptr<State> state);
  Result<const char*> NamedFormat();
  std::unique_ptr<State> state_;
};

}  // namespace skyquilt::storage
