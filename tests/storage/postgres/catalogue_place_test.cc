#include "storage/db/postgres/catalogue_place.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

TEST(CataloguePlace, TakesThePasswordOutOfTheUrl) {
  const auto place =
      CataloguePlaceFrom("postgresql://me:p%40ss%3aword@db.example.org:5433/maps?sslmode=require");
  ASSERT_TRUE(place);
  EXPECT_EQ(place->url, "postgresql://me@db.example.org:5433/maps?sslmode=require");
  EXPECT_EQ(place->password, "p@ss:word");
  EXPECT_TRUE(place->IsPostgres());
  const auto other = CataloguePlaceFrom("postgres://db/maps?password=secret&host=/run/postgresql");
  EXPECT_EQ(other->url, "postgresql://db/maps?host=/run/postgresql");
  EXPECT_EQ(other->password, "secret");
}

TEST(CataloguePlace, TakesTheSchemaAndNothingThatIsNone) {
  const auto place = CataloguePlaceFrom("postgresql://db/maps?schema=club_2&connect_timeout=3");
  EXPECT_EQ(place->schema, "club_2");
  EXPECT_EQ(place->url, "postgresql://db/maps?connect_timeout=3");
  for (const char* name : {"", "a%22b", "Club", "1st", "pg_x", "a.b"}) {
    const auto bad = CataloguePlaceFrom(std::string("postgresql://db/maps?schema=") + name);
    ASSERT_FALSE(bad) << name;
    EXPECT_EQ(bad.error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(CataloguePlace, NeverRepeatsWhatMayHoldAPassword) {
  for (const char* url : {"mysql://me:sesame@db/maps", "me:sesame@db", "postgresql://me:sesame%zz@db/maps",
                          "host=db password=sesame", "postgresql://me@db/maps?password=sesame%4"}) {
    const auto bad = CataloguePlaceFrom(url);
    ASSERT_FALSE(bad) << url;
    EXPECT_EQ((bad.error().message + bad.error().detail).find("sesame"), std::string::npos);
  }
}

TEST(CataloguePlace, IsTheDataFolderWithoutAUrl) {
  EXPECT_FALSE(CataloguePlaceFrom("")->IsPostgres());
  EXPECT_EQ(CataloguePlaceFrom("", "/some/file").error().code, ErrorCode::kInvalidArgument);
}

TEST(CataloguePlace, ReadsThePasswordFromAFile) {
  const test::TemporaryFolder dir;
  const auto path = dir.path() / "password";
  std::ofstream(path) << "from the file\nand no more\n";
  EXPECT_EQ(CataloguePlaceFrom("postgresql://me:url@db/maps", path.string())->password, "from the file");
  std::ofstream(dir.path() / "empty") << "\n";
  EXPECT_EQ(CataloguePlaceFrom("postgresql://db/maps", (dir.path() / "empty").string()).error().code,
            ErrorCode::kInvalidArgument);
  EXPECT_EQ(CataloguePlaceFrom("postgresql://db/maps", (dir.path() / "none").string()).error().code,
            ErrorCode::kNotFound);
}

}  // namespace
}  // namespace skyquilt::storage
