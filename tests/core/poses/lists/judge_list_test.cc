// One list by itself: as what its numbers are read.
#include "core/poses/lists/judge_list.h"

#include <gtest/gtest.h>

#include <string>

namespace skyquilt::poses {
namespace {

// Surveyed in ETRS89 / UTM zone 32 N, the zone before the easting: 48.860609 N, 9.286313 E and some metres
// on.
WrittenList ZonedList(const std::string& system) {
  WrittenList list;
  list.use.system = system;
  list.use.order_is_named = true;
  for (const double on_m : {0.0, 20.0, 40.0, 60.0}) list.rows.push_back({32'521'000.0 + on_m, 5'412'000.0});
  return list;
}

void ExpectPlaced(const ListVerdict& verdict) {
  EXPECT_EQ(verdict.use.fault, flight::ListFault::kNone);
  ASSERT_EQ(verdict.places.size(), 4U);
  ASSERT_TRUE(verdict.places[0]);
  EXPECT_NEAR(verdict.places[0]->lat_deg, 48.8606086, 1e-6);
  EXPECT_NEAR(verdict.places[0]->lon_deg, 9.2863127, 1e-6);
}

TEST(JudgeList, ReadsEastingsWithTheZoneBeforeThemInTheZoneThatIsNamed) {
  for (const char* system : {"EPSG:25832", "EPSG:4647"}) {
    SCOPED_TRACE(system);
    ExpectPlaced(JudgeList(ZonedList(system)));
  }
}

TEST(JudgeList, ReadsEastingsWithTheZoneBeforeThemInTheZoneOfThePhotos) {
  WrittenList list = ZonedList("");
  list.own_of_flight = geo::LatLon{48.861, 9.287};
  const ListVerdict verdict = JudgeList(list);
  EXPECT_EQ(verdict.use.reading.counts_in, flight::CountsIn::kUtmOfFlight);
  ExpectPlaced(verdict);
}

TEST(JudgeList, KnowsAnUnknownDatumAsWellAsThePhotosDo) {
  WrittenList list;
  list.use.system = "+proj=tmerc +lat_0=0 +lon_0=9 +k=1 +x_0=3500000 +y_0=0 +ellps=bessel +units=m";
  for (const double on_m : {0.0, 20.0, 40.0, 60.0}) list.rows.push_back({3'500'000.0 + on_m, 5'200'000.0});
  const ListVerdict alone = JudgeList(list);
  EXPECT_GT(alone.use.system_error_m.value_or(0.0), 150.0);
  list.own_of_row = alone.places;
  list.use.own_are_photos = true;
  const ListVerdict beside_photos = JudgeList(list);
  EXPECT_GT(beside_photos.use.system_error_m.value_or(0.0), 1.0);
  EXPECT_LT(beside_photos.use.system_error_m.value_or(0.0), 100.0);
}

}  // namespace
}  // namespace skyquilt::poses
