// A catalogue of a test's own (SQLite, or PostgreSQL where a server's URL is in the environment) with one
// flight of one file in it, and what works on it.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "storage/catalogue/catalogue.h"
#include "storage/catalogue/trash.h"
#include "storage/jobs/job_queue.h"
#include "storage/uploads/upload_spool.h"
#include "tests/storage/postgres/test_catalogue.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {

class StoredFlightTest : public testing::Test {
 protected:
  StoredFlightTest()
      : data_(*DataDir::Open(dir_.path())),
        db_(*OpenTestCatalogue(data_.Catalogue())),
        catalogue_(*db_),
        queue_(*db_),
        store_(data_),
        spool_(*db_, catalogue_, store_),
        trash_(*db_),
        flight_(catalogue_.AddFlight("field", "{}", Now(), "owner")->id) {
    EXPECT_TRUE(catalogue_.AddFile(flight_, {"a.jpg", "stored", 7}, Now()));
  }

  // A job of it, from its beginning to its map.
  void Publish() {
    ASSERT_TRUE(queue_.Add(flight_, "{}", Now()));
    const Lease lease = **queue_.Claim("w", Now());
    Revision revision;
    revision.revision = **queue_.ReserveRevision(lease);
    revision.bounds = {10, 50, 10.1, 50.1};
    ASSERT_TRUE(*queue_.Publish(lease, revision, Now()));
  }

  test::TemporaryFolder dir_;
  DataDir data_;
  std::unique_ptr<CatalogueDb> db_;
  Catalogue catalogue_;
  JobQueue queue_;
  PhotoStore store_;
  UploadSpool spool_;
  Trash trash_;
  std::string flight_;
};

}  // namespace skyquilt::storage
