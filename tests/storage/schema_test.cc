#include "storage/db/schema.h"

#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <string_view>

#include "storage/catalogue/catalogue.h"
#include "tests/storage/data/earlier_versions.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {

extern const std::string_view kCatalogue13;  // tests/storage/data/catalogue_13.sql

namespace {

// What the catalogue consists of, without comments and line breaks.
std::map<std::string, std::string> Parts(SqliteDb& db) {
  std::map<std::string, std::string> parts;
  auto query = *db.Prepare("SELECT type || ' ' || name, coalesce(sql, '') FROM sqlite_master");
  while (*query.Step()) {
    std::string sql(query.ColumnText(1));
    sql = std::regex_replace(sql, std::regex("--[^\n]*"), "");
    sql = std::regex_replace(sql, std::regex("\\s+"), " ");
    sql = std::regex_replace(sql, std::regex("\\s*([(),=])\\s*"), "$1");
    parts[std::string(query.ColumnText(0))] = std::regex_replace(sql, std::regex("\"event\""), "event");
  }
  return parts;
}

class SchemaTest : public testing::Test {
 protected:
  SqliteDb Make(const std::string& sql) const {
    auto db = *SqliteDb::Open(path(), OpenMode::kReadWriteCreate);
    const auto made = db.Exec(sql);
    EXPECT_TRUE(made) << made.error().detail;
    return db;
  }
  void ExpectToBeBroughtToThisOne(int version) const {
    std::string id;
    {
      const auto db = CatalogueDb::Open(path());
      id = Catalogue(**db).AddFlight("f", "{}", Now())->id;
    }
    SqliteDb db = Make("");
    const auto parts = Parts(db);
    const auto undone = db.Exec(UndoToVersion(version) + "PRAGMA user_version=" + std::to_string(version));
    ASSERT_TRUE(undone) << undone.error().detail;
    ASSERT_NE(Parts(db), parts);
    const auto opened = test::ValueOf(CatalogueDb::OpenExisting(path()));
    EXPECT_EQ(Parts(db), parts);
    const auto flight = test::ValueOf(Catalogue(*opened).GetFlight(id));
    EXPECT_TRUE(flight.tags.empty());
    EXPECT_FALSE(flight.is_kept);
  }
  std::filesystem::path path() const { return dir_.path() / "catalogue.db"; }

 private:
  test::TemporaryFolder dir_;
};

TEST_F(SchemaTest, MakesWhatTheStepsOfDevelopmentMade) {
  SqliteDb stepped = Make(std::string(kCatalogue13));
  ASSERT_TRUE(PrepareSchema(stepped));
  test::TemporaryFolder dir;
  auto fresh = *SqliteDb::Open(dir.path() / "catalogue.db", OpenMode::kReadWriteCreate);
  ASSERT_TRUE(PrepareSchema(fresh));
  EXPECT_EQ(Parts(fresh), Parts(stepped));
}

TEST_F(SchemaTest, OpensACatalogueThatTheStepsMadeWithAllThatIsInIt) {
  {
    Make(
        std::string(kCatalogue13) +
        "INSERT INTO upload(id,flight_id,name,metadata,expires_us) SELECT 'u',id,'a.jpg','m',5 FROM flight;");
  }
  const auto db = test::ValueOf(CatalogueDb::OpenExisting(path()));
  const auto flights = test::ValueOf(Catalogue(*db).ListFlights(10, {}));
  ASSERT_EQ(flights.flights.size(), 1u);
  EXPECT_EQ(flights.flights.front().name, "Field");
  EXPECT_EQ(flights.flights.front().bytes, 100);
  auto uploads =
      *db->Lock()->Prepare("SELECT u.name, u.concat FROM upload u JOIN flight f ON f.id=flight_id");
  ASSERT_TRUE(*uploads.Step());
  EXPECT_EQ(uploads.ColumnText(0), "a.jpg");
  EXPECT_EQ(uploads.ColumnText(1), "");
}

class EarlierSchema : public SchemaTest, public testing::WithParamInterface<int> {};
TEST_P(EarlierSchema, IsBroughtToThisOneWithAllThatIsInIt) { ExpectToBeBroughtToThisOne(GetParam()); }
INSTANTIATE_TEST_SUITE_P(Versions, EarlierSchema, testing::Range(17, kSchemaVersion));

TEST_F(SchemaTest, RefusesOlderAndNewerVersionsAndLeavesThemAsTheyAre) {
  for (const int version : {1, 12, 999}) {
    Make("DROP TABLE IF EXISTS flight; CREATE TABLE flight(id); PRAGMA user_version=" +
         std::to_string(version));
    const Error opened = test::ErrorOf(CatalogueDb::Open(path()));
    EXPECT_EQ(opened.code, ErrorCode::kConflict);
    EXPECT_NE(opened.message.find(version == 999 ? "newer Skyquilt" : "skyquilt data repair"),
              std::string::npos)
        << opened.message;
    SqliteDb db = Make("");
    EXPECT_EQ(Parts(db), (std::map<std::string, std::string>{{"table flight", "CREATE TABLE flight(id)"}}));
  }
}

}  // namespace
}  // namespace skyquilt::storage
