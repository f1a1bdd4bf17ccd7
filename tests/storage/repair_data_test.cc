#include "storage/folder/repair_data.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <string>
#include <tuple>

#include "storage/db/ids.h"
#include "storage/db/schema.h"
#include "storage/folder/check_data.h"
#include "storage/folder/lost_folder.h"
#include "storage/folder/open_data_folder.h"
#include "storage/folder/sweep.h"
#include "storage/uploads/photo_store.h"
#include "tests/storage/small_tileset.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

std::string Store(const OpenedDataFolder& opened, Catalogue& catalogue, const std::string& flight,
                  const std::string& name) {
  auto upload = PhotoStore(opened.dir).Begin(flight, 0);
  const std::string bytes = "\xff\xd8\xff of " + name;
  EXPECT_TRUE(upload->Write({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}));
  const std::string stored = *upload->Finish();
  EXPECT_TRUE(catalogue.AddFile(flight, {name, stored, static_cast<std::int64_t>(bytes.size())}, Now()));
  return stored;
}

// Two flights: one with a map and a file that was removed again, one without; a third that was deleted.
struct FilledFolder {
  std::string mapped, plain, deleted;
};

FilledFolder Fill(const fs::path& root) {
  auto opened = OpenDataFolder(root);
  EXPECT_TRUE(opened) << opened.error().message;
  Catalogue catalogue(*opened->db, FlightRecords(opened->dir));
  FilledFolder sample;
  sample.mapped = catalogue.AddFlight("mapped", R"({"gsd_m":0.1})", FromUs(1'000'000), "someone")->id;
  Store(*opened, catalogue, sample.mapped, "a.jpg");
  Store(*opened, catalogue, sample.mapped, "b.jpg");
  Store(*opened, catalogue, sample.mapped, "gone.jpg");
  EXPECT_TRUE(
      catalogue.RemoveFile(sample.mapped, "gone.jpg"));  // and the bytes stay, as a crash would leave them
  PublishSmallTileset(opened->dir, *opened->db, sample.mapped, {{0, 0, 0, "old"}});
  PublishSmallTileset(opened->dir, *opened->db, sample.mapped, {{0, 0, 0, "new"}});
  sample.plain = catalogue.AddFlight("plain", "{}", Now())->id;
  Store(*opened, catalogue, sample.plain, "c.jpg");
  EXPECT_TRUE(catalogue.ChangeFlight(sample.plain, {.name = "renamed"}));
  FlightChange marks;
  marks.tags = {"maize", "north of the river"};
  marks.is_kept = true;
  EXPECT_TRUE(catalogue.ChangeFlight(sample.plain, marks));
  sample.deleted = catalogue.AddFlight("deleted", "{}", Now())->id;
  Store(*opened, catalogue, sample.deleted, "d.jpg");
  EXPECT_TRUE(catalogue.DeleteFlight(sample.deleted));  // its folder stays likewise
  return sample;
}

void ExpectAllBack(const fs::path& root, const FilledFolder& sample) {
  auto opened = test::ValueOf(OpenDataFolder(root));
  const Catalogue catalogue(*opened.db);
  const auto mapped = test::ValueOf(catalogue.GetFlight(sample.mapped));
  EXPECT_EQ(std::tie(mapped.name, mapped.options, mapped.active_revision),
            std::tuple("mapped", R"({"gsd_m":0.1})", 2));
  EXPECT_EQ(mapped.created, FromUs(1'000'000));
  const auto files = *catalogue.ListFiles(sample.mapped);
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].name, "a.jpg");
  EXPECT_EQ(files[1].name, "b.jpg");
  for (const StoredFile& file : files) {
    EXPECT_EQ(fs::file_size(opened.dir.Files(sample.mapped) / file.stored_name),
              static_cast<std::uintmax_t>(file.bytes));
  }
  EXPECT_EQ(catalogue.GetFlight(sample.plain)->name, "renamed");
  EXPECT_EQ(catalogue.GetFlight(sample.plain)->tags,
            (std::vector<std::string>{"maize", "north of the river"}));
  EXPECT_TRUE(catalogue.GetFlight(sample.plain)->is_kept);
  EXPECT_FALSE(mapped.is_kept);
  EXPECT_EQ(catalogue.ListFiles(sample.plain)->at(0).name, "c.jpg");
  EXPECT_FALSE(*catalogue.HasFlight(sample.deleted));
  // The next map gets a number that none on disk has.
  EXPECT_EQ(PublishSmallTileset(opened.dir, *opened.db, sample.mapped, {{0, 0, 0, "next"}}), 3);
}

TEST(RepairData, MakesALostCatalogueAnew) {
  const std::vector<std::function<void(const fs::path&)>> losses = {
      [](const fs::path& path) { fs::remove(path); },
      [](const fs::path& path) { std::ofstream(path).flush(); },
      [](const fs::path& path) { std::ofstream(path) << std::string(50'000, 'x'); },
      [](const fs::path& path) {
        fs::remove(path);
        EXPECT_TRUE(CatalogueDb::Open(path));
      }};
  for (const auto& lose : losses) {
    test::TemporaryFolder scratch;
    const FilledFolder sample = Fill(scratch.path());
    lose(scratch.path() / "catalogue.db");
    const auto repaired = test::ValueOf(RepairData(scratch.path(), Now()));
    EXPECT_EQ(std::tie(repaired.flights, repaired.files, repaired.maps), std::tuple(2, 3, 1));
    ExpectAllBack(scratch.path(), sample);
    const auto again = test::ValueOf(RepairData(scratch.path(), Now()));
    EXPECT_EQ(again.flights + again.files, 0);
    EXPECT_FALSE(again.made_catalogue);
  }
}

TEST(RepairData, CompletesACatalogueFromAnOlderBackup) {
  test::TemporaryFolder scratch;
  { ASSERT_TRUE(OpenDataFolder(scratch.path())); }
  const fs::path copy = scratch.path().string() + ".copy";
  fs::copy_file(scratch.path() / "catalogue.db", copy);
  const FilledFolder sample = Fill(scratch.path());
  fs::copy_file(copy, scratch.path() / "catalogue.db", fs::copy_options::overwrite_existing);
  fs::remove(copy);
  EXPECT_FALSE(OpenDataFolder(scratch.path()));
  EXPECT_FALSE(test::ValueOf(RepairData(scratch.path(), Now())).made_catalogue);
  ExpectAllBack(scratch.path(), sample);
}

// A backup from before a file was removed and another replaced: neither comes back, whether its bytes are
// gone or not.
TEST(RepairData, LeavesOutWhatWasRemovedSinceTheBackup) {
  test::TemporaryFolder scratch;
  const fs::path copy = scratch.path().string() + ".copy";
  std::string flight, removed;
  {
    auto opened = OpenDataFolder(scratch.path());
    Catalogue catalogue(*opened->db, FlightRecords(opened->dir));
    flight = catalogue.AddFlight("field", "{}", Now())->id;
    Store(*opened, catalogue, flight, "a.jpg");
    removed = Store(*opened, catalogue, flight, "more.zip");
    Store(*opened, catalogue, flight, "replaced.jpg");
    auto statement = opened->db->Lock()->Prepare("VACUUM INTO ?");
    ASSERT_TRUE(statement->Bind(1, copy.string()).Run());
    ASSERT_TRUE(catalogue.RemoveFile(flight, "more.zip"));
    Store(*opened, catalogue, flight, "replaced.jpg");
  }
  fs::remove(scratch.path() / "catalogue.db-wal");
  fs::copy_file(copy, scratch.path() / "catalogue.db", fs::copy_options::overwrite_existing);
  fs::remove(copy);
  ASSERT_TRUE(RepairData(scratch.path(), Now()));
  EXPECT_TRUE(fs::exists(scratch.path() / "flights" / flight / "files" /
                         removed));  // it is never repair that deletes
  auto opened = test::ValueOf(OpenDataFolder(scratch.path()));
  std::vector<std::string> names;
  const auto files = *Catalogue(*opened.db).ListFiles(flight);
  for (const StoredFile& file : files) names.push_back(file.name);
  EXPECT_EQ(names, (std::vector<std::string>{"a.jpg", "replaced.jpg"}));
}

// Killed after the catalogue took a file's successor and before the record could say that the first one is
// removed.
TEST(RepairData, TakesTheLaterOfTwoFilesOfOneName) {
  test::TemporaryFolder scratch;
  std::string flight, first, second;
  {
    auto opened = OpenDataFolder(scratch.path());
    const FlightRecords records(opened->dir);
    Catalogue catalogue(*opened->db, records);
    flight = catalogue.AddFlight("field", "{}", Now())->id;
    first = Store(*opened, catalogue, flight, "a.jpg");
    second = Store(*opened, catalogue, flight, "b.jpg");
    ASSERT_TRUE(records.AddFile(flight, second, {"a.jpg", 17, Now(), false}));
  }
  const auto names_after_repair = [&] {
    fs::remove(scratch.path() / "catalogue.db");
    EXPECT_TRUE(RepairData(scratch.path(), Now()));
    std::vector<std::string> names;
    auto opened = OpenDataFolder(scratch.path());
    const auto files = *Catalogue(*opened->db).ListFiles(flight);
    for (const StoredFile& file : files) names.push_back(file.name + " " + file.stored_name);
    return names;
  };
  EXPECT_EQ(names_after_repair(), std::vector<std::string>{"a.jpg " + second});
  // The successor never came to be: what was accepted before is not lost.
  fs::remove(scratch.path() / "flights" / flight / "files" / second);
  EXPECT_EQ(names_after_repair(), std::vector<std::string>{"a.jpg " + first});
}

TEST(RepairData, BringsBackWhatWentToLost) {
  test::TemporaryFolder scratch;
  const FilledFolder sample = Fill(scratch.path());
  const auto dir = DataDir::At(scratch.path());
  {
    LostFolder lost(dir, Now());
    lost.Take(dir.Flight(sample.plain), "is here for a test");
    lost.Take(dir.Revision(sample.mapped, 2), "is here for a test");
    for (const auto& entry : fs::directory_iterator(dir.Files(sample.mapped)))
      lost.Take(entry.path(), "is here for a test");
  }
  fs::remove(dir.Catalogue());
  ASSERT_TRUE(RepairData(scratch.path(), Now()));
  ExpectAllBack(scratch.path(), sample);
}

TEST(RepairData, RecoversPhotosOfFlightsWithoutARecordUnderTheirStoredNames) {
  test::TemporaryFolder scratch;
  const FilledFolder sample = Fill(scratch.path());
  const auto dir = DataDir::At(scratch.path());
  fs::remove(dir.Flight(sample.plain) / kFlightRecordName);
  fs::remove(dir.Catalogue());
  ASSERT_TRUE(RepairData(scratch.path(), Now()));
  const auto opened = test::ValueOf(OpenDataFolder(scratch.path()));
  const auto files = *Catalogue(*opened.db).ListFiles(sample.plain);
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files[0].name, files[0].stored_name + ".jpg");
  EXPECT_TRUE((*ReadFlightRecord(dir.Flight(sample.plain)))->is_whole);
}

// No repair could make its tokens, webhooks and jobs anew.
TEST(RepairData, LeavesACatalogueOfANewerVersionAsItIs) {
  test::TemporaryFolder scratch;
  const FilledFolder sample = Fill(scratch.path());
  const auto set_version = [&](int version) {
    SqliteDb db = test::ValueOf(SqliteDb::Open(scratch.path() / "catalogue.db", OpenMode::kReadWriteCreate));
    EXPECT_TRUE(db.Exec("PRAGMA user_version=" + std::to_string(version)));
  };
  set_version(999);
  const Error refused = test::ErrorOf(RepairData(scratch.path(), Now()));
  EXPECT_EQ(refused.code, ErrorCode::kConflict);
  EXPECT_NE(refused.message.find("newer Skyquilt"), std::string::npos) << refused.message;
  EXPECT_FALSE(fs::exists(scratch.path() / "lost"));
  set_version(kSchemaVersion);
  EXPECT_FALSE(test::ValueOf(RepairData(scratch.path(), Now())).made_catalogue);
  ExpectAllBack(scratch.path(), sample);
}

// As after a backup that another user put back.
TEST(RepairData, LeavesACatalogueThatThisUserMayNotUseAsItIs) {
  if (geteuid() == 0) GTEST_SKIP() << "who may use everything";
  test::TemporaryFolder scratch;
  const FilledFolder sample = Fill(scratch.path());
  const fs::path catalogue = scratch.path() / "catalogue.db";
  for (const fs::perms mode : {fs::perms::none, fs::perms::owner_read}) {
    fs::permissions(catalogue, mode);
    for (const Error& refused :
         {test::ErrorOf(OpenDataFolder(scratch.path())), test::ErrorOf(RepairData(scratch.path(), Now()))}) {
      EXPECT_EQ(refused.code, ErrorCode::kIo);
      EXPECT_NE(refused.message.find("catalogue.db cannot be used by this user"), std::string::npos)
          << refused.message;
    }
  }
  fs::permissions(catalogue, fs::perms::owner_read | fs::perms::owner_write);
  ExpectAllBack(scratch.path(), sample);
}

TEST(RepairData, RefusesFoldersOfOthersAndThoseInUse) {
  test::TemporaryFolder scratch;
  std::ofstream(scratch.path() / "holiday.jpg") << "mine";
  EXPECT_EQ(RepairData(scratch.path(), Now()).error().code, ErrorCode::kConflict);
  EXPECT_EQ(RepairData(scratch.path() / "none", Now()).error().code, ErrorCode::kNotFound);
  const auto opened = OpenDataFolder(scratch.path() / "data");
  EXPECT_EQ(RepairData(scratch.path() / "data", Now()).error().code, ErrorCode::kConflict);
}

TEST(CheckData, ListsWhatIsMissingAndWhatIsUnknown) {
  test::TemporaryFolder scratch;
  const FilledFolder sample = Fill(scratch.path());
  auto opened = test::ValueOf(OpenDataFolder(scratch.path()));
  ASSERT_TRUE(Sweep(opened.dir, Catalogue(*opened.db), JobQueue(*opened.db), Previews(*opened.db), Now()));
  ASSERT_TRUE(PurgeLost(opened.dir));
  EXPECT_TRUE(CheckData(opened.dir, *opened.db)->IsWell());
  fs::remove_all(opened.dir.Files(sample.plain));
  fs::remove_all(opened.dir.Revision(sample.mapped, 2));
  std::ofstream(opened.dir.Files(sample.mapped) / NewId()) << "x";
  fs::create_directories(opened.dir.Flights() / "2024");
  const auto check = *CheckData(opened.dir, *opened.db);
  EXPECT_EQ(check.missing.size(), 2u);
  EXPECT_EQ(check.unknown.size(), 2u);
  EXPECT_EQ(check.flights, 2);
  EXPECT_EQ(check.files, 3);
}

}  // namespace
}  // namespace skyquilt::storage
