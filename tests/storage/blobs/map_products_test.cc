#include "storage/jobs/map_products.h"

#include <gtest/gtest.h>

#include <fstream>

#include "storage/blobs/range_cache.h"
#include "storage/blobs/sha256.h"
#include "tests/storage/blobs/published_map.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

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
  EXPECT_EQ(ProductsIn(folder_ / "none").error().code, ErrorCode::kIo);
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

}  // namespace
}  // namespace skyquilt::storage
