#include "storage/db/sqlite_db.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

TEST(SqliteDb, GivesBackWhatWasBound) {
  test::TemporaryFolder dir;
  auto db = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadWriteCreate);
  ASSERT_TRUE(db) << db.error().detail;
  ASSERT_TRUE(db->Exec("CREATE TABLE t(a INTEGER, b REAL, c TEXT, d BLOB, e)"));
  const std::vector<std::uint8_t> bytes = {0, 1, 255};
  {
    auto insert = db->Prepare("INSERT INTO t VALUES(?,?,?,?,?)");
    ASSERT_TRUE(insert);
    insert->Bind(1, std::int64_t{1} << 62).Bind(2, 1.5).Bind(3, "a\"'é").Bind(4, bytes).BindNull(5);
    ASSERT_TRUE(insert->Run());
  }
  auto select = db->Prepare("SELECT a,b,c,d,e FROM t");
  ASSERT_TRUE(select);
  const auto row = select->Step();
  ASSERT_TRUE(row);
  ASSERT_TRUE(*row);
  EXPECT_EQ(select->ColumnInt64(0), std::int64_t{1} << 62);
  EXPECT_EQ(select->ColumnDouble(1), 1.5);
  EXPECT_EQ(select->ColumnText(2), "a\"'é");
  EXPECT_TRUE(std::ranges::equal(select->ColumnBlob(3), bytes));
  EXPECT_TRUE(select->IsNull(4));
  EXPECT_FALSE(*select->Step());
}

TEST(SqliteDb, ReadsAndWritesInOneCall) {
  test::TemporaryFolder dir;
  auto db = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadWriteCreate);
  ASSERT_TRUE(db->Exec("CREATE TABLE t(a INTEGER, b TEXT)"));
  const auto text_of = [](const Statement& row) { return std::string(row.ColumnText(0)); };
  for (const std::optional<std::string>& b : {std::optional<std::string>("one"), {}}) {
    ASSERT_TRUE(db->Change("INSERT INTO t VALUES(?,?)", b ? 1 : 2, b));
    EXPECT_EQ(db->Changes(), 1);
  }
  EXPECT_EQ(*db->Number("SELECT count(*) FROM t WHERE b IS NULL AND a=?", 2), 1);
  EXPECT_EQ(*db->Number("SELECT a FROM t WHERE a=?", 3), 0);
  EXPECT_TRUE(*db->Finds("SELECT 1 FROM t WHERE b=?", "one"));
  EXPECT_FALSE(*db->Finds("SELECT 1 FROM t WHERE b=?", "two"));
  auto all = db->Query("SELECT coalesce(b,'-') FROM t WHERE a<? ORDER BY a", 3);
  EXPECT_EQ(*all->All(text_of), (std::vector<std::string>{"one", "-"}));
  all->Reset();
  EXPECT_EQ(*all->First(text_of), "one");
  auto none = db->Query("SELECT b FROM t WHERE a=?", 3);
  EXPECT_FALSE(none->First(text_of)->has_value());
  // A row of RETURNING comes before the statement is done.
  auto other = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadWrite);
  auto taken = db->Query("UPDATE t SET a=a+? WHERE b='one' RETURNING a", 5);
  EXPECT_EQ(*taken->Number(), 6);
  EXPECT_EQ(*other->Number("SELECT max(a) FROM t"), 6);
}

TEST(SqliteDb, KeepsWhatWasBoundThoughItIsGone) {
  test::TemporaryFolder dir;
  auto db = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadWriteCreate);
  auto query = db->Prepare("SELECT ?1, ?2");
  ASSERT_TRUE(query);
  const std::string text(100, 't');
  const std::vector<std::uint8_t> bytes(100, 7);
  {
    std::string short_lived = text;
    std::vector<std::uint8_t> short_lived_bytes = bytes;
    query->Bind(1, short_lived).Bind(2, short_lived_bytes);
    short_lived.assign(100, 'x');  // as whoever is given the memory next would
    short_lived_bytes.assign(100, 9);
  }
  ASSERT_TRUE(*query->Step());
  EXPECT_EQ(query->ColumnText(0), text);
  EXPECT_TRUE(std::ranges::equal(query->ColumnBlob(1), bytes));
}

// Values of many sizes whose pages lie in pieces: what was removed makes room for others.
void FillInPieces(SqliteDb& db) {
  ASSERT_TRUE(db.Exec("CREATE TABLE t(id INTEGER PRIMARY KEY, size INTEGER, value BLOB)"));
  ASSERT_TRUE(
      db.Exec("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<120)"
              " INSERT INTO t SELECT i, i*i*17%90001, randomblob(i*i*17%90001) FROM n;"
              " DELETE FROM t WHERE id%3=0; INSERT INTO t SELECT id+200, size*3, randomblob(size*3) FROM t"));
}

std::uint64_t SumOf(std::span<const std::uint8_t> bytes) {
  std::uint64_t sum = bytes.size();
  for (const std::uint8_t byte : bytes) sum = sum * 31 + byte;
  return sum;
}

TEST(SqliteDb, ReadsWhatNeverChangesAsItWasWritten) {
  test::TemporaryFolder dir;
  std::vector<std::uint64_t> written, first, second;
  for (const char* name : {"a.db", "b.db"}) {
    auto db = SqliteDb::Open(dir.path() / name, OpenMode::kReadWriteCreate);
    ASSERT_NO_FATAL_FAILURE(FillInPieces(*db));
    auto all = db->Prepare("SELECT value FROM t ORDER BY id");
    while (*all->Step()) written.push_back(SumOf(all->ColumnBlob(0)));
  }
  // One thread with two files, in turns.
  auto a = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadOnlyImmutable);
  auto b = SqliteDb::Open(dir.path() / "b.db", OpenMode::kReadOnlyImmutable);
  ASSERT_TRUE(a && b);
  auto of_a = a->Prepare("SELECT value FROM t ORDER BY id");
  auto of_b = b->Prepare("SELECT value FROM t ORDER BY id");
  while (*of_a->Step() && *of_b->Step()) {
    first.push_back(SumOf(of_a->ColumnBlob(0)));
    second.push_back(SumOf(of_b->ColumnBlob(0)));
  }
  first.insert(first.end(), second.begin(), second.end());
  EXPECT_EQ(first, written);
}

TEST(SqliteDb, SaysThatAFileWasCutOffWhileItIsRead) {
  test::TemporaryFolder dir;
  {
    auto db = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadWriteCreate);
    ASSERT_NO_FATAL_FAILURE(FillInPieces(*db));
  }
  auto db = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadOnlyImmutable);
  auto all = db->Prepare("SELECT value FROM t ORDER BY id");
  ASSERT_TRUE(*all->Step());
  std::filesystem::resize_file(dir.path() / "a.db", std::filesystem::file_size(dir.path() / "a.db") / 2);
  Result<bool> row = true;
  while (row && *row) row = all->Step();
  EXPECT_FALSE(row);
}

TEST(SqliteDb, RollsBackATransactionThatWasNotCommitted) {
  test::TemporaryFolder dir;
  auto db = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadWriteCreate);
  ASSERT_TRUE(db->Exec("CREATE TABLE t(a INTEGER)"));
  {
    auto transaction = Transaction::Begin(*db);
    ASSERT_TRUE(transaction);
    ASSERT_TRUE(db->Exec("INSERT INTO t VALUES(1)"));
  }
  auto count = db->Prepare("SELECT count(*) FROM t");
  ASSERT_TRUE(*count->Step());
  EXPECT_EQ(count->ColumnInt64(0), 0);
}

TEST(SqliteDb, SaysWhenAFileIsNotADatabase) {
  test::TemporaryFolder dir;
  std::ofstream(dir.path() / "a.db") << std::string(5000, 'x');
  const auto db = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadOnlyImmutable);
  ASSERT_FALSE(db);
  EXPECT_EQ(db.error().code, ErrorCode::kCorrupt);
}

TEST(SqliteDb, SaysWhenAFileIsMissing) {
  test::TemporaryFolder dir;
  const auto db = SqliteDb::Open(dir.path() / "none.db", OpenMode::kReadOnlyImmutable);
  ASSERT_FALSE(db);
  EXPECT_EQ(db.error().code, ErrorCode::kNotFound);
}

TEST(SqliteDb, OpensImmutableFilesWithOddNames) {
  test::TemporaryFolder dir;
  const auto path = dir.path() / "a?b=%41#c d.db";
  {
    auto db = SqliteDb::Open(path, OpenMode::kReadWriteCreate);
    ASSERT_TRUE(db->Exec("CREATE TABLE t(a); INSERT INTO t VALUES(7)"));
  }
  auto db = SqliteDb::Open(path, OpenMode::kReadOnlyImmutable);
  ASSERT_TRUE(db) << db.error().detail;
  auto select = db->Prepare("SELECT a FROM t");
  ASSERT_TRUE(*select->Step());
  EXPECT_EQ(select->ColumnInt64(0), 7);
}

TEST(SqliteDb, NamesThePlaceThatCannotBeWritten) {
  test::TemporaryFolder dir;
  const auto db = SqliteDb::Open(dir.path() / "none" / "a.db", OpenMode::kReadWriteCreate);
  ASSERT_FALSE(db);
  EXPECT_EQ(db.error().code, ErrorCode::kIo);
  EXPECT_NE(db.error().message.find((dir.path() / "none" / "a.db").string()), std::string::npos)
      << db.error().message;
}

TEST(SqliteDb, ReportsAFullDatabaseAsOutOfSpace) {
  test::TemporaryFolder dir;
  auto db = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadWriteCreate);
  ASSERT_TRUE(db->Exec("CREATE TABLE t(a); PRAGMA max_page_count=4"));
  const auto full = db->Exec("INSERT INTO t VALUES(zeroblob(100000))");
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().code, ErrorCode::kOutOfSpace);
}

TEST(SqliteDb, ReportsAConstraintAsAConflict) {
  test::TemporaryFolder dir;
  auto db = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadWriteCreate);
  ASSERT_TRUE(db->Exec("CREATE TABLE t(a INTEGER UNIQUE); INSERT INTO t VALUES(1)"));
  auto insert = db->Prepare("INSERT INTO t VALUES(?)");
  const auto twice = insert->Bind(1, 1).Run();
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().code, ErrorCode::kConflict);
  EXPECT_TRUE(insert->Bind(1, 2).Run());
}

std::int64_t PragmaOf(SqliteDb& db, const std::string& name) {
  auto query = db.Prepare("PRAGMA " + name);
  return query && query->Step() ? query->ColumnInt64(0) : -1;
}

TEST(SqliteDb, WaitsForTheDiskAgainAfterUnsyncedCommits) {
  test::TemporaryFolder dir;
  auto db = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadWriteCreate);
  ASSERT_TRUE(db->Exec("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; CREATE TABLE t(a)"));
  {
    const auto unsynced = UnsyncedCommits::Begin(*db);
    ASSERT_TRUE(unsynced);
    EXPECT_EQ(PragmaOf(*db, "synchronous"), 1);  // NORMAL
    EXPECT_EQ(PragmaOf(*db, "wal_autocheckpoint"), 0);
    auto rolled_back = Transaction::Begin(*db);
    ASSERT_TRUE(db->Exec("INSERT INTO t VALUES(1)"));
  }
  EXPECT_EQ(PragmaOf(*db, "synchronous"), 2);  // FULL
  EXPECT_EQ(PragmaOf(*db, "wal_autocheckpoint"), 1000);
  auto other = SqliteDb::Open(dir.path() / "a.db", OpenMode::kReadWrite);
  {
    const auto unsynced = UnsyncedCommits::Begin(*db);
    ASSERT_TRUE(unsynced);
    ASSERT_TRUE(db->Exec("INSERT INTO t VALUES(2)"));
  }
  auto seen = other->Prepare("SELECT sum(a) FROM t");
  ASSERT_TRUE(*seen->Step());
  EXPECT_EQ(seen->ColumnInt64(0), 2);
}

}  // namespace
}  // namespace skyquilt::storage
