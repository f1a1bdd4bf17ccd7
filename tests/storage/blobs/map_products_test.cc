#include "storage/jobs/map_products.h"

#include "storage/blobs/range_cache.h"
#include "storage/blobs/sha256.h"
#include "storage/folder/check_data.h"
#include "tests/storage/blobs/far_folder.h"
#include "tests/storage/catalogue_fixture.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

// A flight whose jobs publish maps, of files that a test puts into a folder.
class PublishedMapTest : public CatalogueFixture {
 protected:
  // Its revision.
  std::int64_t Published(const std::vector<MapProduct>& products) {
    const Lease lease = Begun(flight_, Now());
    Revision revision;
    revision.revision = **queue_.ReserveRevision(lease);
    EXPECT_TRUE(*queue_.Publish(lease, revision, Now(), products));
    return revision.revision;
  }

  const std::filesystem::path made_ = dir_ / "made";
  const std::string flight_ = catalogue_.AddFlight("field", "{}", Now())->id;
};

class MapProducts : public PublishedMapTest {
 protected:
  void SetUp() override {
    fs::create_directories(made_ / "frames");
    for (const char* name : {"mosaic.pmtiles", "report.json", "frames/a.jpg"})
      std::ofstream(made_ / name) << "bytes of " << name;
  }
  std::optional<std::string> SumOf(std::int64_t revision, const std::string& name) {
    return *PublishedSum(*db_, RevisionPrefix(flight_, revision) + name);
  }
};

TEST_F(MapProducts, AreTheFilesOfTheMapAndTheSumsOfItsRanges) {
  const auto products = ProductsIn(made_);
  ASSERT_TRUE(products);
  ASSERT_EQ(products->size(), 3U);
  EXPECT_EQ((*products)[0].name, "mosaic.pmtiles");
  EXPECT_EQ((*products)[0].sha256, *Sha256OfFile(made_ / "mosaic.pmtiles"));
  EXPECT_EQ((*products)[1].name, RangeSumsKey("mosaic.pmtiles"));
  Sha256Sum sums;
  sums.Add(*RangeSumsOfFile(made_ / "mosaic.pmtiles"));
  EXPECT_EQ((*products)[1].sha256, sums.Finish());
  EXPECT_EQ((*products)[2].name, "report.json");
  EXPECT_EQ(ProductsIn(dir_ / "none").error().code, ErrorCode::kIo);
}

TEST_F(MapProducts, HaveSumsOfRangesUnderNamesOfTheirOwn) {
  EXPECT_EQ(RangeSumsKey("a/mosaic.pmtiles"), "a/ranges/mosaic.sums");
  EXPECT_EQ(RangeSumsKey("a/mosaic.mbtiles"), "a/ranges/mosaic.mbtiles.sums");
  std::ofstream(made_ / "mosaic.mbtiles") << "bytes of tiles";
  EXPECT_EQ(ProductsIn(made_)->size(), 5U);
}

TEST_F(MapProducts, AreKnownForAsLongAsTheirMap) {
  const std::vector<MapProduct> products = *ProductsIn(made_);
  const std::int64_t first = Published(products);
  EXPECT_EQ(SumOf(first, "mosaic.pmtiles"), products[0].sha256);
  EXPECT_EQ(SumOf(first, "ranges/mosaic.sums"), products[1].sha256);
  EXPECT_EQ(SumOf(first, "mosaic.tif"), "");  // it has none
  EXPECT_EQ(SumOf(first, "frames/a.jpg"), std::nullopt);
  EXPECT_EQ(SumOf(first + 1, "mosaic.pmtiles"), std::nullopt);
  EXPECT_EQ(SumOf(Published({}), "mosaic.pmtiles"), std::nullopt);  // in the data folder
  for (const char* key :
       {"", "flights/", "flights/x", "flights/x/r1", "flights/x/r/a", "flights/x/rx/a", "flights/x/r1x/a",
        "flights/x/r99999999999999999999/a", "flights/x/files/a", "r1/a"})
    EXPECT_EQ(*PublishedSum(*db_, key), std::nullopt) << key;
  Published({});  // the third: the first one goes
  EXPECT_EQ(SumOf(first, "mosaic.pmtiles"), std::nullopt);
  const std::int64_t last = Published(products);
  EXPECT_NE(SumOf(last, "report.json"), std::nullopt);
  ASSERT_TRUE(ForgetProducts(*db_->Lock()));
  EXPECT_EQ(SumOf(last, "report.json"), std::nullopt);
}

class CheckedMaps : public PublishedMapTest {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(made_);
    for (const char* name : {"mosaic.tif", "report.json"}) std::ofstream(made_ / name) << "bytes of " << name;
  }
  std::int64_t Stored(const std::vector<MapProduct>& products) {
    const std::int64_t revision = Published(products);
    for (const MapProduct& product : products) Put(revision, product.name, made_ / product.name);
    return revision;
  }
  void Put(std::int64_t revision, const std::string& name, const std::filesystem::path& file) {
    ASSERT_TRUE(far_.Put(RevisionPrefix(flight_, revision) + name, file));
  }
  DataCheck Check() {
    DataCheck check;
    EXPECT_TRUE(CheckMaps(*db_, far_, check, progress_).ok());
    return check;
  }

  test::FarFolder far_{dir_ / "far"};
  SilentProgress progress_;
};

TEST_F(CheckedMaps, AreHeldAgainstWhatTheirJobsLeft) {
  const std::int64_t first = Stored(*ProductsIn(made_));
  EXPECT_TRUE(Check().IsWell());
  Put(first, "mosaic.tif", dir_.Write("other", "bytes of mosaic.tiF"));  // as long
  ASSERT_TRUE(far_.Remove(RevisionPrefix(flight_, first) + "report.json"));
  const DataCheck check = Check();
  ASSERT_EQ(check.changed.size(), 1U);
  EXPECT_TRUE(check.changed[0].starts_with(RevisionPrefix(flight_, first) + "mosaic.tif"))
      << check.changed[0];
  ASSERT_EQ(check.missing.size(), 1U);
  EXPECT_TRUE(check.missing[0].starts_with(RevisionPrefix(flight_, first) + "report.json"))
      << check.missing[0];
  EXPECT_FALSE(check.IsWell());
}

TEST_F(CheckedMaps, AreLeftOutWhereNothingIsKnownOfThem) {
  const std::int64_t first = Stored({});
  Put(first, "mosaic.tif", made_ / "mosaic.tif");
  const DataCheck check = Check();
  EXPECT_TRUE(check.IsWell());
  EXPECT_EQ(check.maps_without_sums, 1);
}

}  // namespace
}  // namespace skyquilt::storage
