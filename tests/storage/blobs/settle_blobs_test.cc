#include "storage/folder/object_store/settle_blobs.h"

#include <gtest/gtest.h>

#include "storage/catalogue/catalogue.h"
#include "storage/db/ids.h"
#include "storage/folder/data_marker.h"
#include "storage/folder/open_data_folder.h"
#include "tests/storage/blobs/far_folder.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

using test::FarFolder;

class SettledBlobs : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(SetCatalogueId(*db_->Lock(), id_)); }
  void AddAFile() {
    Catalogue catalogue(*db_);
    const std::string flight = catalogue.AddFlight("a", "{}", Now())->id;
    ASSERT_TRUE(catalogue.AddFile(flight, {"a.jpg", NewId(), 5}, Now()));
  }
  ErrorCode Check(const std::string& address, const std::optional<std::string>& owner) {
    const Result<void> checked = CheckBlobsOf(*db_->Lock(), id_, address, owner);
    if (!checked) said_ = checked.error().message;
    return checked ? ErrorCode::kCancelled : checked.error().code;
  }

  test::TemporaryFolder folder_;
  const std::string id_ = NewId();
  const DataDir dir_ = *DataDir::Open(folder_ / "data", id_);
  std::unique_ptr<CatalogueDb> db_ = *CatalogueDb::Open(dir_.Catalogue());
  FarFolder far_{folder_ / "far"};
  std::string said_;
};

constexpr ErrorCode kGood = ErrorCode::kCancelled;  // of Check

TEST_F(SettledBlobs, AreWhereTheFirstServerSaidAndNowhereElse) {
  EXPECT_EQ(Check("s3://far/", std::nullopt), kGood);  // nobody has said anything, and there is no photo
  EXPECT_EQ(Check("", std::nullopt), kGood);
  ASSERT_EQ(*SayCatalogueBlobs(*db_->Lock(), "s3://far/"), "s3://far/");
  EXPECT_EQ(*SayCatalogueBlobs(*db_->Lock(), "s3://later/"), "s3://far/");
  EXPECT_EQ(Check("s3://far/", id_), kGood);
  EXPECT_EQ(Check("s3://mistyped/", std::nullopt), ErrorCode::kConflict);
  EXPECT_NE(said_.find("--blobs s3://far/"), std::string::npos) << said_;
  EXPECT_EQ(Check("s3://mistyped/", id_), ErrorCode::kConflict);      // claimed before catalogues knew
  EXPECT_EQ(Check("", std::nullopt), ErrorCode::kConflict);           // forgotten
  EXPECT_EQ(Check("s3://far/", std::nullopt), ErrorCode::kConflict);  // another store of that name
  EXPECT_EQ(Check("s3://far/", NewId()), ErrorCode::kConflict);
}

TEST_F(SettledBlobs, OfASharedFolderAreNotInAStore) {
  ASSERT_TRUE(SayCatalogueBlobs(*db_->Lock(), kInDataFolder));
  EXPECT_EQ(Check("", std::nullopt), kGood);
  EXPECT_EQ(Check("s3://far/", std::nullopt), ErrorCode::kConflict);
  ASSERT_TRUE(ChangeCatalogueBlobs(*db_->Lock(), "s3://far/"));  // moved
  EXPECT_EQ(Check("s3://far/", id_), kGood);
  EXPECT_EQ(Check("", std::nullopt), ErrorCode::kConflict);
}

TEST_F(SettledBlobs, OfACatalogueThatNeverSaidAreWhereItIsKnown) {
  AddAFile();
  EXPECT_EQ(Check("s3://far/", id_), kGood);
  EXPECT_EQ(Check("s3://mistyped/", std::nullopt), ErrorCode::kConflict);
}

TEST_F(SettledBlobs, AreNotClaimedByWhoIsRefused) {
  AddAFile();
  EXPECT_EQ(SettleBlobs(dir_, *db_, far_).error().code, ErrorCode::kConflict);
  EXPECT_TRUE(far_.List("")->empty());
  EXPECT_FALSE(*SettledAt(dir_));
}

TEST_F(SettledBlobs, OfAnotherCatalogueGetNoNewOneBesideThem) {
  CataloguePlace place;
  place.files_at = "s3://far/";
  place.files_of = NewId();
  EXPECT_EQ(test::ErrorOf(OpenDataFolder(folder_ / "new", 1, place)).code, ErrorCode::kConflict);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "new"));
}

}  // namespace
}  // namespace skyquilt::storage
