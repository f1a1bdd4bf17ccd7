// The catalogue that a test opens: SQLite at a path, or, where SKYQUILT_TEST_POSTGRES has the URL of a server
// (tests/support/postgres_server.py), a schema of its own there, the same for the same path. So the suites
// run over both.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "storage/db/catalogue_db.h"

namespace skyquilt::storage {

Result<std::unique_ptr<CatalogueDb>> OpenTestCatalogue(const std::filesystem::path& path, int readers = 2,
                                                       const std::string& node = "here");
bool TestsPostgres();
// Where it lies on the server.
CataloguePlace TestPlace(const std::filesystem::path& path);

}  // namespace skyquilt::storage
