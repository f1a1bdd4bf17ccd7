// ServedFolder: the fixture of tests that serve: an empty data folder, opened, and what handlers get of it.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "api/service.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::server {

class ServedFolder : public testing::Test {
 protected:
  ServedFolder()
      : dir_(*storage::DataDir::Open(scratch_.path())),
        db_(*storage::CatalogueDb::Open(dir_.Catalogue())),
        catalogue_(*db_),
        queue_(*db_),
        store_(dir_),
        tilesets_(dir_, catalogue_),
        service_{catalogue_, queue_, store_, tilesets_, metrics_, *db_, "test"} {}

  test::TemporaryFolder scratch_;
  storage::DataDir dir_;
  std::unique_ptr<storage::CatalogueDb> db_;
  storage::Catalogue catalogue_;
  storage::JobQueue queue_;
  storage::PhotoStore store_;
  storage::TilesetCache tilesets_;
  api::Metrics metrics_;
  api::Service service_;
};

}  // namespace skyquilt::server
