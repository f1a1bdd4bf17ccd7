// WorkerTest: what a worker has to work with, over a data folder and a catalogue of the test's own.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <memory>

#include "server/jobs/worker_context.h"
#include "storage/blobs/folder_blobs.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::server {

class WorkerTest : public testing::Test {
 protected:
  // As another process, on another machine.
  WorkerContext Worker() {
    WorkerContext context{dir_, blobs_, catalogue_, queue_, costs_, units_, is_stopping_};
    context.is_shared = true;
    return context;
  }
  storage::Lease Claimed() { return **queue_.Claim("w", storage::Now()); }

  test::TemporaryFolder folder_;
  storage::DataDir dir_ = *storage::DataDir::Open(folder_.path() / "data");
  std::unique_ptr<storage::CatalogueDb> db_ = *storage::CatalogueDb::Open(folder_.path() / "catalogue.db");
  storage::FolderBlobs blobs_{folder_.path() / "data"};
  storage::Catalogue catalogue_{*db_};
  storage::JobQueue queue_{*db_};
  storage::StageCosts costs_{*db_};
  storage::UnitQueue units_{*db_};
  std::atomic<bool> is_stopping_ = false;
};

}  // namespace skyquilt::server
