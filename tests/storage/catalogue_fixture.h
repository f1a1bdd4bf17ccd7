// CatalogueFixture: a catalogue of a test's own (SQLite, or PostgreSQL where a server's URL is in the
// environment) with its queue, in a folder that goes with the test.
#pragma once

#include <gtest/gtest.h>

#include "storage/catalogue/catalogue.h"
#include "storage/jobs/job_queue.h"
#include "tests/storage/postgres/test_catalogue.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {

class CatalogueFixture : public testing::Test {
 protected:
  explicit CatalogueFixture(int readers = 2)
      : db_(*OpenTestCatalogue(dir_.path() / "catalogue.db", readers)) {}
  // A job of a flight, which nothing waits before.
  Lease Begun(const std::string& flight, Time now, const std::string& options = "{}") {
    EXPECT_TRUE(queue_.Add(flight, options, now));
    return test::ValueOf(*queue_.Claim("w", now));
  }
  // From its beginning to its map.
  void PublishMap(const std::string& flight, Revision revision = {}) {
    const Lease lease = Begun(flight, Now());
    revision.revision = **queue_.ReserveRevision(lease);
    ASSERT_TRUE(*queue_.Publish(lease, revision, Now()));
  }

  test::TemporaryFolder dir_;
  std::unique_ptr<CatalogueDb> db_;
  Catalogue catalogue_{*db_};
  JobQueue queue_{*db_};
  Time now_ = Now();
};

}  // namespace skyquilt::storage
