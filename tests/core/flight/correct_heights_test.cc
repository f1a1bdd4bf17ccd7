// EXIF that was corrected after the flight beside the maker's XMP, which was not: whose altitude is used, and
// what it counts from.
#include "core/flight/photos/correct_heights.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "core/flight/photos/read_photo.h"
#include "core/flight/read_flight.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/geoid.h"
#include "tests/core/flight/synthetic_photo.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

// A photo whose XMP puts it at 46 degrees north, 7 east and at an altitude of 560 m, 60 m above take-off.
struct TwiceTagged {
  double exif_altitude_m = 560.0;
  double moved_deg = 1.5e-5;  // EXIF's latitude, by 1.7 m
  double along_deg = 0.0;     // EXIF's place, as far ahead on the way of flight
  double beside_deg = 0.0;    // and as far to its right
  std::uint16_t reference = 0;
  std::string more{};  // in XMP
};

// Of ten photos, the first five on the way north, the others on the way back beside it.
Bytes BytesOfTwiceTagged(int number, const TwiceTagged& tags) {
  const bool is_back = number >= 5;
  const double sign = is_back ? -1.0 : 1.0;
  const double lat_deg = 46.0 + 1e-4 * (is_back ? 9 - number : number);
  const double lon_deg = is_back ? 7.0001 : 7.0;
  const auto altitude_mm = static_cast<std::uint32_t>(std::llround(1000.0 * tags.exif_altitude_m));
  const ExifWriter exif =
      ExifWriter()
          .Position(lat_deg + tags.moved_deg + sign * tags.along_deg, lon_deg + sign * tags.beside_deg)
          .Short(ExifIfd::kGps, 5, tags.reference)
          .Rational(ExifIfd::kGps, 6, {{altitude_mm, 1000}});
  const std::string xmp = fmt::format(
      "{}drone-dji:GpsLatitude=\"{:.8f}\" drone-dji:GpsLongitude=\"{:.8f}\" "
      "drone-dji:AbsoluteAltitude=\"+560.00\" drone-dji:RelativeAltitude=\"+60.00\" {}",
      kDjiNamespace, lat_deg, lon_deg, tags.more);
  return JpegHeader({.exif = exif.Write(), .xmp = XmpPacket(xmp)});
}

// The first `tagged` of the photos, the others up to `end` as the camera wrote them.
struct CorrectedFlight {
  explicit CorrectedFlight(const TwiceTagged& tags, int tagged = 10, int end = 10) {
    TwiceTagged untouched;
    untouched.moved_deg = 0.0;
    untouched.more = tags.more;
    for (int i = 0; i < end; ++i) Add(i, i < tagged ? tags : untouched);
    TakeCorrectedHeights(photos, warnings);
  }

  void Add(int number, const TwiceTagged& tags) {
    photos.push_back(test::ValueOf(ReadPhotoFromBytes("a.jpg", BytesOfTwiceTagged(number, tags))));
  }

  const RecordedPosition& first() const { return photos.front().position.value(); }
  // What told the zero, as it is said; nothing where the heights are those of XMP.
  std::optional<RemarkCode> zero() const {
    if (warnings.empty()) return std::nullopt;
    EXPECT_EQ(warnings.front().code, RemarkCode::kExifCorrected);
    return std::get<std::vector<Remark>>(warnings.front().values.at("zero").is).front().code;
  }
  bool doubts_altitudes() const {
    const auto& notes = photos.front().notes;
    return std::any_of(notes.begin(), notes.end(),
                       [](const Remark& note) { return note.code == RemarkCode::kAltitudesApart; });
  }

  std::vector<Photo> photos;
  std::vector<Remark> warnings;
};

TEST(TakeCorrectedHeights, FindsTheZeroThatFitsTheAltitudesInXmp) {
  const auto geoid_m = geo::GeoidHeightM({46.0, 7.0});
  if (!geoid_m) GTEST_SKIP() << "PROJ has no EGM96 grid here (Debian: proj-data)";
  const std::string by_rtk = "drone-dji:RtkFlag=\"16\"";  // counts from the ellipsoid
  for (const auto& [more, ellipsoid_m] : {std::pair<std::string, double>{"", 560.0 + *geoid_m},
                                          std::pair<std::string, double>{by_rtk, 560.0}}) {
    SCOPED_TRACE(more);
    const double corrected_m = ellipsoid_m + 3.0;
    const CorrectedFlight ellipsoidal(TwiceTagged{.exif_altitude_m = corrected_m, .more = more});
    EXPECT_EQ(ellipsoidal.zero(), RemarkCode::kFromEllipsoidFound);
    EXPECT_NEAR(ellipsoidal.first().height_ellipsoid_m.value(), corrected_m, 1e-3);
    EXPECT_FALSE(ellipsoidal.first().height_amsl_m);
    EXPECT_EQ(ellipsoidal.first().height_above_takeoff_m, 60.0);
    const CorrectedFlight from_sea(TwiceTagged{.exif_altitude_m = corrected_m - *geoid_m, .more = more});
    EXPECT_EQ(from_sea.zero(), RemarkCode::kFromSeaFound);
    EXPECT_NEAR(from_sea.first().height_amsl_m.value(), corrected_m - *geoid_m, 1e-3);
    EXPECT_FALSE(from_sea.first().height_ellipsoid_m);
    // Half-way between the two.
    const CorrectedFlight unknown(
        TwiceTagged{.exif_altitude_m = corrected_m - 3.0 - 0.5 * *geoid_m, .more = more});
    EXPECT_EQ(unknown.zero(), RemarkCode::kFromEllipsoidAssumed);
    EXPECT_TRUE(unknown.first().height_ellipsoid_m);
  }
}

TEST(TakeCorrectedHeights, CountsFromTheSeaWhereExifSaysSo) {
  const CorrectedFlight said(TwiceTagged{.exif_altitude_m = 640.0, .reference = 2});
  EXPECT_EQ(said.zero(), RemarkCode::kFromSeaSaid);
  EXPECT_EQ(said.first().height_amsl_m, 640.0);
  EXPECT_FALSE(said.doubts_altitudes()) << "what was decided";
}

TEST(TakeCorrectedHeights, CorrectsOnlyThePhotosThatWereChanged) {
  const CorrectedFlight part(TwiceTagged{.exif_altitude_m = 640.0, .reference = 2}, 7);
  EXPECT_EQ(part.first().height_amsl_m, 640.0);
  EXPECT_EQ(part.photos.back().position.value().height_amsl_m, 560.0);
}

// Heights of two zeros in one flight would bend it.
TEST(TakeCorrectedHeights, TakesTheAltitudeOfAPhotoWhosePlaceWasMovedByLittle) {
  std::vector<Photo> photos;
  for (int i = 0; i < 10; ++i) {
    const TwiceTagged tags{.exif_altitude_m = 640.0, .moved_deg = i == 3 ? 0.0 : 1.5e-5, .reference = 2};
    photos.push_back(test::ValueOf(ReadPhotoFromBytes("a.jpg", BytesOfTwiceTagged(i, tags))));
  }
  std::vector<Remark> warnings;
  TakeCorrectedHeights(photos, warnings);
  for (const Photo& photo : photos) EXPECT_EQ(photo.position.value().height_amsl_m, 640.0);
}

TEST(TakeCorrectedHeights, LeavesXmpsHeightsWhereOneOfThePlacesIsNoCorrection) {
  const std::pair<const char*, TwiceTagged> cases[] = {
      {"one place", TwiceTagged{.exif_altitude_m = 600.0, .moved_deg = 0.0}},
      {"a place in other steps", TwiceTagged{.exif_altitude_m = 600.0, .moved_deg = 1e-6}},
      {"another moment", TwiceTagged{.exif_altitude_m = 600.0, .moved_deg = 0.0, .along_deg = 1.5e-5}},
      {"another antenna", TwiceTagged{.exif_altitude_m = 600.0, .moved_deg = 0.0, .beside_deg = 2e-5}},
      {"one altitude", TwiceTagged{.exif_altitude_m = 560.1}},
      {"no altitude", TwiceTagged{.exif_altitude_m = 0.0}},
      {"the height above take-off", TwiceTagged{.exif_altitude_m = 61.5}}};
  for (const auto& [what, tags] : cases) {
    SCOPED_TRACE(what);
    const CorrectedFlight left(tags);
    EXPECT_FALSE(left.zero());
    EXPECT_EQ(left.first().height_amsl_m, 560.0);
  }
  const CorrectedFlight four(TwiceTagged{.exif_altitude_m = 640.0}, 4);
  EXPECT_FALSE(four.zero()) << "of four photos it is no evidence";
  EXPECT_EQ(four.first().height_amsl_m, 560.0);
  EXPECT_TRUE(four.doubts_altitudes());
  const CorrectedFlight one_way(TwiceTagged{.exif_altitude_m = 640.0}, 5, 5);
  EXPECT_FALSE(one_way.zero()) << "of another moment, or moved alike";
  EXPECT_EQ(one_way.first().height_amsl_m, 560.0);
}

TEST(TakeCorrectedHeights, HoldsForAFlightThatIsRead) {
  const test::TemporaryFolder folder;
  for (int i = 0; i < 10; ++i) {
    folder.Write(fmt::format("DJI_000{}.JPG", i),
                 BytesOfTwiceTagged(i, TwiceTagged{.exif_altitude_m = 600.0, .reference = 2}));
  }
  SilentProgress progress;
  const Flight flight =
      test::ValueOf(ReadFlight(test::ValueOf(ListInputFiles({folder.path()})), 1, progress));
  ASSERT_EQ(flight.photos.size(), 10U);
  for (const Photo& photo : flight.photos) EXPECT_EQ(photo.position.value().height_amsl_m, 600.0);
  EXPECT_EQ(std::count_if(flight.warnings.begin(), flight.warnings.end(),
                          [](const Remark& said) { return said.code == RemarkCode::kExifCorrected; }),
            1);
}

TEST(DropAltitudesOfZero, TakesThemForUnknownWhereAllPhotosHaveThem) {
  const auto altitudes_after = [](const std::vector<std::optional<double>>& altitudes_m) {
    std::vector<Photo> photos(altitudes_m.size());
    for (std::size_t i = 0; i < photos.size(); ++i) {
      photos[i].position.emplace();
      photos[i].position->height_amsl_m = altitudes_m[i];
    }
    photos.emplace_back();  // without a position
    std::vector<Remark> warnings;
    DropAltitudesOfZero(photos, warnings);
    std::vector<std::optional<double>> after;
    for (const Photo& photo : photos) {
      if (photo.position) after.push_back(photo.position->height_amsl_m);
    }
    EXPECT_EQ(warnings.empty(), after == altitudes_m);
    return after;
  };
  const std::vector<std::optional<double>> one_known{0.0, 0.0, 0.0, 3.5}, two{0.0, 0.0};
  EXPECT_EQ(altitudes_after({0.0, 0.0, 0.0}), (std::vector<std::optional<double>>(3)));
  EXPECT_EQ(altitudes_after({0.0, {}, 0.0, 0.0}), (std::vector<std::optional<double>>(4)));
  EXPECT_EQ(altitudes_after(one_known), one_known) << "a flight over the sea";
  EXPECT_EQ(altitudes_after(two), two);
}

// Over the sea and over the ellipsoid.
TEST(DropAltitudesOfZero, CountsAPhotoOfTwoAltitudesOnce) {
  std::vector<Photo> photos(2);
  std::vector<Remark> warnings;
  for (Photo& photo : photos) {
    photo.position.emplace();
    photo.position->height_amsl_m = photo.position->height_ellipsoid_m = 0.0;
  }
  DropAltitudesOfZero(photos, warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(photos[1].position->height_amsl_m, 0.0);
  photos.push_back(photos.front());
  DropAltitudesOfZero(photos, warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(InWords(warnings[0]).find("all 3 photos"), std::string::npos) << InWords(warnings[0]);
  for (const Photo& photo : photos) {
    EXPECT_FALSE(photo.position->height_amsl_m);
    EXPECT_FALSE(photo.position->height_ellipsoid_m);
  }
}

}  // namespace
}  // namespace skyquilt::flight
