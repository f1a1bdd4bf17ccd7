#include <gtest/gtest.h>

#include <fstream>

#include "storage/folder/check_data.h"
#include "tests/storage/blobs/far_folder.h"
#include "tests/storage/blobs/published_map.h"

namespace skyquilt::storage {
namespace {

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
    const Result<void> compared = CheckMaps(*db_, far_, check, progress_);
    EXPECT_TRUE(compared.ok());
    return check;
  }

  test::FarFolder far_{folder_ / "far"};
  SilentProgress progress_;
};

TEST_F(CheckedMaps, AreHeldAgainstWhatTheirJobsLeft) {
  const std::int64_t first = Stored(*ProductsIn(made_));
  EXPECT_TRUE(Check().IsWell());
  std::ofstream(folder_ / "other") << "bytes of mosaic.tiF";  // as long
  Put(first, "mosaic.tif", folder_ / "other");
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
