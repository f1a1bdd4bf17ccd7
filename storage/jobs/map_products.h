// MapProducts: what the files of a published map are, by their SHA-256 in the catalogue, so that whoever can
// write to the store of photos and maps alone cannot replace a map. Of maps that were published into the data
// folder, or by versions before, nothing is known. Frames of films are no products of the map. Any thread.
// Errors: kIo and those of the catalogue.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"

namespace skyquilt::storage {

struct MapProduct {
  std::string name;    // below the map's prefix
  std::string sha256;  // in hex
};

// Of the files in the folder of a map, and of what a store keeps beside them.
Result<std::vector<MapProduct>> ProductsIn(const std::filesystem::path& folder);

// For the transaction that shows the map.
Result<void> EnterProducts(SqlConnection& db, const std::string& flight_id, std::int64_t revision,
                           const std::vector<MapProduct>& products);
// Of all maps: they were moved, and what is beside them may be made anew.
Result<void> ForgetProducts(SqlConnection& db);

// Of a published map; none where nothing is known.
Result<std::vector<MapProduct>> KnownProducts(CatalogueDb& db, const std::string& flight_id,
                                              std::int64_t revision);
// Of a blob of a map; empty where its map has none of that name, nothing where it is not known.
Result<std::optional<std::string>> PublishedSum(CatalogueDb& db, const std::string& key);

}  // namespace skyquilt::storage
