#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "storage/db/ids.h"
#include "storage/files/publish_file.h"
#include "storage/folder/data_dir_watch.h"
#include "storage/folder/data_marker.h"
#include "storage/folder/open_data_folder.h"
#include "storage/uploads/photo_store.h"
#include "tests/storage/small_tileset.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

// Every file below a folder with its size, to see that nothing went.
std::map<std::string, std::uintmax_t> Contents(const fs::path& folder) {
  std::map<std::string, std::uintmax_t> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      contents[entry.path().lexically_relative(folder).string()] = entry.file_size();
  }
  return contents;
}

// A folder with one flight of one file and a map; answers the flight.
std::string FillWithOneFlight(const fs::path& root) {
  auto opened = OpenDataFolder(root);
  EXPECT_TRUE(opened) << opened.error().message;
  Catalogue catalogue(*opened->db, FlightRecords(opened->dir));
  const PhotoStore store(opened->dir);
  const std::string flight = catalogue.AddFlight("field", "{}", Now())->id;
  auto upload = store.Begin(flight, 0);
  const std::string_view bytes = "photo";
  EXPECT_TRUE(upload->Write({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}));
  EXPECT_TRUE(catalogue.AddFile(flight, {"a.jpg", *upload->Finish(), 5}, Now()));
  PublishSmallTileset(opened->dir, *opened->db, flight, {{0, 0, 0, "tile"}});
  return flight;
}

void ExpectRefusal(const fs::path& root, std::string_view part) {
  const auto before = Contents(root);
  const Error opened = test::ErrorOf(OpenDataFolder(root));
  EXPECT_NE(opened.message.find(part), std::string::npos) << opened.message;
  for (const auto& [name, bytes] : before) EXPECT_TRUE(fs::exists(root / name)) << name;
}

TEST(FlightBlob, IsTakenApartByItsKey) {
  const std::string id = NewId();
  const auto sums = test::ValueOf(FlightBlobOf(RevisionPrefix(id, 7) + "ranges/mosaic.sums"));
  EXPECT_EQ(sums.flight_id, id);
  EXPECT_EQ(RevisionOfFolder(sums.folder), 7);
  EXPECT_EQ(sums.name, "ranges/mosaic.sums");
  EXPECT_EQ(FlightBlobOf(FilesPrefix(id) + "a")->folder, "files");
  for (const std::string& key : {std::string(), std::string("flights/"), std::string("flights/x/files/a"),
                                 "flights/" + id, FlightPrefix(id) + "flight.jsonl", id + "/files/a"})
    EXPECT_FALSE(FlightBlobOf(key)) << key;
  for (const char* folder : {"", "r", "r0", "r07", "rx", "r1x", "r-1", "r99999999999999999999", "files"})
    EXPECT_FALSE(RevisionOfFolder(folder)) << folder;
}

TEST(OpenDataFolder, MakesANewOneForItsOwnerAlone) {
  test::TemporaryFolder scratch;
  const fs::path root = scratch.path() / "deep" / "data";
  FillWithOneFlight(root);
  struct stat status {};
  ASSERT_EQ(stat(root.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0700u);
  ASSERT_EQ(stat((root / "catalogue.db").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  const auto again = test::ValueOf(OpenDataFolder(root));
  EXPECT_EQ(again.dir.id(), **ReadMarker(again.dir));
  EXPECT_EQ(OpenDataFolder(root).error().code, ErrorCode::kConflict);
  EXPECT_TRUE(JoinDataFolder(root));
  EXPECT_TRUE(OpenOrJoinDataFolder(root));
}

TEST(OpenDataFolder, TakesAnEmptyFolderAndTheRootOfAFileSystem) {
  test::TemporaryFolder scratch;
  fs::create_directories(scratch.path() / "lost+found");
  EXPECT_TRUE(OpenDataFolder(scratch.path()));
}

TEST(OpenDataFolder, RefusesFoldersOfOthersAndLeavesThemAsTheyAre) {
  for (const char* name : {"flights/2024/DJI_0001.JPG", "work/thesis.odt", "incoming/mail", "uploads/x",
                           "holiday.jpg", "catalogue.db"}) {
    test::TemporaryFolder scratch;
    const fs::path file = scratch.path() / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file)
        << "mine, and not a database at all; long enough to look like a file that holds something";
    const auto before = Contents(scratch.path());
    ExpectRefusal(scratch.path(), "is not a data folder of Skyquilt");
    EXPECT_EQ(Contents(scratch.path()), before) << name;
    EXPECT_EQ(OpenOrJoinDataFolder(scratch.path()).error().code, ErrorCode::kConflict);
    EXPECT_EQ(JoinDataFolder(scratch.path()).error().code, ErrorCode::kNotFound);
  }
}

TEST(OpenDataFolder, RefusesWhatIsNoFolder) {
  test::TemporaryFolder scratch;
  std::ofstream(scratch.path() / "file") << "x";
  EXPECT_NE(OpenDataFolder(scratch.path() / "file").error().message.find("is not a folder"),
            std::string::npos);
  fs::create_symlink(scratch.path() / "nowhere", scratch.path() / "link");
  EXPECT_NE(OpenDataFolder(scratch.path() / "link").error().message.find("is a link"), std::string::npos);
  if (geteuid() == 0) return;  // who may write everywhere
  fs::create_directory(scratch.path() / "closed");
  fs::permissions(scratch.path() / "closed", fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_NE(OpenDataFolder(scratch.path() / "closed").error().message.find("cannot be used"),
            std::string::npos);
}

TEST(OpenDataFolder, FollowsALinkToAFolder) {
  test::TemporaryFolder scratch;
  fs::create_directory(scratch.path() / "real");
  fs::create_symlink(scratch.path() / "real", scratch.path() / "link");
  FillWithOneFlight(scratch.path() / "link");
  EXPECT_TRUE(OpenDataFolder(scratch.path() / "real"));
}

TEST(OpenDataFolder, RefusesAMissingEmptyNewForeignOrDamagedCatalogueAndNamesTheRepair) {
  test::TemporaryFolder scratch, other;
  FillWithOneFlight(scratch.path());
  FillWithOneFlight(other.path());
  const fs::path catalogue = scratch.path() / "catalogue.db";
  const fs::path copy = scratch.path().string() + ".copy";
  fs::copy_file(catalogue, copy);
  const std::string advice = "skyquilt data repair --data " + scratch.path().string();
  fs::remove(catalogue);
  ExpectRefusal(scratch.path(), advice);
  EXPECT_FALSE(fs::exists(catalogue));
  std::ofstream(catalogue).flush();
  ExpectRefusal(scratch.path(), advice);
  EXPECT_EQ(fs::file_size(catalogue), 0u);
  std::ofstream(catalogue) << std::string(9000, 'x');
  ExpectRefusal(scratch.path(), advice);
  fs::remove(catalogue);
  { EXPECT_TRUE(CatalogueDb::Open(catalogue)); }
  ExpectRefusal(scratch.path(), advice);
  fs::copy_file(other.path() / "catalogue.db", catalogue, fs::copy_options::overwrite_existing);
  ExpectRefusal(scratch.path(), advice);
  fs::copy_file(copy, catalogue, fs::copy_options::overwrite_existing);
  EXPECT_TRUE(OpenDataFolder(scratch.path()));
  std::ofstream(scratch.path() / "skyquilt-data.json") << "{}";
  ExpectRefusal(scratch.path(), advice);
  fs::remove(copy);
}

TEST(OpenDataFolder, RefusesACatalogueThatIsOlderThanTheFlights) {
  test::TemporaryFolder scratch;
  FillWithOneFlight(scratch.path());
  const fs::path copy = scratch.path().string() + ".copy";
  fs::copy_file(scratch.path() / "catalogue.db", copy);
  const std::string newer = FillWithOneFlight(scratch.path());
  fs::copy_file(copy, scratch.path() / "catalogue.db", fs::copy_options::overwrite_existing);
  ExpectRefusal(scratch.path(), "is older than what is on disk");
  EXPECT_TRUE(fs::exists(DataDir::At(scratch.path()).Flight(newer)));
  fs::remove(copy);
}

TEST(OpenDataFolder, RefusesACatalogueThatLacksFilesOrMapsOfItsFlights) {
  for (const bool with_map : {false, true}) {
    test::TemporaryFolder scratch;
    const std::string flight = FillWithOneFlight(scratch.path());
    const fs::path copy = scratch.path().string() + ".copy";
    fs::copy_file(scratch.path() / "catalogue.db", copy);
    {
      auto opened = test::ValueOf(OpenDataFolder(scratch.path()));
      Catalogue catalogue(*opened.db, FlightRecords(opened.dir));
      for (const char* name : {"b.jpg", "c.jpg"}) {
        const std::string stored = NewId();
        std::ofstream(opened.dir.Files(flight) / stored) << "more";
        if (!with_map) {
          ASSERT_TRUE(catalogue.AddFile(flight, {name, stored, 4}, Now()));
        }
      }
      if (with_map) PublishSmallTileset(opened.dir, *opened.db, flight, {{0, 0, 0, "newer"}});
    }
    fs::copy_file(copy, scratch.path() / "catalogue.db", fs::copy_options::overwrite_existing);
    ExpectRefusal(scratch.path(), "is older than what is on disk");
    fs::remove(copy);
  }
}

TEST(OpenDataFolder, GoesOnAfterCrashesThatLeaveThingsOnDisk) {
  test::TemporaryFolder scratch;
  const std::string flight = FillWithOneFlight(scratch.path());
  const auto dir = DataDir::At(scratch.path());
  const FlightRecords records(dir);
  // Killed between a file's record and its commit; after files of an archive were placed; before a flight's
  // commit; between a flight's deletion and the removal of its files.
  const std::string stored = NewId(), empty = NewId(), deleted = NewId();
  std::ofstream(dir.Files(flight) / stored) << "photo";
  ASSERT_TRUE(records.AddFile(flight, stored, {"z.jpg", 5, Now(), false}));
  for (int i = 0; i < 3; ++i) std::ofstream(dir.Files(flight) / NewId()) << "of an archive";
  FlightRecord record;
  record.name = "f";
  ASSERT_TRUE(records.Begin(empty, record));
  ASSERT_TRUE(records.Begin(deleted, record));
  fs::create_directory(dir.Files(deleted));
  std::ofstream(dir.Files(deleted) / NewId()) << "photo";
  ASSERT_TRUE(records.Deleting(deleted, Now()));
  const auto opened = OpenDataFolder(scratch.path());
  EXPECT_TRUE(opened) << opened.error().message;
}

// Photos lie in a store: nothing on the disk tells what was recorded and not committed from what is missing.
TEST(OpenDataFolder, GoesOnAfterAnyNumberOfKillsBesideAStore) {
  test::TemporaryFolder scratch;
  const std::string flight = FillWithOneFlight(scratch.path());
  const auto dir = DataDir::At(scratch.path());
  std::ofstream(dir.BlobsMarker()) << R"({"blobs":"s3://far/"})";
  for (int kills = 0; kills < 3; ++kills) {
    const std::string killed = NewId();
    ASSERT_TRUE(FlightRecords(dir).AddFile(flight, killed, {"a.jpg", 5, Now(), false}));
    const auto opened = test::ValueOf(OpenDataFolder(scratch.path()));
    ASSERT_TRUE(SettleRecords(opened.dir, *opened.db));
    const auto record = test::ValueOf(*ReadFlightRecord(dir.Flight(flight)));
    EXPECT_TRUE(record.files.at(killed).is_removed);
    const RecordedFile& kept = record.files.at(Catalogue(*opened.db).ListFiles(flight)->at(0).stored_name);
    EXPECT_FALSE(kept.is_removed);
    EXPECT_EQ(kept.replaced_by, "");
  }
}

TEST(OpenDataFolder, AdoptsAFolderOfAVersionWithoutMarkers) {
  test::TemporaryFolder scratch;
  const std::string flight = FillWithOneFlight(scratch.path());
  {
    const auto db = *CatalogueDb::Open(scratch.path() / "catalogue.db");
    ASSERT_TRUE(db->Lock()->Exec("DELETE FROM data_dir"));
  }
  fs::remove(scratch.path() / "skyquilt-data.json");
  const fs::path record = DataDir::At(scratch.path()).Flight(flight) / kFlightRecordName;
  fs::remove(record);
  const auto opened = test::ValueOf(OpenDataFolder(scratch.path()));
  EXPECT_EQ(opened.notes.size(), 1u);
  EXPECT_TRUE(fs::exists(scratch.path() / "skyquilt-data.json"));
  EXPECT_FALSE(fs::exists(record));  // whoever opened it may still be refused
  EXPECT_EQ(*WriteMissingRecords(opened.dir, *opened.db), 1);
  EXPECT_EQ(*WriteMissingRecords(opened.dir, *opened.db), 0);
  const auto read = test::ValueOf(*ReadFlightRecord(record.parent_path()));
  EXPECT_TRUE(read.is_whole);
  EXPECT_EQ(read.name, "field");
  EXPECT_EQ(read.files.begin()->second.name, "a.jpg");
}

TEST(DataDirWatch, SeesAFolderThatGoesIsReplacedAndComesBack) {
  test::TemporaryFolder scratch;
  const fs::path root = scratch.path() / "data", away = scratch.path() / "away";
  const auto opened = test::ValueOf(OpenDataFolder(root));
  const auto watch = test::ValueOf(DataDirWatch::Begin(opened.dir));
  EXPECT_TRUE(watch.Check());
  fs::rename(root, away);
  EXPECT_EQ(watch.Check().error().code, ErrorCode::kUnavailable);
  const PhotoStore store(opened.dir);
  EXPECT_EQ(store.Begin(NewId(), 0).error().code, ErrorCode::kUnavailable);
  EXPECT_FALSE(fs::exists(root));  // nothing makes it anew
  fs::copy(away, root, fs::copy_options::recursive);
  EXPECT_EQ(watch.Check().error().code, ErrorCode::kUnavailable);
  fs::remove_all(root);
  fs::rename(away, root);
  EXPECT_TRUE(watch.Check());
  fs::rename(root / "catalogue.db", root / "aside");
  EXPECT_EQ(watch.Check().error().code, ErrorCode::kUnavailable);
  fs::rename(root / "aside", root / "catalogue.db");
  fs::remove(root / "catalogue.db-wal");
  EXPECT_EQ(watch.Check().error().code, ErrorCode::kUnavailable);
}

// A second connection of this process, and one of another that comes and goes: none may take the first one's
// locks with it, or the other would take itself for the last and remove the log.
TEST(OpenDataFolder, KeepsItsLocksWhateverElseIsOpened) {
  test::TemporaryFolder scratch;
  int begin[2];
  ASSERT_EQ(pipe(begin), 0);
  // Before anything is open: SQLite in a child would take its parent's connections for its own.
  const pid_t child = fork();
  if (child == 0) {
    char go = 0;
    const bool told = read(begin[0], &go, 1) == 1;
    const bool joined = told && JoinDataFolder(scratch.path()).ok();  // and closed again
    _exit(joined ? 0 : 1);
  }
  auto opened = test::ValueOf(OpenDataFolder(scratch.path()));
  const auto second = test::ValueOf(CatalogueDb::OpenExisting(opened.dir.Catalogue()));
  const auto watch = test::ValueOf(DataDirWatch::Begin(opened.dir));
  ASSERT_EQ(write(begin[1], "g", 1), 1);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(watch.Check()) << watch.Check().error().message;
  close(begin[0]);
  close(begin[1]);
}

TEST(DataMarker, TakesAnyBytes) {
  const std::string id = NewId();
  EXPECT_EQ(*ParseMarker(R"({"format": 1, "id": ")" + id + R"("})"), id);
  EXPECT_EQ(ParseMarker(R"({"format": 2, "id": 7})").error().code, ErrorCode::kConflict);
  for (const char* bad : {"", "{", "[]", "null", R"({"format": 1})", R"({"format": "1", "id": "x"})",
                          R"({"format": 1, "id": "../../etc"})", R"({"format": 1, "id": []})", "\xff\xfe"}) {
    EXPECT_EQ(ParseMarker(bad).error().code, ErrorCode::kCorrupt) << bad;
  }
}

TEST(SyncFolder, TakesADiskThatCannotForOneThatNeedNot) {
  EXPECT_TRUE(SyncFolder("/proc"));
  EXPECT_FALSE(SyncFolder("/nonexistent/folder"));
}

}  // namespace
}  // namespace skyquilt::storage
