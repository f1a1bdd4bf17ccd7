// What only a catalogue in PostgreSQL has: its connections, its tables, and what is on its disk. Skipped
// where SKYQUILT_TEST_POSTGRES names no server; tests/storage/CMakeLists.txt runs it with one.
#include "storage/db/postgres/postgres_db.h"

#include <algorithm>
#include <atomic>
#include <set>

#include "storage/db/ids.h"
#include "storage/db/postgres/postgres_statement.h"
#include "storage/db/schema.h"
#include "storage/db/sqlite_db.h"
#include "storage/jobs/job_queue.h"
#include "tests/storage/data/earlier_versions.h"
#include "tests/storage/postgres/postgres_fixture.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

TEST_F(PostgresTest, KeepsValuesOfEveryKind) {
  const auto db = Connection();
  ASSERT_TRUE(db->Exec("CREATE TEMP TABLE v(i BIGINT, d DOUBLE PRECISION, t TEXT, b BYTEA)"));
  const std::vector<std::uint8_t> bytes{0, 1, 255, '\\', '\'', 0};
  const std::string text =
      "Fl\xc3\xa4"
      "che '; -- ? $1";
  auto insert = *db->Prepare("INSERT INTO v VALUES(?,?,?,?)");
  ASSERT_TRUE(insert.Bind(1, INT64_MIN).Bind(2, 0.1).Bind(3, text).Bind(4, bytes).Run());
  ASSERT_TRUE(insert.BindNull(1).BindNull(2).BindNull(3).BindNull(4).Run());
  EXPECT_EQ(db->Changes(), 1);
  auto query = *db->Prepare("SELECT i, d, t, b, '?' FROM v WHERE i=?1 AND ?1=i");
  ASSERT_TRUE(*query.Bind(1, INT64_MIN).Step());
  EXPECT_EQ(query.ColumnInt64(0), INT64_MIN);
  EXPECT_EQ(query.ColumnDouble(1), 0.1);
  EXPECT_EQ(query.ColumnText(2), text);
  EXPECT_TRUE(std::ranges::equal(query.ColumnBlob(3), bytes));
  EXPECT_EQ(query.ColumnText(4), "?");
  EXPECT_FALSE(*query.Step());
  auto nulls = *db->Prepare("SELECT i, b FROM v WHERE i IS NULL");
  ASSERT_TRUE(*nulls.Step());
  EXPECT_TRUE(nulls.IsNull(0));
  EXPECT_TRUE(nulls.ColumnBlob(1).empty());
}

TEST_F(PostgresTest, KeepsWhatWasBoundThoughItIsGone) {
  const auto db = Connection();
  auto query = *db->Prepare("SELECT ?1, ?2");
  std::string short_lived(100, 't');
  std::vector<std::uint8_t> short_lived_bytes(100, 7);
  query.Bind(1, short_lived).Bind(2, short_lived_bytes);
  short_lived.assign(100, 'x');
  short_lived_bytes.assign(100, 9);
  ASSERT_TRUE(*query.Step());
  EXPECT_EQ(query.ColumnText(0), std::string(100, 't'));
  EXPECT_TRUE(std::ranges::equal(query.ColumnBlob(1), std::vector<std::uint8_t>(100, 7)));
}

TEST_F(PostgresTest, RefusesTextThatItCannotStore) {
  EXPECT_EQ(test::ErrorOf(Catalogue(*db_).AddFlight(std::string("a\0b", 3), "{}", Now())).code,
            ErrorCode::kInvalidArgument);
  EXPECT_EQ(Catalogue(*db_).AddFlight("\xff\xfe", "{}", Now()).error().code, ErrorCode::kInvalidArgument);
  EXPECT_TRUE(Catalogue(*db_).AddFlight("a", "{}", Now()));  // the connection goes on
}

TEST(NumberParameters, CountsAsSqliteDoes) {
  EXPECT_EQ(NumberParameters("a=? AND b=?").text, "a=$1 AND b=$2");
  EXPECT_EQ(NumberParameters("a=?2 AND b=?1 AND c=?").text, "a=$2 AND b=$1 AND c=$3");
  EXPECT_EQ(NumberParameters("a=?12").parameters, 12);
  EXPECT_EQ(NumberParameters("a='?' AND \"?\"='it''s ?' AND b=?").text, "a='?' AND \"?\"='it''s ?' AND b=$1");
}

TEST_F(PostgresTest, GoesOnAfterTheServerCutItsConnections) {
  const std::string flight = NewFlight();
  EXPECT_TRUE(Catalogue(*db_).GetFlight(flight));
  CutConnections();
  EXPECT_TRUE(Catalogue(*db_).GetFlight(flight));
  EXPECT_TRUE(Catalogue(*db_).ChangeFlight(flight, {.name = "renamed"}));
  EXPECT_EQ(Catalogue(*db_).GetFlight(flight)->name, "renamed");
}

TEST_F(PostgresTest, ATransactionThatIsCutOffIsUndoneAndSaysSo) {
  const std::string flight = NewFlight();
  {
    const auto db = db_->Lock();
    auto transaction = test::ValueOf(Transaction::Begin(*db));
    ASSERT_TRUE(db->Exec("UPDATE flight SET name='half'"));
    CutConnections();
    EXPECT_EQ(test::ErrorOf(db->Exec("UPDATE flight SET options='[]'")).code, ErrorCode::kUnavailable);
    // Not on a new connection, behind the back of whoever believes in the first half.
    EXPECT_EQ(db->Exec("UPDATE flight SET options='[]'").error().code, ErrorCode::kUnavailable);
    EXPECT_EQ(transaction.Commit().error().code, ErrorCode::kUnavailable);
  }
  EXPECT_EQ(Catalogue(*db_).GetFlight(flight)->name, "f");
  EXPECT_EQ(Catalogue(*db_).GetFlight(flight)->options, "{}");
}

// Waits for a backend that waits so, and ends it.
void CutWhoWaits(SqlConnection& db, const std::string& event) {
  for (int tries = 0; tries < 600; ++tries) {
    const auto cut =
        db.Number("SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity WHERE wait_event=?", event);
    if (*cut > 0) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  FAIL() << "nobody waits for " << event;
}

TEST_F(PostgresTest, ACommitThatIsCutOffBeforeItHappenedIsToldSo) {
  const std::string flight = NewFlight();
  const auto other = Connection();
  // Its event cannot be numbered, so the commit waits.
  ASSERT_TRUE(other->Exec("SELECT pg_advisory_lock(hashtextextended(current_schema() || '.event', 0))"));
  ErrorCode code{};
  std::thread adding([&] {
    const auto added = Catalogue(*db_).AddFile(flight, {"a.jpg", NewId(), 1}, Now());
    ASSERT_FALSE(added);
    code = added.error().code;
    EXPECT_NE(added.error().message.find("was undone"), std::string::npos) << added.error().message;
  });
  CutWhoWaits(*other, "advisory");
  adding.join();
  EXPECT_EQ(code, ErrorCode::kUnavailable);
  EXPECT_TRUE(Catalogue(*db_).ListFiles(flight)->empty());
}

TEST_F(PostgresTest, ACommitThatIsCutOffAfterItHappenedIsASuccess) {
  const std::string flight = NewFlight();
  const auto other = Connection();
  const auto unsynced = UnsyncedCommits::Begin(*other);
  // A standby that is not there: commits happen, and their answer waits.
  ASSERT_TRUE(other->Exec("ALTER SYSTEM SET synchronous_standby_names='nobody'"));
  ASSERT_TRUE(other->Exec("SELECT pg_reload_conf()"));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  std::thread adding([&] {
    const auto added = Catalogue(*db_).AddFile(flight, {"a.jpg", NewId(), 1}, Now());
    EXPECT_TRUE(added) << added.error().detail;
  });
  CutWhoWaits(*other, "SyncRep");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  ASSERT_TRUE(other->Exec("ALTER SYSTEM RESET synchronous_standby_names"));
  ASSERT_TRUE(other->Exec("SELECT pg_reload_conf()"));
  adding.join();
  EXPECT_EQ(Catalogue(*db_).ListFiles(flight)->size(), 1u);
  EXPECT_EQ(Number("SELECT count(*) FROM event WHERE kind='file'"), 1);
}

TEST_F(PostgresTest, ACommitOfATransactionThatFailedIsNoSuccess) {
  const auto db = db_->Lock();
  auto transaction = Transaction::Begin(*db);
  ASSERT_FALSE(db->Exec("SELECT nonsense"));
  EXPECT_FALSE(transaction->Commit());
}

TEST_F(PostgresTest, SaysWhenTheServerCannotBeReachedAndShowsNoPassword) {
  PostgresDb nowhere(*CataloguePlaceFrom("postgresql://me:open-sesame@127.0.0.1:9/none"),
                     PostgresDb::Use::kWrite);
  const Error failed = test::ErrorOf(nowhere.Exec("SELECT 1"));
  EXPECT_EQ(failed.code, ErrorCode::kUnavailable);
  EXPECT_EQ((failed.message + failed.detail).find("sesame"), std::string::npos);
  EXPECT_FALSE(nowhere.Exec("SELECT 1"));
}

TEST_F(PostgresTest, EveryChangeButAClaimIsOnTheDiskBeforeItIsConfirmed) {
  // The server of the tests writes its log by itself only every ten seconds.
  const auto left_to_write = [&] {
    return Number("SELECT pg_wal_lsn_diff(pg_current_wal_insert_lsn(), pg_current_wal_flush_lsn())");
  };
  Catalogue catalogue(*db_);
  JobQueue queue(*db_);
  for (int i = 0; i < 5; ++i) {
    const std::string flight = NewFlight();  // one statement
    EXPECT_LT(left_to_write(), 300);
    ASSERT_TRUE(catalogue.AddFile(flight, {"a.jpg", NewId(), 1}, Now()));  // a transaction
    EXPECT_LT(left_to_write(), 300);
    ASSERT_TRUE(queue.Add(flight, "{}", Now()));
    EXPECT_LT(left_to_write(), 300);
    const auto lease = test::ValueOf(*queue.Claim("w", Now()));
    EXPECT_GT(left_to_write(), 300);
    ASSERT_TRUE(*queue.Dismiss(lease, Now()));
    EXPECT_LT(left_to_write(), 300);
  }
}

TEST_F(PostgresTest, ReadersCannotWrite) {
  const auto db = Connection(PostgresDb::Use::kRead);
  EXPECT_FALSE(db->Exec("UPDATE flight SET name='x'"));
}

TEST_F(PostgresTest, ManyProcessesMayMakeTheTablesAtOnce) {
  const std::filesystem::path fresh = dir_.path() / "fresh.db";
  std::vector<std::thread> makers;
  std::atomic<int> made = 0;
  for (int i = 0; i < 6; ++i) {
    makers.emplace_back([&] { made += OpenTestCatalogue(fresh).ok() ? 1 : 0; });
  }
  for (std::thread& maker : makers) maker.join();
  EXPECT_EQ(made, 6);
}

TEST_F(PostgresTest, ACatalogueOfAnotherVersionIsRefusedAndLeft) {
  ASSERT_TRUE(db_->Lock()->Exec("UPDATE catalogue_version SET version=999"));
  const Error opened = test::ErrorOf(OpenTestCatalogue(path()));
  EXPECT_EQ(opened.code, ErrorCode::kConflict);
  EXPECT_NE(opened.message.find("newer Skyquilt"), std::string::npos);
  EXPECT_EQ(Number("SELECT version FROM catalogue_version"), 999);
}

// A step ends the job, which is an event; later ones alter the table of jobs.
TEST_F(PostgresTest, ACatalogueOfVersion21IsBroughtHereWithAJobThatNobodyWouldEnd) {
  ASSERT_TRUE(JobQueue(*db_).Add(NewFlight(), "{}", Now()));
  ASSERT_TRUE(db_->Lock()->Exec("UPDATE job SET state='running', worker='units', cancel=1"));
  ASSERT_TRUE(db_->Lock()->Exec(UndoToVersion(21)));
  ASSERT_TRUE(db_->Lock()->Exec("UPDATE catalogue_version SET version=21"));
  const auto reopened = test::ValueOf(OpenTestCatalogue(path()));
  EXPECT_EQ(Number("SELECT version FROM catalogue_version"), kSchemaVersion);
  EXPECT_EQ(Number("SELECT count(*) FROM job WHERE state='dismissed' AND finished_us IS NOT NULL"), 1);
  EXPECT_EQ(Number("SELECT count(*) FROM event WHERE body LIKE '{\"state\":\"dismissed\"%'"), 1);
}

TEST_F(PostgresTest, NoneIsMadeWhereOneIsOnlyJoined) {
  const auto joined =
      CatalogueDb::OpenPostgres(TestPlace(dir_.path() / "none.db"), "here", /*may_make=*/false);
  ASSERT_FALSE(joined);
  EXPECT_EQ(joined.error().code, ErrorCode::kNotFound);
}

// "flight.name" and so on.
std::set<std::string> ColumnsOf(SqlConnection& db, const char* sql) {
  const std::vector<std::string> columns = *db.AllText(sql);
  return {columns.begin(), columns.end()};
}

TEST_F(PostgresTest, HasTheTablesAndColumnsOfSqlite) {
  auto sqlite = *SqliteDb::Open(path(), OpenMode::kReadWriteCreate);
  ASSERT_TRUE(PrepareSchema(sqlite));
  const auto here = ColumnsOf(
      sqlite,
      "SELECT m.name || '.' || c.name FROM sqlite_master m JOIN pragma_table_info(m.name) c"
      " WHERE m.type='table' AND m.name NOT LIKE 'sqlite_%' AND m.name NOT IN ('turn','age_clock')");
  const auto there = ColumnsOf(*db_->Lock(),
                               "SELECT table_name || '.' || column_name FROM information_schema.columns WHERE"
                               " table_schema=current_schema() AND table_name NOT IN"
                               " ('turn','age_clock','machine','catalogue_version')");
  EXPECT_EQ(here, there);
  // INSERT INTO revision VALUES goes by their order.
  EXPECT_EQ(*sqlite.AllText("SELECT name FROM pragma_table_info('revision') ORDER BY cid"),
            *db_->Lock()->AllText("SELECT CAST(column_name AS TEXT) FROM information_schema.columns WHERE"
                                  " table_schema=current_schema() AND table_name='revision'"
                                  " ORDER BY ordinal_position"));
}

TEST_F(PostgresTest, OrdersTextsByTheirBytesWhateverItsLocale) {
  EXPECT_EQ(Number("SELECT count(*) FROM information_schema.columns WHERE table_schema=current_schema()"
                   " AND data_type='text' AND collation_name IS DISTINCT FROM 'C'"),
            0);
}

}  // namespace
}  // namespace skyquilt::storage
