// Little tilesets for tests of reading and serving, in every schema that is in use.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "storage/catalogue/catalogue.h"
#include "storage/db/catalogue_db.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

enum class TilesetSchema { kFlat, kIntegerKeys, kTextKeys };

// `row` counts from the south, as in the file.
struct SmallTile {
  int z;
  int x;
  int row;
  std::string bytes;
};

// Of tiles that begin as WebP the fringe is said to be WebP, as the writer of maps would.
void WriteSmallTileset(const std::filesystem::path& path, TilesetSchema schema,
                       const std::vector<SmallTile>& tiles, int tile_size_px = 256);

// The whole way of a job: queued, claimed, files in place, published. Answers the revision. `facts`: what the
// catalogue is told of it beside its number and zooms; without them it covers the world.
std::int64_t PublishSmallTileset(const DataDir& dir, CatalogueDb& db, const std::string& flight_id,
                                 const std::vector<SmallTile>& tiles, int tile_size_px = 256,
                                 const std::optional<Revision>& facts = std::nullopt);

}  // namespace skyquilt::storage
