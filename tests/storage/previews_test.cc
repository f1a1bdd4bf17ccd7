#include "storage/catalogue/previews.h"

#include "storage/catalogue/event_log.h"
#include "storage/db/ids.h"
#include "tests/storage/catalogue_fixture.h"

namespace skyquilt::storage {
namespace {

class PreviewsTest : public CatalogueFixture {
 protected:
  std::string FlightWith(int files) {
    const std::string id = catalogue_.AddFlight("f", "{}", Now())->id;
    for (int i = 0; i < files; ++i) AddFile(id, std::to_string(i) + ".jpg");
    return id;
  }
  void AddFile(const std::string& flight, const std::string& name) {
    ASSERT_TRUE(catalogue_.AddFile(flight, {name, NewId(), 10}, Now()));
  }
  Preview Edition(const std::string& flight, std::int64_t edition, std::int64_t photos) {
    return {flight, "preview-a", edition, photos, 12, 20, {1, 2, 3, 4}, {1.5, 2.5, 2.25, 3.5}};
  }

  Previews previews_{*db_};
};

TEST_F(PreviewsTest, HandsOutEveryFileOnceAndTheLeastServedFlightFirst) {
  const std::string first = FlightWith(3);
  const auto two = previews_.Claim(2);
  ASSERT_TRUE(two && *two);
  EXPECT_EQ((*two)->fresh.size(), 2u);
  EXPECT_TRUE((*two)->tried.empty());
  ASSERT_TRUE(*previews_.Show(Edition(first, 1, 2)));
  const std::string second = FlightWith(1);
  EXPECT_EQ((**previews_.Claim(5)).flight_id, second);
  const auto rest = previews_.Claim(5);
  EXPECT_EQ((*rest)->flight_id, first);
  EXPECT_EQ((*rest)->fresh.size(), 1u);
  EXPECT_EQ((*rest)->tried.size(), 2u);
  EXPECT_FALSE(*previews_.Claim(5));
}

TEST_F(PreviewsTest, WhatWasGivenBackIsHandedOutAgain) {
  FlightWith(3);
  const auto work = previews_.Claim(2);
  ASSERT_TRUE(work && *work);
  ASSERT_TRUE(previews_.GiveBack({(*work)->fresh[0]}));
  const auto again = previews_.Claim(5);
  ASSERT_TRUE(again && *again);
  EXPECT_EQ((*again)->fresh.size(), 2u);
  EXPECT_EQ((*again)->tried.size(), 1u);
}

TEST_F(PreviewsTest, SaysWhereEachEditionChangedAndEndsWithTheMap) {
  const std::string flight = FlightWith(1);
  ASSERT_TRUE(previews_.Claim(1));
  ASSERT_TRUE(*previews_.Show(Edition(flight, 1, 1)));
  ASSERT_TRUE(*previews_.Show(Edition(flight, 2, 1)));
  EXPECT_EQ((*previews_.Find(flight))->edition, 2);
  int told = 0;
  const auto events = EventLog(*db_).After(0, {flight, std::nullopt}, 100);
  ASSERT_TRUE(events);
  for (const Event& event : *events) {
    if (event.kind != "preview") continue;
    ++told;
    EXPECT_NE(event.body.find("\"changed\":[1.5,2.5,2.25,3.5]"), std::string::npos) << event.body;
  }
  EXPECT_EQ(told, 2);
  PublishMap(flight);
  EXPECT_FALSE(*previews_.Find(flight));
  EXPECT_FALSE(*previews_.Show(Edition(flight, 3, 2)));
  EXPECT_FALSE(*previews_.Show(Edition(flight, 1, 1)));
  AddFile(flight, "late.jpg");
  EXPECT_FALSE(*previews_.Claim(1));
}

TEST_F(PreviewsTest, BeginsAnewWhenAFileOfItGoesAndNotWhenAnotherDoes) {
  const std::string flight = FlightWith(3);
  const auto work = previews_.Claim(3);
  ASSERT_TRUE(previews_.Forgo({(*work)->fresh[2]}));
  ASSERT_TRUE(*previews_.Show(Edition(flight, 1, 2)));
  ASSERT_TRUE(catalogue_.RemoveFile(flight, (*work)->fresh[2].name));
  EXPECT_TRUE(*previews_.Find(flight));
  ASSERT_TRUE(catalogue_.RemoveFile(flight, (*work)->fresh[0].name));
  EXPECT_FALSE(*previews_.Find(flight));
  EXPECT_FALSE(*previews_.Show(Edition(flight, 2, 2)));
  EXPECT_EQ((**previews_.Claim(3)).fresh.size(), 1u);
}

TEST(PreviewTiles, HoldsWhatWasPutAndNothingIsMadeByReading) {
  const test::TemporaryFolder dir;
  EXPECT_EQ(PreviewTiles::OpenToRead(dir.path()).error().code, ErrorCode::kNotFound);
  const auto written = *PreviewTiles::Open(dir.path());
  const geo::TileId tile = *geo::TileId::Make(3, 1, 2);
  ASSERT_TRUE(written->Put({{tile, "old"}}));
  ASSERT_TRUE(written->Put({{tile, "new"}}));
  const auto read = *PreviewTiles::OpenToRead(dir.path());
  EXPECT_EQ(*(*read->Find(tile))->bytes, "new");
  EXPECT_FALSE(*read->Find(tile.Parent()));
}

}  // namespace
}  // namespace skyquilt::storage
