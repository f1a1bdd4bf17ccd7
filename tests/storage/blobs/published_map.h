// PublishedMapTest: a flight whose jobs publish maps, of files that a test puts into a folder.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "storage/catalogue/catalogue.h"
#include "storage/jobs/job_queue.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {

class PublishedMapTest : public testing::Test {
 protected:
  // Its revision.
  std::int64_t Published(const std::vector<MapProduct>& products) {
    EXPECT_TRUE(queue_.Add(flight_, "{}", Now()));
    const Lease lease = **queue_.Claim("w", Now());
    Revision revision;
    revision.revision = **queue_.ReserveRevision(lease);
    EXPECT_TRUE(*queue_.Publish(lease, revision, Now(), products));
    return revision.revision;
  }

  test::TemporaryFolder folder_;
  const std::filesystem::path made_ = folder_ / "made";
  std::unique_ptr<CatalogueDb> db_ = *CatalogueDb::Open(folder_ / "catalogue.db");
  Catalogue catalogue_{*db_};
  JobQueue queue_{*db_};
  const std::string flight_ = catalogue_.AddFlight("field", "{}", Now())->id;
};

}  // namespace skyquilt::storage
