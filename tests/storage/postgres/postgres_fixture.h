// PostgresTest: a catalogue of a test's own on the PostgreSQL server in SKYQUILT_TEST_POSTGRES; skipped where
// there is none.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "storage/catalogue/catalogue.h"
#include "storage/db/postgres/postgres_db.h"
#include "tests/storage/postgres/test_catalogue.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {

class PostgresTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!TestsPostgres()) GTEST_SKIP() << "no PostgreSQL server in SKYQUILT_TEST_POSTGRES";
    db_ = Open();
  }
  std::unique_ptr<CatalogueDb> Open(const std::string& node = "here") {
    return *OpenTestCatalogue(path(), 2, node);
  }
  std::filesystem::path path() const { return dir_.path() / "catalogue.db"; }
  std::unique_ptr<PostgresDb> Connection(PostgresDb::Use use = PostgresDb::Use::kWrite) {
    return std::make_unique<PostgresDb>(TestPlace(path()), use);
  }
  std::string NewFlight() { return Catalogue(*db_).AddFlight("f", "{}", Now())->id; }
  std::int64_t Number(const std::string& sql) {
    const auto db = db_->Lock();
    auto query = *db->Prepare(sql);
    EXPECT_TRUE(*query.Step());
    return query.ColumnInt64(0);
  }
  // Ends all other connections to the database, as a restart of the server would.
  void CutConnections() {
    PostgresDb other(TestPlace(path()), PostgresDb::Use::kWrite);
    ASSERT_TRUE(
        other.Exec("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid<>pg_backend_pid() AND"
                   " backend_type='client backend'"));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }

  test::TemporaryFolder dir_;
  std::unique_ptr<CatalogueDb> db_;
};

}  // namespace skyquilt::storage
