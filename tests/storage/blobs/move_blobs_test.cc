#include "storage/folder/object_store/move_blobs.h"

#include <gtest/gtest.h>

#include <tuple>

#include "storage/catalogue/catalogue.h"
#include "storage/db/ids.h"
#include "storage/exports/pmtiles_writer.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/jobs/job_queue.h"
#include "tests/storage/blobs/far_folder.h"
#include "tests/storage/painted_tileset.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

using test::FarFolder;

class MovedBlobs : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(catalogue_.AddFile(flight_, {"a.jpg", photo_, 5}, Now()));
    Put(near_, FilesPrefix(flight_) + photo_, "photo");
    Put(near_, RevisionPrefix(flight_, 1) + "frames/b.jpg", "frame");
    Put(near_, RevisionPrefix(flight_, 1) + "geo.txt", "");
    Put(near_, FlightPrefix(flight_) + "flight.jsonl", "record");
    Put(near_, FlightPrefix(flight_) + "preview-x/tiles.db", "preview");
  }
  void Put(BlobStore& blobs, const std::string& key, const std::string& bytes) {
    std::ofstream(folder_ / "file", std::ios::binary) << bytes;
    ASSERT_TRUE(blobs.Put(key, folder_ / "file"));
  }
  Result<MoveReport> Move(BlobStore& from, BlobStore& to, bool removes_source = false) {
    return MoveBlobs(dir_, id_, *db_, from, to, removes_source, progress_);
  }

  test::TemporaryFolder folder_;
  const std::string id_ = NewId(), photo_ = NewId();
  const DataDir dir_ = *DataDir::Open(folder_ / "data", id_);
  std::unique_ptr<CatalogueDb> db_ = *CatalogueDb::Open(dir_.Catalogue());
  Catalogue catalogue_{*db_};
  const std::string flight_ = catalogue_.AddFlight("a", "{}", Now())->id;
  FolderBlobs near_{dir_.root()};
  FarFolder far_{folder_ / "far"};
  SilentProgress progress_;
};

TEST_F(MovedBlobs, GoOutAndComeBackTheSame) {
  const auto out = test::ValueOf(Move(near_, far_));
  EXPECT_EQ(std::tie(out.copied, out.bytes, out.removed), std::tuple(3, 10, 0));
  EXPECT_TRUE(near_.Find(FilesPrefix(flight_) + photo_));  // kept unless it was said otherwise
  EXPECT_EQ(far_.List("flights/")->size(), 3U);            // neither record nor preview
  EXPECT_EQ(**SettledAt(dir_), "s3://far/");
  EXPECT_TRUE(SettleBlobs(dir_, *db_, far_));
  EXPECT_EQ(SettleBlobs(dir_, *db_, near_).error().code, ErrorCode::kConflict);

  const auto again = test::ValueOf(Move(near_, far_, true));
  EXPECT_EQ(std::tie(again.there_already, again.removed), std::tuple(3, 3));
  EXPECT_FALSE(near_.Find(FilesPrefix(flight_) + photo_));
  EXPECT_TRUE(near_.Find(FlightPrefix(flight_) + "flight.jsonl"));

  ASSERT_TRUE(Move(far_, near_, true));
  EXPECT_EQ(*near_.ReadRange(FilesPrefix(flight_) + photo_, 0, 10), "photo");
  EXPECT_EQ(*near_.ReadRange(RevisionPrefix(flight_, 1) + "frames/b.jpg", 0, 10), "frame");
  EXPECT_TRUE(far_.List("")->empty());
  EXPECT_TRUE(SettleBlobs(dir_, *db_, near_));
}

TEST_F(MovedBlobs, GoOnWhereTheyWereCutOff) {
  far_.puts_left = 1;
  EXPECT_FALSE(Move(near_, far_, true));
  EXPECT_FALSE(*SettledAt(dir_));
  EXPECT_TRUE(SettleBlobs(dir_, *db_, near_));  // the server starts as before
  EXPECT_EQ(near_.List(FilesPrefix(flight_))->size(), 1U);
  far_.puts_left = 1'000;
  const auto rest = test::ValueOf(Move(near_, far_, true));
  EXPECT_EQ(std::tie(rest.there_already, rest.copied), std::tuple(1, 2));
}

TEST_F(MovedBlobs, KeepTheOriginalOfACopyThatIsNotTheSame) {
  far_.damages = FilesPrefix(flight_) + photo_;
  EXPECT_EQ(test::ErrorOf(Move(near_, far_, true)).code, ErrorCode::kCorrupt);
  EXPECT_EQ(*near_.ReadRange(FilesPrefix(flight_) + photo_, 0, 10), "photo");
  EXPECT_FALSE(*SettledAt(dir_));
  far_.damages.clear();  // and what is damaged there is put again
  EXPECT_TRUE(Move(near_, far_));
  EXPECT_EQ(*far_.ReadRange(FilesPrefix(flight_) + photo_, 0, 10), "photo");
}

TEST_F(MovedBlobs, SayWhatIsMissingBeforeAnythingIsMoved) {
  ASSERT_TRUE(near_.Remove(FilesPrefix(flight_) + photo_));
  const Error moved = test::ErrorOf(Move(near_, far_));
  EXPECT_EQ(moved.code, ErrorCode::kNotFound);
  EXPECT_NE(moved.message.find("a.jpg"), std::string::npos);
  EXPECT_TRUE(far_.List("flights/")->empty());
}

TEST_F(MovedBlobs, ArePackedWhereTilesAreReadByRanges) {
  const test::PaintedTileset painted{.first_column = 137'000, .first_row = 90'000, .columns = 5, .rows = 4};
  test::WritePaintedTileset(folder_ / "map", painted);
  ASSERT_TRUE(near_.Put(RevisionPrefix(flight_, 1) + "mosaic.mbtiles", folder_ / "map"));
  Put(near_, RevisionPrefix(flight_, 2) + "mosaic.mbtiles", "damaged");
  const auto out = test::ValueOf(Move(near_, far_));
  EXPECT_EQ(out.pack.packed, 1);
  ASSERT_EQ(out.pack.left_whole.size(), 1U);
  EXPECT_TRUE(out.pack.left_whole[0].starts_with(RevisionPrefix(flight_, 2))) << out.pack.left_whole[0];
  EXPECT_FALSE(near_.Find(RevisionPrefix(flight_, 1) + "mosaic.pmtiles"));
  ASSERT_TRUE(WritePmtiles(folder_ / "map", folder_ / "archive", progress_));
  const BlobInfo archive = *far_.Find(RevisionPrefix(flight_, 1) + "mosaic.pmtiles");
  EXPECT_TRUE(*far_.ReadRange(archive.key, 0, archive.bytes) == test::BytesOf(folder_ / "archive"));
  EXPECT_TRUE(std::filesystem::is_empty(dir_.Incoming()));

  EXPECT_EQ(Move(near_, far_)->pack.packed, 0);  // it is there
  ASSERT_TRUE(Move(far_, near_));
  EXPECT_FALSE(near_.Find(RevisionPrefix(flight_, 1) + "mosaic.pmtiles"));
}

TEST_F(MovedBlobs, AreRemovedWhereTheyWereCopiedAndNothingElseIs) {
  ASSERT_TRUE(Move(near_, far_));
  const std::string late = FilesPrefix(flight_) + NewId();
  int lists = 0;
  far_.before_list = [&](const std::string&) {
    if (++lists == 2) Put(far_, late, "late");
  };
  const Error moved = test::ErrorOf(Move(far_, near_, true));
  EXPECT_EQ(moved.code, ErrorCode::kConflict);
  EXPECT_NE(moved.message.find(late), std::string::npos);
  EXPECT_EQ(far_.List("flights/")->size(), 4U);
  EXPECT_EQ(**SettledAt(dir_), "s3://far/");
  EXPECT_EQ(test::ValueOf(Move(far_, near_, true)).removed, 4);
  EXPECT_EQ(*near_.ReadRange(late, 0, 10), "late");
}

TEST_F(MovedBlobs, StayWhileSomebodyIsAtWork) {
  JobQueue queue(*db_);
  ASSERT_TRUE(queue.Add(flight_, "{}", Now()));
  const Lease lease = **queue.Claim("w", Now());
  EXPECT_EQ(Move(near_, far_, true).error().code, ErrorCode::kConflict);
  EXPECT_TRUE(far_.List("")->empty());
  ASSERT_TRUE(*queue.GiveBack(lease, Now()));
  EXPECT_TRUE(Move(near_, far_, true));
}

TEST_F(MovedBlobs, DoNotGoWhereAnotherCatalogueIs) {
  ASSERT_TRUE(ClaimBlobs(NewId(), far_));
  EXPECT_EQ(Move(near_, far_).error().code, ErrorCode::kConflict);
}

}  // namespace
}  // namespace skyquilt::storage
