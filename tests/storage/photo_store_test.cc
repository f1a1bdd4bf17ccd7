#include "storage/uploads/photo_store.h"

#include <gtest/gtest.h>

#include <fstream>

#include "storage/catalogue/trash.h"
#include "storage/db/ids.h"
#include "storage/folder/sweep.h"
#include "storage/jobs/job_queue.h"
#include "storage/jobs/unit_queue.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

std::vector<std::uint8_t> Bytes(std::string_view text) { return {text.begin(), text.end()}; }

int CountIn(const std::filesystem::path& folder) {
  return static_cast<int>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(CheckFileName, RefusesEveryPathAndTakesOrdinaryNames) {
  for (const char* good :
       {"a.jpg", "DJI_0001 (2).JPG", "høyde æ.jpg", "..jpg", "CON", "a.", "日本.tif", "a;b.jpg"}) {
    EXPECT_TRUE(CheckFileName(good)) << good;
  }
  using namespace std::string_literals;
  for (const std::string& bad :
       {""s, "."s, ".."s, "../a"s, "a/b"s, "a\\b"s, "a\nb"s, "a\0b"s, "\x7f"s, std::string(256, 'a'),
        "\xc0\xaf"s, "\xed\xa0\x80"s, "\xf4\x90\x80\x80"s, "\xff"s, "abc\xc3"s}) {
    EXPECT_FALSE(CheckFileName(bad)) << bad;
  }
}

TEST(PhotoStore, StoresBytesUnderANameOfItsOwn) {
  test::TemporaryFolder scratch;
  const PhotoStore store(*DataDir::Open(scratch.path()));
  const std::string flight = NewId();
  auto upload = test::ValueOf(store.Begin(flight, 0));
  ASSERT_TRUE(upload.Write(Bytes("hello ")));
  ASSERT_TRUE(upload.Write(Bytes("world")));
  const auto stored = test::ValueOf(upload.Finish());
  EXPECT_EQ(test::BytesOf(store.PathOf(flight, stored)), "hello world");
  EXPECT_EQ(CountIn(store.dir().Incoming()), 0);
  store.Remove(flight, stored);
  EXPECT_EQ(CountIn(store.dir().Files(flight)), 0);
}

TEST(PhotoStore, TakesBackWhatTheCatalogueRefusedAndKeepsWhatItMayHave) {
  test::TemporaryFolder scratch;
  const PhotoStore store(*DataDir::Open(scratch.path()));
  const std::string flight = NewId();
  auto upload = test::ValueOf(store.Begin(flight, 0));
  ASSERT_TRUE(upload.Write(Bytes("x")));
  const auto stored = test::ValueOf(upload.Finish());
  store.TakeBack(flight, stored, {ErrorCode::kUnavailable, "its connection was lost at the commit", ""});
  EXPECT_EQ(CountIn(store.dir().Files(flight)), 1);
  store.TakeBack(flight, stored, {ErrorCode::kOutOfSpace, "its disk is full", ""});
  EXPECT_EQ(CountIn(store.dir().Files(flight)), 0);
}

TEST(PhotoStore, LeavesNothingOfAnUploadThatBroke) {
  test::TemporaryFolder scratch;
  const PhotoStore store(*DataDir::Open(scratch.path()));
  const std::string flight = NewId();
  {
    auto upload = store.Begin(flight, 10);
    ASSERT_TRUE(upload->Write(Bytes("half")));
  }
  EXPECT_EQ(CountIn(store.dir().Incoming()), 0);
  EXPECT_EQ(CountIn(store.dir().Files(flight)), 0);
}

TEST(PhotoStore, RefusesEmptyAndHugeFiles) {
  test::TemporaryFolder scratch;
  const PhotoStore store(*DataDir::Open(scratch.path()));
  EXPECT_EQ(store.Begin(NewId(), 0)->Finish().error().code, ErrorCode::kUnprocessable);
  EXPECT_EQ(store.Begin(NewId(), kMaxFileBytes + 1).error().code, ErrorCode::kTooLarge);
}

TEST(PhotoStore, SaysWhenTheFlightWasDeletedMeanwhile) {
  test::TemporaryFolder scratch;
  const PhotoStore store(*DataDir::Open(scratch.path()));
  const std::string flight = NewId();
  auto upload = store.Begin(flight, 0);
  ASSERT_TRUE(upload->Write(Bytes("x")));
  store.RemoveFlight(flight);
  EXPECT_EQ(upload->Finish().error().code, ErrorCode::kNotFound);
}

TEST(Sweep, RemovesOnlyItsOwnTemporariesAndMovesAllElseThatIsUnknown) {
  test::TemporaryFolder scratch;
  const auto dir = *DataDir::Open(scratch.path(), NewId());
  const auto db = *CatalogueDb::Open(dir.Catalogue());
  Catalogue catalogue(*db);
  JobQueue queue(*db);
  const PhotoStore store(dir);
  const std::string flight = catalogue.AddFlight("f", "{}", Now())->id;
  auto upload = store.Begin(flight, 0);
  ASSERT_TRUE(upload->Write(Bytes("x")));
  const std::string stored = *upload->Finish();
  ASSERT_TRUE(catalogue.AddFile(flight, {"a.jpg", stored, 1}, Now()));
  ASSERT_TRUE(queue.Add(flight, "{}", Now()));
  Lease lease = **queue.Claim("w", Now());
  const std::int64_t first = **queue.ReserveRevision(lease);
  Revision revision;
  revision.revision = first;
  std::filesystem::create_directories(dir.Revision(flight, first));
  ASSERT_TRUE(*queue.Publish(lease, revision, Now()));

  // Ours, and temporary by their names.
  std::ofstream(dir.Incoming() / dir.NewTemporaryName(kUploadKind)) << "half";
  std::filesystem::create_directories(dir.Incoming() / dir.NewTemporaryName(kUnpackKind) / "flights");
  std::filesystem::create_directories(dir.Work() / dir.NewTemporaryName(kDeletedKind) / "files");
  std::filesystem::create_directories(dir.Work() / WorkName(lease));
  std::filesystem::create_directories(dir.Flight(flight) / NewPreviewFolder());
  std::filesystem::create_directories(dir.Work() / UnitsWorkName(NewId()) / "look-0");
  // Of others, of another folder's server, or of nobody knows whom.
  const std::vector<std::filesystem::path> strange = {
      dir.Incoming() / NewId(),
      dir.Incoming() / DataDir::At(scratch.path(), NewId()).NewTemporaryName(kUploadKind),
      dir.Work() / "old-job-1",
      dir.Work() / (NewId() + "-1"),
      dir.Files(flight) / NewId(),
      dir.Flight(flight) / "notes.txt",
      dir.Flight(flight) / "preview-mine",
      dir.Flights() / "2024",
      dir.Flight(NewId())};
  for (const auto& path : strange) std::ofstream(path) << path.filename().string();
  std::filesystem::create_directories(dir.Revision(flight, 99));
  std::ofstream(dir.Revision(flight, 99) / "mosaic.mbtiles") << "tiles";
  const std::string other = catalogue.AddFlight("running", "{}", Now())->id;
  ASSERT_TRUE(queue.Add(other, "{}", Now()));
  lease = **queue.Claim("w", Now());
  std::filesystem::create_directories(dir.Work() / WorkName(lease));
  ASSERT_TRUE(*UnitQueue(*db).TakeOver(lease, "made from", Now()));
  const std::filesystem::path units = dir.Work() / UnitsWorkName(lease.job_id);
  std::filesystem::create_directories(units / "look-0");
  std::filesystem::create_directories(dir.Revision(other, 1));

  const auto report = test::ValueOf(Sweep(dir, catalogue, queue, Previews(*db), Now()));
  EXPECT_EQ(report.removed, 6);
  EXPECT_EQ(report.moved.size(), strange.size() + 1);
  ASSERT_EQ(CountIn(dir.Lost()), 1);
  const auto lost = std::filesystem::directory_iterator(dir.Lost())->path();
  for (const auto& path : strange) {
    EXPECT_EQ(test::BytesOf(lost / path.lexically_relative(dir.root())), path.filename().string()) << path;
    EXPECT_FALSE(std::filesystem::exists(path));
  }
  EXPECT_TRUE(std::filesystem::exists(lost / dir.Revision(flight, 99).lexically_relative(dir.root()) /
                                      "mosaic.mbtiles"));
  const auto again = Sweep(dir, catalogue, queue, Previews(*db), Now());
  EXPECT_EQ(again->removed, 0);
  EXPECT_TRUE(again->moved.empty());
  EXPECT_TRUE(std::filesystem::exists(store.PathOf(flight, stored)));
  EXPECT_TRUE(std::filesystem::exists(dir.Revision(flight, first)));
  EXPECT_TRUE(std::filesystem::exists(dir.Work() / WorkName(lease)));
  // What units of a job that failed made is the next one's, for a day.
  ASSERT_TRUE(*queue.Fail(lease, {ErrorCode::kInternal, "it died", ""}, false, Now()));
  EXPECT_EQ(SweepWork(dir, queue, Now())->removed, 1);
  EXPECT_TRUE(std::filesystem::exists(units));
  EXPECT_EQ(SweepWork(dir, queue, Now() + kUnitsKept + std::chrono::hours(2))->removed, 1);
  EXPECT_FALSE(std::filesystem::exists(units));
  EXPECT_TRUE(std::filesystem::exists(dir.Revision(other, 1)));
}

// A job that a stop cut off waits for the next start, and with it what it had made.
TEST(Sweep, RemovesWhatAJobHadMadeWhoseFlightIsInTheTrash) {
  test::TemporaryFolder scratch;
  const auto dir = *DataDir::Open(scratch.path(), NewId());
  const auto db = *CatalogueDb::Open(dir.Catalogue());
  const std::string flight = Catalogue(*db).AddFlight("f", "{}", Now())->id;
  JobQueue queue(*db);
  ASSERT_TRUE(queue.Add(flight, "{}", Now()));
  const Lease lease = **queue.Claim("w", Now());
  std::filesystem::create_directories(dir.Work() / WorkName(lease));
  ASSERT_TRUE(*queue.GiveBack(lease, Now()));
  EXPECT_EQ(SweepWork(dir, queue, Now())->removed, 0);
  ASSERT_TRUE(Trash(*db).Put(flight, Now()));
  EXPECT_EQ(SweepWork(dir, queue, Now())->removed, 1);
  EXPECT_EQ(CountIn(dir.Work()), 0);
  EXPECT_FALSE(std::filesystem::exists(dir.Lost()) && CountIn(dir.Lost()) > 0);
}

TEST(DataDirLock, IsHeldByOneAtATime) {
  test::TemporaryFolder scratch;
  const auto dir = *DataDir::Open(scratch.path());
  {
    const auto first = test::ValueOf(DataDirLock::Take(dir));
    EXPECT_EQ(DataDirLock::Take(dir).error().code, ErrorCode::kConflict);
  }
  EXPECT_TRUE(DataDirLock::Take(dir));
}

TEST(DataDirLock, HoldsWhateverIsRemovedFromTheFolder) {
  test::TemporaryFolder scratch;
  const auto dir = *DataDir::Open(scratch.path());
  std::ofstream(scratch.path() / "server.lock") << "";
  const auto first = test::ValueOf(DataDirLock::Take(dir));
  std::filesystem::remove(scratch.path() / "server.lock");
  EXPECT_EQ(DataDirLock::Take(dir).error().code, ErrorCode::kConflict);
}

}  // namespace
}  // namespace skyquilt::storage
