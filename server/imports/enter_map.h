// EnterMap: the products of a map as the first map of a new flight in a data folder, durable when this
// returns. The caller holds the folder (OpenDataFolder). What fails leaves nothing that is shown. Errors:
// kIo, kOutOfSpace, those of the catalogue.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/folder/open_data_folder.h"

namespace skyquilt::server {

// `products`: a folder on the same disk, which becomes the map's. The id of the flight.
Result<std::string> EnterMap(const storage::OpenedDataFolder& opened, const std::filesystem::path& products,
                             const std::string& name, const std::vector<std::string>& tags);

}  // namespace skyquilt::server
