#include "storage/db/sqlite_db.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <vector>

#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

class SqliteDbTest : public testing::Test {
 protected:
  Result<SqliteDb> Open(const char* name = "a.db", OpenMode mode = OpenMode::kReadWriteCreate) {
    return SqliteDb::Open(dir_.path() / name, mode);
  }
  test::TemporaryFolder dir_;
};

TEST_F(SqliteDbTest, GivesBackWhatWasBound) {
  auto db = test::ValueOf(Open());
  ASSERT_TRUE(db.Exec("CREATE TABLE t(a INTEGER, b REAL, c TEXT, d BLOB, e)"));
  const std::vector<std::uint8_t> bytes = {0, 1, 255};
  {
    auto insert = test::ValueOf(db.Prepare("INSERT INTO t VALUES(?,?,?,?,?)"));
    insert.Bind(1, std::int64_t{1} << 62).Bind(2, 1.5).Bind(3, "a\"'é").Bind(4, bytes).BindNull(5);
    ASSERT_TRUE(insert.Run());
  }
  auto select = test::ValueOf(db.Prepare("SELECT a,b,c,d,e FROM t"));
  ASSERT_TRUE(*select.Step());
  EXPECT_EQ(select.ColumnInt64(0), std::int64_t{1} << 62);
  EXPECT_EQ(select.ColumnDouble(1), 1.5);
  EXPECT_EQ(select.ColumnText(2), "a\"'é");
  EXPECT_TRUE(std::ranges::equal(select.ColumnBlob(3), bytes));
  EXPECT_TRUE(select.IsNull(4));
  EXPECT_FALSE(*select.Step());
}

TEST_F(SqliteDbTest, ReadsAndWritesInOneCall) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE t(a INTEGER, b TEXT)"));
  for (const std::optional<std::string>& b : {std::optional<std::string>("one"), {}}) {
    ASSERT_TRUE(db->Change("INSERT INTO t VALUES(?,?)", b ? 1 : 2, b));
    EXPECT_EQ(db->Changes(), 1);
  }
  EXPECT_EQ(*db->Number("SELECT count(*) FROM t WHERE b IS NULL AND a=?", 2), 1);
  EXPECT_EQ(*db->Number("SELECT a FROM t WHERE a=?", 3), 0);
  EXPECT_TRUE(*db->Finds("SELECT 1 FROM t WHERE b=?", "one"));
  EXPECT_FALSE(*db->Finds("SELECT 1 FROM t WHERE b=?", "two"));
  constexpr const char* kUnder = "SELECT coalesce(b,'-') FROM t WHERE a<? ORDER BY a";
  EXPECT_EQ(*db->AllText(kUnder, 3), (std::vector<std::string>{"one", "-"}));
  EXPECT_EQ(*db->First(FirstColumn<std::string>, kUnder, 3), "one");
  EXPECT_EQ(*db->Text(kUnder, 3), "one");
  EXPECT_EQ(*db->Text(kUnder, 1), "");
  const Error none{ErrorCode::kNotFound, "", ""};
  EXPECT_EQ(*db->One(FirstColumn<std::string>, none, kUnder, 3), "one");
  EXPECT_EQ(db->One(FirstColumn<std::string>, none, kUnder, 1).error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(db->First(FirstColumn<std::string>, kUnder, 1)->has_value());
  using Row = std::pair<int, std::optional<std::string>>;
  EXPECT_EQ((*db->All(RowOf<Row, int, std::optional<std::string>>, "SELECT a, b FROM t ORDER BY a")),
            (std::vector<Row>{{1, "one"}, {2, std::nullopt}}));
  // A row of RETURNING comes before the statement is done.
  auto other = Open("a.db", OpenMode::kReadWrite);
  auto taken = db->Query("UPDATE t SET a=a+? WHERE b='one' RETURNING a", 5);
  EXPECT_EQ(*taken->Number(), 6);
  EXPECT_EQ(*other->Number("SELECT max(a) FROM t"), 6);
}

TEST_F(SqliteDbTest, KeepsWhatWasBoundThoughItIsGone) {
  auto db = Open();
  auto query = test::ValueOf(db->Prepare("SELECT ?1, ?2"));
  const std::string text(100, 't');
  const std::vector<std::uint8_t> bytes(100, 7);
  {
    std::string short_lived = text;
    std::vector<std::uint8_t> short_lived_bytes = bytes;
    query.Bind(1, short_lived).Bind(2, short_lived_bytes);
    short_lived.assign(100, 'x');  // as whoever is given the memory next would
    short_lived_bytes.assign(100, 9);
  }
  ASSERT_TRUE(*query.Step());
  EXPECT_EQ(query.ColumnText(0), text);
  EXPECT_TRUE(std::ranges::equal(query.ColumnBlob(1), bytes));
}

// Values of many sizes whose pages lie in pieces: what was removed makes room for others.
void FillInPieces(SqliteDb& db) {
  ASSERT_TRUE(db.Exec("CREATE TABLE t(id INTEGER PRIMARY KEY, size INTEGER, value BLOB)"));
  ASSERT_TRUE(
      db.Exec("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<120)"
              " INSERT INTO t SELECT i, i*i*17%90001, randomblob(i*i*17%90001) FROM n;"
              " DELETE FROM t WHERE id%3=0; INSERT INTO t SELECT id+200, size*3, randomblob(size*3) FROM t"));
}

std::uint64_t SumOf(const auto& bytes) {
  std::uint64_t sum = bytes.size();
  for (const auto byte : bytes) sum = sum * 31 + static_cast<std::uint8_t>(byte);
  return sum;
}

TEST_F(SqliteDbTest, ReadsWhatNeverChangesAsItWasWritten) {
  std::vector<std::uint64_t> written, first, second, blobs_of_a, blobs_of_b;
  std::vector<std::int64_t> ids;
  for (const char* name : {"a.db", "b.db"}) {
    auto db = Open(name);
    ASSERT_NO_FATAL_FAILURE(FillInPieces(*db));
    auto all = db->Prepare("SELECT value, id FROM t ORDER BY id");
    ids.clear();
    while (*all->Step()) {
      written.push_back(SumOf(all->ColumnBlob(0)));
      ids.push_back(all->ColumnInt64(1));
    }
  }
  // One thread with two files, in turns.
  auto a = Open("a.db", OpenMode::kReadOnlyImmutable);
  auto b = Open("b.db", OpenMode::kReadOnlyImmutable);
  ASSERT_TRUE(a && b);
  auto of_a = a->Prepare("SELECT value FROM t ORDER BY id");
  auto of_b = b->Prepare("SELECT value FROM t ORDER BY id");
  while (*of_a->Step() && *of_b->Step()) {
    first.push_back(SumOf(of_a->ColumnBlob(0)));
    second.push_back(SumOf(of_b->ColumnBlob(0)));
  }
  first.insert(first.end(), second.begin(), second.end());
  EXPECT_EQ(first, written);
  SqliteBlobs in_a = a->Blobs("t", "value"), in_b = b->Blobs("t", "value");
  for (const std::int64_t id : ids) {
    blobs_of_a.push_back(SumOf(test::ValueOf(in_a.Read(id))));
    blobs_of_b.push_back(SumOf(test::ValueOf(in_b.Read(id))));
  }
  blobs_of_a.insert(blobs_of_a.end(), blobs_of_b.begin(), blobs_of_b.end());
  EXPECT_EQ(blobs_of_a, written);
}

TEST_F(SqliteDbTest, ReadsBlobsWithoutAStatement) {
  {
    auto db = Open();
    ASSERT_TRUE(
        db->Exec("CREATE TABLE t(id INTEGER PRIMARY KEY, value);"
                 "INSERT INTO t VALUES(1, x'616263'), (2, zeroblob(50000)), (3, x''), (4, NULL);"
                 "CREATE TABLE w(id INTEGER PRIMARY KEY, value BLOB) WITHOUT ROWID;"
                 "INSERT INTO w VALUES(1, x'61')"));
  }
  auto db = test::ValueOf(Open("a.db", OpenMode::kReadOnlyImmutable));
  SqliteBlobs blobs = db.Blobs("t", "value");
  EXPECT_EQ(blobs.Read(1), "abc");
  EXPECT_EQ(blobs.Read(2), std::string(50'000, '\0'));
  EXPECT_EQ(blobs.Read(3), "");
  EXPECT_EQ(blobs.Read(1), "abc");
  for (const std::int64_t none : {4, 5}) {
    SqliteBlobs others = db.Blobs("t", "value");
    EXPECT_EQ(others.Read(none), std::nullopt);
    EXPECT_EQ(others.Read(1), std::nullopt);
  }
  EXPECT_EQ(db.Blobs("w", "value").Read(1), std::nullopt);
  EXPECT_EQ(db.Blobs("none", "value").Read(1), std::nullopt);
}

// What this thread has read so far, and by how many calls; absent: the system does not say.
struct HasRead {
  std::int64_t bytes = 0, calls = 0;
};
std::optional<HasRead> ReadSoFar() {
  std::ifstream io("/proc/thread-self/io");
  std::string bytes, written, calls;
  HasRead read;
  std::int64_t wrote = 0;
  if (io >> bytes >> read.bytes >> written >> wrote >> calls >> read.calls && calls == "syscr:") return read;
  return std::nullopt;
}

TEST_F(SqliteDbTest, ReadsAValueByFewCallsAndLittleMoreThanItHas) {
  {
    auto db = Open();
    ASSERT_TRUE(
        db->Exec("CREATE TABLE t(id INTEGER PRIMARY KEY, value BLOB);"
                 "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i+1 FROM n WHERE i<30)"
                 " INSERT INTO t SELECT i, randomblob(10000 * (1 + i % 9)) FROM n"));
  }
  auto db = Open("a.db", OpenMode::kReadOnlyImmutable);
  SqliteBlobs blobs = db->Blobs("t", "value");
  ASSERT_TRUE(blobs.Read(1));
  for (const std::int64_t id : {9, 17}) {
    const std::optional<HasRead> before = ReadSoFar();
    if (!before) GTEST_SKIP() << "the system does not say what a thread reads";
    const auto size = static_cast<std::int64_t>(test::ValueOf(blobs.Read(id)).size());
    const HasRead after = *ReadSoFar();
    // A leaf and the value's pages; and what it takes to ask.
    EXPECT_LT(after.bytes - before->bytes, size + 16'000) << id;
    EXPECT_LE(after.calls - before->calls, 8) << id;
  }
}

TEST_F(SqliteDbTest, SaysThatAFileWasCutOffWhileItIsRead) {
  {
    auto db = Open();
    ASSERT_NO_FATAL_FAILURE(FillInPieces(*db));
  }
  auto db = Open("a.db", OpenMode::kReadOnlyImmutable);
  auto all = db->Prepare("SELECT value FROM t ORDER BY id");
  ASSERT_TRUE(*all->Step());
  std::filesystem::resize_file(dir_.path() / "a.db", std::filesystem::file_size(dir_.path() / "a.db") / 2);
  Result<bool> row = true;
  while (row && *row) row = all->Step();
  EXPECT_FALSE(row);
}

TEST_F(SqliteDbTest, RollsBackATransactionThatWasNotCommitted) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE t(a INTEGER)"));
  {
    auto transaction = test::ValueOf(Transaction::Begin(*db));
    ASSERT_TRUE(db->Exec("INSERT INTO t VALUES(1)"));
  }
  EXPECT_EQ(*db->Number("SELECT count(*) FROM t"), 0);
}

TEST_F(SqliteDbTest, SaysWhenAFileIsNotADatabase) {
  std::ofstream(dir_.path() / "a.db") << std::string(5000, 'x');
  EXPECT_EQ(test::ErrorOf(Open("a.db", OpenMode::kReadOnlyImmutable)).code, ErrorCode::kCorrupt);
}

TEST_F(SqliteDbTest, SaysWhenAFileIsMissing) {
  EXPECT_EQ(test::ErrorOf(Open("none.db", OpenMode::kReadOnlyImmutable)).code, ErrorCode::kNotFound);
}

TEST_F(SqliteDbTest, OpensImmutableFilesWithOddNames) {
  const auto path = dir_.path() / "a?b=%41#c d.db";
  {
    auto db = SqliteDb::Open(path, OpenMode::kReadWriteCreate);
    ASSERT_TRUE(db->Exec("CREATE TABLE t(a); INSERT INTO t VALUES(7)"));
  }
  auto db = test::ValueOf(SqliteDb::Open(path, OpenMode::kReadOnlyImmutable));
  EXPECT_EQ(*db.Number("SELECT a FROM t"), 7);
}

TEST_F(SqliteDbTest, NamesThePlaceThatCannotBeWritten) {
  const Error db = test::ErrorOf(SqliteDb::Open(dir_.path() / "none" / "a.db", OpenMode::kReadWriteCreate));
  EXPECT_EQ(db.code, ErrorCode::kIo);
  EXPECT_NE(db.message.find((dir_.path() / "none" / "a.db").string()), std::string::npos) << db.message;
}

TEST_F(SqliteDbTest, ReportsAFullDatabaseAsOutOfSpace) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE t(a); PRAGMA max_page_count=4"));
  EXPECT_EQ(test::ErrorOf(db->Exec("INSERT INTO t VALUES(zeroblob(100000))")).code, ErrorCode::kOutOfSpace);
}

TEST_F(SqliteDbTest, ReportsAConstraintAsAConflict) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("CREATE TABLE t(a INTEGER UNIQUE); INSERT INTO t VALUES(1)"));
  auto insert = db->Prepare("INSERT INTO t VALUES(?)");
  EXPECT_EQ(test::ErrorOf(insert->Bind(1, 1).Run()).code, ErrorCode::kConflict);
  EXPECT_TRUE(insert->Bind(1, 2).Run());
}

TEST_F(SqliteDbTest, WaitsForTheDiskAgainAfterUnsyncedCommits) {
  auto db = Open();
  ASSERT_TRUE(db->Exec("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; CREATE TABLE t(a)"));
  {
    const auto unsynced = test::ValueOf(UnsyncedCommits::Begin(*db));
    EXPECT_EQ(*db->Number("PRAGMA synchronous"), 1);  // NORMAL
    EXPECT_EQ(*db->Number("PRAGMA wal_autocheckpoint"), 0);
    auto rolled_back = Transaction::Begin(*db);
    ASSERT_TRUE(db->Exec("INSERT INTO t VALUES(1)"));
  }
  EXPECT_EQ(*db->Number("PRAGMA synchronous"), 2);  // FULL
  EXPECT_EQ(*db->Number("PRAGMA wal_autocheckpoint"), 1000);
  auto other = Open("a.db", OpenMode::kReadWrite);
  {
    const auto unsynced = test::ValueOf(UnsyncedCommits::Begin(*db));
    ASSERT_TRUE(db->Exec("INSERT INTO t VALUES(2)"));
  }
  EXPECT_EQ(*other->Number("SELECT sum(a) FROM t"), 2);
}

}  // namespace
}  // namespace skyquilt::storage
