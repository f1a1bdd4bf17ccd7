// Positions, heights and times: the traps of EXIF and XMP, one by one.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "core/flight/photos/read_photo.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/flight/synthetic_photo.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

Photo Read(const ExifWriter& exif, const std::string& xmp = "", bool is_big_endian = false) {
  return test::ValueOf(
      ReadPhotoFromBytes("a.jpg", JpegHeader({.exif = exif.Write(is_big_endian), .xmp = xmp})));
}

bool Notes(const Photo& photo, const std::string& words) {
  for (const std::string& note : InWords(photo.notes)) {
    if (note.find(words) != std::string::npos) return true;
  }
  return false;
}

using Parts = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

// North and east (or west), as the parts are written.
ExifWriter InParts(Parts lat, Parts lon, const std::string& lon_ref = "E") {
  return ExifWriter()
      .Rational(ExifIfd::kGps, 2, std::move(lat))
      .Rational(ExifIfd::kGps, 4, std::move(lon))
      .Ascii(ExifIfd::kGps, 1, "N")
      .Ascii(ExifIfd::kGps, 3, lon_ref);
}

std::string Dji(const std::string& attributes) { return XmpPacket(kDjiNamespace + attributes); }

TEST(ReadPhotoPosition, ReadsAllFourQuartersInBothByteOrders) {
  for (const bool is_big_endian : {false, true}) {
    for (const double lat : {-33.8567844, 46.8426070833}) {
      for (const double lon : {-91.9945598888, 151.2152967}) {
        const Photo photo = Read(ExifWriter().Position(lat, lon), "", is_big_endian);
        ASSERT_TRUE(photo.position);
        EXPECT_NEAR(photo.position->position.lat_deg, lat, 2e-8);
        EXPECT_NEAR(photo.position->position.lon_deg, lon, 2e-8);
        EXPECT_EQ(photo.position->source, "exif");
      }
    }
  }
}

TEST(ReadPhotoPosition, UnderstandsHemispheresAsPeopleWriteThem) {
  const Photo photo = Read(ExifWriter().Position(10.5, 20.5, "south", "west"));
  ASSERT_TRUE(photo.position);
  EXPECT_NEAR(photo.position->position.lat_deg, -10.5, 1e-7);
  EXPECT_NEAR(photo.position->position.lon_deg, -20.5, 1e-7);
}

TEST(ReadPhotoPosition, SaysWhenTheHemisphereIsMissing) {
  const Photo guessed = Read(ExifWriter().Position(10.5, 20.5, "", ""));
  ASSERT_TRUE(guessed.position);
  EXPECT_NEAR(guessed.position->position.lat_deg, 10.5, 1e-7);
  EXPECT_TRUE(Notes(guessed, "north or south"));
  const Photo known = Read(ExifWriter().Position(10.5, 20.5, "", ""),
                           Dji("drone-dji:GpsLatitude=\"-10.5\" drone-dji:GpsLongtitude=\"-20.5\""));
  ASSERT_TRUE(known.position);
  EXPECT_EQ(known.position->position.lat_deg, -10.5);
  EXPECT_EQ(known.position->position.lon_deg, -20.5);
}

TEST(ReadPhotoPosition, TreatsZeroZeroAsNoFix) {
  const Photo photo =
      Read(ExifWriter().Position(0.0, 0.0), Dji("drone-dji:Latitude=\"0\" drone-dji:Longitude=\"0\""));
  EXPECT_FALSE(photo.position);
  EXPECT_TRUE(Notes(photo, "no fix"));
  EXPECT_TRUE(Read(ExifWriter().Position(0.0, 6.5)).position);  // the equator is a place
}

TEST(ReadPhotoPosition, RefusesWhatIsNotOnEarth) {
  EXPECT_FALSE(Read(ExifWriter().Position(91.0, 5.0)).position);
  EXPECT_FALSE(Read(ExifWriter().Position(45.0, 181.0)).position);
  EXPECT_FALSE(Read(InParts({{46, 0}, {50, 1}, {3, 1}}, {{9, 1}, {5, 1}, {3, 1}})).position);
  EXPECT_FALSE(Read(ExifWriter().Ascii(ExifIfd::kImage, 0x010F, "DJI")).position);
  EXPECT_FALSE(Read(ExifWriter().Ascii(ExifIfd::kImage, 0x010F, "DJI"),
                    Dji("drone-dji:GpsLatitude=\"nan\" drone-dji:GpsLongitude=\"5\""))
                   .position);
}

TEST(ReadPhotoPosition, ReadsDecimalMinutesWithEmptySeconds) {
  const Photo photo = Read(InParts({{46, 1}, {505567, 10000}, {0, 0}}, {{91, 1}, {595, 10}, {0, 1}}, "W"));
  ASSERT_TRUE(photo.position);
  EXPECT_NEAR(photo.position->position.lat_deg, 46.0 + 50.5567 / 60.0, 1e-9);
  EXPECT_NEAR(photo.position->position.lon_deg, -(91.0 + 59.5 / 60.0), 1e-9);
}

TEST(ReadPhotoPosition, IsAsUnsureAsTheStepsInWhichItIsWritten) {
  const auto sigma_of = [](Parts::value_type minutes, Parts::value_type seconds) {
    return Read(InParts({{46, 1}, minutes, seconds}, {{7, 1}, minutes, seconds}))
        .position->sigma_horizontal_m;
  };
  EXPECT_NEAR(sigma_of({50, 1}, {33, 1}).value(), 9.05, 0.1);  // 31 m / sqrt(12), and the receiver's
  EXPECT_FALSE(sigma_of({50, 1}, {3345, 100})) << "a third of a metre is less than it is unsure anyway";
  EXPECT_FALSE(sigma_of({505567, 10000}, {0, 1})) << "the decimals stand in the minutes";
}

// 46.8426 N by the parts given, 7.5 E.
Photo OfLatitude(Parts parts) { return Read(InParts(std::move(parts), {{7, 1}, {30, 1}, {0, 1}})); }

TEST(ReadPhotoPosition, CountsDecimalsThatAreWrittenTwiceOnce) {
  const double seconds = 33.36;  // 46 degrees, 50.556 minutes
  for (const Photo& photo : {OfLatitude({{468426, 10000}, {50, 1}, {3336, 100}}),
                             OfLatitude({{46, 1}, {50556, 1000}, {3336, 100}}),
                             OfLatitude({{468426, 10000}, {50556, 1000}, {3336, 100}}),
                             OfLatitude({{468426, 10000}, {50556, 1000}, {0, 1}})}) {
    ASSERT_TRUE(photo.position);
    EXPECT_NEAR(photo.position->position.lat_deg, 46.0 + 50.0 / 60.0 + seconds / 3600.0, 1e-9);
    EXPECT_TRUE(Notes(photo, "counted once"));
  }
  EXPECT_FALSE(Notes(OfLatitude({{46, 1}, {50, 1}, {3336, 100}}), "counted once"));
  EXPECT_FALSE(Notes(OfLatitude({{468426, 10000}, {0, 1}, {0, 1}}), "counted once"));
}

TEST(ReadPhotoPosition, DoesNotBelieveDecimalsThatTheNextPartsContradict) {
  for (const Photo& photo :
       {OfLatitude({{468426, 10000}, {12, 1}, {0, 1}}), OfLatitude({{46, 1}, {50556, 1000}, {5, 1}})}) {
    EXPECT_FALSE(photo.position);
    EXPECT_TRUE(Notes(photo, "not used"));
  }
}

TEST(ReadPhotoPosition, DoesNotBelievePartsThatAreMoreThanAWholeOfTheOneBefore) {
  for (const Parts& parts : {Parts{{46, 1}, {50, 1}, {3336, 1}}, Parts{{46, 1}, {505567, 1000}, {0, 1}},
                             Parts{{0, 1}, {50, 1}, {3336, 1}}}) {
    const Photo photo = OfLatitude(parts);
    EXPECT_FALSE(photo.position);
    EXPECT_TRUE(Notes(photo, "cannot be read"));
  }
  const auto with_copy = [](const std::string& latitude) {
    return Read(InParts({{46, 1}, {50, 1}, {3336, 1}}, {{7, 1}, {30, 1}, {0, 1}}),
                XmpPacket("xmlns:exif=\"http://ns.adobe.com/exif/1.0/\" exif:GPSLatitude=\"" + latitude +
                          "\" exif:GPSLongitude=\"7,30.0E\""));
  };
  EXPECT_FALSE(with_copy("46,105.6N").position) << "the same lost point";
  EXPECT_TRUE(with_copy("46,50.556N").position);
  EXPECT_TRUE(OfLatitude({{46, 1}, {50, 1}, {60, 1}}).position) << "rounded up";
  EXPECT_TRUE(OfLatitude({{0, 1}, {28105567, 10000}, {0, 1}}).position) << "all in minutes";
}

TEST(ReadPhotoPosition, SaysOfWhichDatumAPositionIs) {
  const auto of = [](const std::string& datum) {
    return Read(ExifWriter().Position(35.6, 139.7).Ascii(ExifIfd::kGps, 0x12, datum));
  };
  for (const char* datum : {"TOKYO", "Tokyo Datum", "NAD-27"}) {
    EXPECT_TRUE(Notes(of(datum), "beside WGS 84")) << datum;
    EXPECT_GT(of(datum).position->system_error_m.value_or(0.0), 100.0) << datum;
  }
  for (const char* datum : {"WGS-84", "WGS 84", "JGD2011", "NAD83", "", "?"})
    EXPECT_FALSE(Notes(of(datum), "beside WGS 84") || of(datum).position->system_error_m) << datum;
}

TEST(ReadPhotoPosition, ReadsDecimalCommas) {
  const Photo photo = Read(ExifWriter(), Dji("drone-dji:GpsLatitude=\"46,84260708\" "
                                             "drone-dji:GpsLongitude=\"-91,99455988\" "
                                             "drone-dji:RelativeAltitude=\"+73,10\""));
  ASSERT_TRUE(photo.position);
  EXPECT_NEAR(photo.position->position.lat_deg, 46.84260708, 1e-9);
  EXPECT_NEAR(photo.position->position.lon_deg, -91.99455988, 1e-9);
  EXPECT_EQ(photo.position->height_above_takeoff_m, 73.1);
  // A list, or thousands.
  for (const char* text : {"560,650", "1,234.5", "1,2,3", "46,", ",5", "1,2e3", "46,84 N"})
    EXPECT_FALSE(Read(ExifWriter().Position(46.0, 7.0),
                      Dji(std::string("drone-dji:RelativeAltitude=\"") + text + "\""))
                     .position->height_above_takeoff_m)
        << text;
}

TEST(ReadPhotoPosition, PrefersTheFinerOfTwoWritingsOfOnePosition) {
  const ExifWriter coarse = InParts({{46, 1}, {50, 1}, {33, 1}}, {{91, 1}, {59, 1}, {40, 1}}, "W");
  const Photo photo =
      Read(coarse, Dji("drone-dji:GpsLatitude=\"46.84261\" drone-dji:GpsLongitude=\"-91.99455\""));
  ASSERT_TRUE(photo.position);
  EXPECT_EQ(photo.position->position.lat_deg, 46.84261);
  const Photo corrected =
      Read(ExifWriter().Position(46.84263, -91.99455),
           Dji("drone-dji:GpsLatitude=\"46.84261\" drone-dji:GpsLongitude=\"-91.99455\""));
  EXPECT_NEAR(corrected.position->position.lat_deg, 46.84263, 2e-8);  // somebody put EXIF right
}

TEST(ReadPhotoPosition, ReadsXmpAloneInEveryNaming) {
  const std::string skydio = XmpPacket(
      "xmlns:q=\"https://www.skydio.com/drone-skydio/1.0/\" q:Latitude=\"1.5\" q:Longitude=\"2.5\" "
      "q:AbsoluteAltitude=\"77\"");
  const std::string exif_in_xmp = XmpPacket(
      "xmlns:exif=\"http://ns.adobe.com/exif/1.0/\" exif:GPSLatitude=\"1,30.0N\" "
      "exif:GPSLongitude=\"2,30,0E\"");
  for (const std::string& xmp :
       {Dji("drone-dji:Latitude=\"1.5\" drone-dji:Longitude=\"2.5\""), skydio, exif_in_xmp}) {
    const auto photo = test::ValueOf(ReadPhotoFromBytes("a.jpg", JpegHeader({.xmp = xmp})));
    ASSERT_TRUE(photo.position);
    EXPECT_NEAR(photo.position->position.lat_deg, 1.5, 1e-12);
    EXPECT_NEAR(photo.position->position.lon_deg, 2.5, 1e-12);
    EXPECT_EQ(photo.position->source, "xmp");
  }
}

TEST(ReadPhotoHeights, KeepsEachZeroApart) {
  const Photo photo =
      Read(ExifWriter().Position(46.0, 7.0).Rational(ExifIfd::kGps, 6, {{198309, 1000}}),
           Dji("drone-dji:AbsoluteAltitude=\"+198.31\" drone-dji:RelativeAltitude=\"+39.80\""));
  EXPECT_EQ(photo.position->height_amsl_m, 198.31);
  EXPECT_EQ(photo.position->height_above_takeoff_m, 39.80);
  EXPECT_FALSE(photo.position->height_ellipsoid_m);
  EXPECT_FALSE(photo.position->is_rtk_fixed);
}

TEST(ReadPhotoHeights, KeepsTheHeightOfAPhotoWhosePositionWasTakenOut) {
  const auto photo = test::ValueOf(ReadPhotoFromBytes(
      "a.jpg",
      JpegHeader(
          {.xmp = Dji("drone-dji:AbsoluteAltitude=\"+198.31\" drone-dji:RelativeAltitude=\"+39.80\"")})));
  EXPECT_FALSE(photo.position);
  EXPECT_EQ(photo.lone_height_above_takeoff_m, 39.80);
}

TEST(ReadPhotoHeights, TakesRtkHeightsAsEllipsoidal) {
  const std::string rtk =
      "drone-dji:AbsoluteAltitude=\"+51.2\" drone-dji:RtkStdLon=\"0.012\" "
      "drone-dji:RtkStdLat=\"0.016\" drone-dji:RtkStdHgt=\"0.031\" ";
  const Photo fixed = Read(ExifWriter().Position(46.0, 7.0), Dji(rtk + "drone-dji:RtkFlag=\"50\""));
  EXPECT_TRUE(fixed.position->is_rtk_fixed);
  EXPECT_EQ(fixed.position->height_ellipsoid_m, 51.2);
  EXPECT_FALSE(fixed.position->height_amsl_m);
  EXPECT_NEAR(fixed.position->sigma_horizontal_m.value(), std::sqrt((0.012 * 0.012 + 0.016 * 0.016) / 2),
              1e-12);
  EXPECT_EQ(fixed.position->sigma_vertical_m, 0.031);
  for (const char* flag : {"16", "34", "0"}) {
    EXPECT_FALSE(Read(ExifWriter().Position(46.0, 7.0), Dji(rtk + "drone-dji:RtkFlag=\"" + flag + "\""))
                     .position->is_rtk_fixed);
  }
}

TEST(ReadPhotoHeights, TakesRtkHeightsOfNoReceiverOfRtkAsAboveTheSea) {
  const auto height_of = [](const std::string& tags) {
    return test::ValueOf(
        Read(ExifWriter().Position(46.0, 7.0), Dji("drone-dji:AbsoluteAltitude=\"+317.547\" " + tags))
            .position);
  };
  for (const char* of_receiver : {"drone-dji:RtkFlag=\"0\"", "drone-dji:RtkStdHgt=\"2.5\""}) {
    EXPECT_EQ(height_of("drone-dji:AltitudeType=\"RtkAlt\" " + std::string(of_receiver)).height_ellipsoid_m,
              317.547)
        << of_receiver;
  }
  EXPECT_EQ(height_of("drone-dji:AltitudeType=\"RtkAlt\"").height_amsl_m, 317.547);
  EXPECT_EQ(height_of("drone-dji:AltitudeType=\"GpsFusionAlt\" drone-dji:RtkFlag=\"16\"").height_amsl_m,
            317.547);
}

// 549 m by EXIF, of a maker's aircraft.
RecordedPosition At549(const std::string& make, const std::string& model, const std::string& xmp = "") {
  const Photo photo = Read(ExifWriter()
                               .Position(46.0, 7.0)
                               .Rational(ExifIfd::kGps, 6, {{549, 1}})
                               .Ascii(ExifIfd::kImage, 0x010F, make)
                               .Ascii(ExifIfd::kImage, 0x0110, model),
                           xmp.empty() ? "" : XmpPacket(xmp));
  EXPECT_TRUE(photo.position);
  return photo.position.value_or(RecordedPosition{});
}

TEST(ReadPhotoHeights, CountsFromTheZeroThatThePhotoOrItsMakerNames) {
  const auto zero = [](const std::string& name) {
    return "xmlns:Camera=\"http://pix4d.com/camera/1.0/\" Camera:VertCS=\"" + name + "\"";
  };
  const std::string skydio_sea =
      "xmlns:s=\"https://www.skydio.com/drone-skydio/1.0/\" s:AbsoluteAltitude=\"500\"";
  for (const RecordedPosition& above_ellipsoid :
       {At549("SONY", "DSC-RX1RM2", zero("ellipsoidal")), At549("SONY", "DSC-RX1RM2", zero("EPSG:4979")),
        At549("senseFly", "S.O.D.A."), At549("Skydio", "VT300-L_93")}) {
    EXPECT_EQ(above_ellipsoid.height_ellipsoid_m, 549.0);
    EXPECT_FALSE(above_ellipsoid.height_amsl_m);
  }
  for (const RecordedPosition& above_sea :
       {At549("SONY", "DSC-RX1RM2"), At549("senseFly", "S.O.D.A.", zero("EGM96")),
        At549("Skydio", "Skydio 2"), At549("Autel Robotics", "XT701", zero("ellipsoidal"))}) {
    EXPECT_EQ(above_sea.height_amsl_m, 549.0);
    EXPECT_FALSE(above_sea.height_ellipsoid_m);
  }
  EXPECT_EQ(At549("Skydio", "VT300-L_93", skydio_sea).height_amsl_m, 500.0);
}

// An X10 whose two heights differ by the geoid, 26.28 m.
TEST(ReadPhotoHeights, TakesEachOfSkydiosHeightsForWhatItIs) {
  const std::string both =
      "xmlns:s=\"https://www.skydio.com/drone-skydio/1.0/\" s:AbsoluteAltitude=\"20.1\" "
      "s:GpsMslHeight=\"46.38\" s:GpsHorizontalAccuracy=\"0.25\" s:GpsVerticalAccuracy=\"0.5\" ";
  const RecordedPosition unsaid = At549("Skydio", "VT300-L_93", both);
  EXPECT_EQ(unsaid.height_amsl_m, 46.38);
  EXPECT_FALSE(unsaid.height_ellipsoid_m);
  EXPECT_EQ(unsaid.sigma_horizontal_m, 0.25);
  EXPECT_EQ(unsaid.sigma_vertical_m, 0.5);
  const RecordedPosition said = At549("Skydio", "VT300-L_93", both + "s:VertCS=\"ellipsoidal\"");
  EXPECT_EQ(said.height_amsl_m, 46.38);
  EXPECT_EQ(said.height_ellipsoid_m, 20.1);
}

TEST(ReadPhotoHeights, ReadsEachMakersHeightAboveTakeOff) {
  const RecordedPosition phase_one = At549("Phase One", "iXM-100",
                                           "xmlns:aerialgps=\"http://www.phaseone.com/aerialgps/\" "
                                           "aerialgps:GPSAltitudeAboveTakeOff=\"151615/1000\"");
  EXPECT_NEAR(phase_one.height_above_takeoff_m.value(), 151.615, 1e-9);
  const RecordedPosition yuneec = At549("Yuneec", "E90",
                                        "xmlns:y=\"http://www.yuneec.com/drone-yuneec/1.0/\" "
                                        "y:GPSAltitude=\"549.00\" y:AboveHomeAltitude=\"34.40\"");
  EXPECT_EQ(yuneec.height_above_takeoff_m, 34.4);
  EXPECT_EQ(yuneec.height_amsl_m, 549.0);
}

TEST(ReadPhotoHeights, SeesARelativeHeightInTheExifAltitude) {
  const Photo photo = Read(ExifWriter().Position(46.0, 7.0).Rational(ExifIfd::kGps, 6, {{73, 1}}),
                           Dji("drone-dji:AbsoluteAltitude=\"824.6\" drone-dji:RelativeAltitude=\"73.0\""));
  EXPECT_EQ(photo.position->height_amsl_m, 824.6);
  EXPECT_TRUE(Notes(photo, "height above take-off"));
  const Photo only_relative = Read(ExifWriter().Position(46.0, 7.0).Rational(ExifIfd::kGps, 6, {{73, 1}}),
                                   Dji("drone-dji:RelativeAltitude=\"73.0\""));
  EXPECT_FALSE(only_relative.position->height_amsl_m);
}

TEST(ReadPhotoHeights, RefusesImpossibleAltitudes) {
  for (const std::uint32_t altitude : {117991907u, 13490u}) {
    const Photo photo = Read(ExifWriter().Position(46.0, 7.0).Rational(ExifIfd::kGps, 6, {{altitude, 1}}));
    EXPECT_FALSE(photo.position->height_amsl_m);
    EXPECT_TRUE(Notes(photo, "impossible"));
  }
}

TEST(ReadPhotoHeights, ReadsDepthsBelowTheSea) {
  const std::pair<std::uint16_t, double> height_by_reference[] = {
      {0, 390.0}, {1, -390.0}, {2, 390.0}, {3, -390.0}};  // the last two by Exif 3
  for (const auto& [reference, height_m] : height_by_reference) {
    const Photo photo = Read(ExifWriter()
                                 .Position(31.5, 35.5)
                                 .Rational(ExifIfd::kGps, 6, {{390, 1}})
                                 .Undefined(ExifIfd::kGps, 5, {0})
                                 .Short(ExifIfd::kGps, 5, reference));
    EXPECT_EQ(photo.position->height_amsl_m, height_m) << reference;
    const std::string xmp = XmpPacket(
        "xmlns:exif=\"http://ns.adobe.com/exif/1.0/\" exif:GPSLatitude=\"31,30.0N\" "
        "exif:GPSLongitude=\"35,30.0E\" exif:GPSAltitude=\"390/1\" exif:GPSAltitudeRef=\"" +
        std::to_string(reference) + "\"");
    const auto by_xmp = test::ValueOf(ReadPhotoFromBytes("a.jpg", JpegHeader({.xmp = xmp})));
    EXPECT_EQ(by_xmp.position.value().height_amsl_m, height_m) << reference;
  }
}

TEST(ReadPhotoHeights, ReadsTheReferenceOfAnAltitudeThatIsWrittenAsACharacter) {
  const std::pair<char, double> height_by_character[] = {{'0', 390.0}, {'1', -390.0}, {'3', -390.0}};
  for (const auto& [character, height_m] : height_by_character) {
    const auto tags = [] { return ExifWriter().Position(31.5, 35.5).Rational(ExifIfd::kGps, 6, {{390, 1}}); };
    const Bytes byte(1, static_cast<std::uint8_t>(character));
    for (const ExifWriter& written :
         {tags().Ascii(ExifIfd::kGps, 5, std::string(1, character)), tags().Undefined(ExifIfd::kGps, 5, byte),
          tags().Short(ExifIfd::kGps, 5, byte.front())}) {
      EXPECT_EQ(Read(written).position.value().height_amsl_m, height_m) << character;
    }
  }
}

TEST(ReadPhotoTime, TakesTwoSubSecondDigitsAsHundredths) {
  const Photo photo = Read(ExifWriter()
                               .Ascii(ExifIfd::kExif, 0x9003, "2021:06:03 12:34:56")
                               .Ascii(ExifIfd::kExif, 0x9291, "05")
                               .Ascii(ExifIfd::kExif, 0x9011, "+02:00"));
  using namespace std::chrono;
  EXPECT_EQ(photo.captured_at, sys_days(2021y / 6 / 3) + 10h + 34min + 56s + 50ms);
  EXPECT_FALSE(photo.receiver_time) << "only the camera's clock";
  EXPECT_FALSE(photo.captured_at_is_local);
  EXPECT_EQ(photo.clock_minus_utc, 2h);
}

// MicaSense's cameras write the fraction of the file's own time alone, and count it backwards at times.
TEST(ReadPhotoTime, TakesTheFractionOfTheFilesTimeWhereBothAreTheSame) {
  using namespace std::chrono;
  const auto time_of = [](const std::string& changed_at, const std::string& fraction) {
    return Read(ExifWriter()
                    .Ascii(ExifIfd::kImage, 0x0132, changed_at)
                    .Ascii(ExifIfd::kExif, 0x9003, "2021:06:03 12:34:56")
                    .Ascii(ExifIfd::kExif, 0x9290, fraction)
                    .Ascii(ExifIfd::kExif, 0x9011, "+00:00"))
        .captured_at;
  };
  const auto second = sys_days(2021y / 6 / 3) + 12h + 34min + 56s;
  EXPECT_EQ(time_of("2021:06:03 12:34:56", "25"), second + 250ms);
  EXPECT_EQ(time_of("2021:06:03 12:34:56", "-25"), second - 250ms);
  EXPECT_EQ(time_of("2021:06:04 10:00:00", "25"), second) << "the file was changed later";
}

TEST(ReadPhotoTime, FindsTheZoneFromTheGpsTimeAndKeepsTheClocksSteps) {
  using namespace std::chrono;
  for (const char* date : {"2021:06:03", "2021:06:03 12:34:56", "2021: 6: 3"}) {
    const Photo photo = Read(ExifWriter()
                                 .Ascii(ExifIfd::kExif, 0x9003, "2021:06:03 18:04:56")
                                 .Ascii(ExifIfd::kExif, 0x9291, "582")
                                 .Ascii(ExifIfd::kGps, 0x1D, date)
                                 .Rational(ExifIfd::kGps, 7, {{12, 1}, {34, 1}, {56, 1}}));
    EXPECT_EQ(photo.captured_at, sys_days(2021y / 6 / 3) + 12h + 34min + 56s + 582ms) << date;  // +05:30
    EXPECT_EQ(photo.receiver_time, sys_days(2021y / 6 / 3) + 12h + 34min + 56s) << date;
    EXPECT_FALSE(photo.captured_at_is_local);
    EXPECT_EQ(photo.clock_minus_utc, 5h + 30min) << date;
  }
}

TEST(ReadPhotoTime, FindsTheDayOfAGpsTimeThatNamesNoneByAWrittenZone) {
  using namespace std::chrono;
  const auto in_zone = [](const char* zone) {
    return Read(ExifWriter()
                    .Ascii(ExifIfd::kExif, 0x9003, "2021:06:04 02:04:57")
                    .Ascii(ExifIfd::kExif, 0x9011, zone)
                    .Rational(ExifIfd::kGps, 7, {{20, 1}, {34, 1}, {56, 1}}));
  };
  EXPECT_EQ(in_zone("+05:30").receiver_time, sys_days(2021y / 6 / 3) + 20h + 34min + 56s);
  EXPECT_FALSE(in_zone("+05:15").receiver_time) << "not the time of that clock";
  EXPECT_TRUE(in_zone("").captured_at_is_local) << "the flight tells it";
}

TEST(ReadPhotoTime, BelievesTheGpsWhereTheClockIsFarOff) {
  using namespace std::chrono;
  const ExifWriter exif = ExifWriter()
                              .Ascii(ExifIfd::kExif, 0x9003, "2000:01:01 00:00:10")
                              .Ascii(ExifIfd::kGps, 0x1D, "2021:06:03")
                              .Rational(ExifIfd::kGps, 7, {{12, 1}, {34, 1}, {5650, 100}});
  const Photo photo = Read(exif);
  EXPECT_EQ(photo.captured_at, sys_days(2021y / 6 / 3) + 12h + 34min + 56s + 500ms);
  EXPECT_TRUE(Notes(photo, "disagree"));
  EXPECT_FALSE(photo.clock_minus_utc);
}

TEST(ReadPhotoTime, BelievesTheClockWhereTheReceiverNeverHadAFix) {
  using namespace std::chrono;
  for (const char* date : {"1980:01:06", "1999:08:22"}) {
    const Photo photo = Read(ExifWriter()
                                 .Ascii(ExifIfd::kExif, 0x9003, "2021:06:03 12:34:56")
                                 .Ascii(ExifIfd::kGps, 0x1D, date)
                                 .Rational(ExifIfd::kGps, 7, {{0, 1}, {0, 1}, {13, 1}}));
    EXPECT_EQ(photo.captured_at, sys_days(2021y / 6 / 3) + 12h + 34min + 56s) << date;
    EXPECT_TRUE(photo.captured_at_is_local);
    EXPECT_FALSE(photo.receiver_time);
    EXPECT_FALSE(Notes(photo, "disagree"));
  }
}

TEST(ReadPhotoTime, PrefersUtcOfTheExposure) {
  using namespace std::chrono;
  const Photo photo = Read(ExifWriter().Ascii(ExifIfd::kExif, 0x9003, "2021:06:03 14:34:56"),
                           Dji("drone-dji:UTCAtExposure=\"2021:06:03 12:34:56.123456\""));
  EXPECT_EQ(photo.captured_at, sys_days(2021y / 6 / 3) + 12h + 34min + 56s + 123456us);
  EXPECT_EQ(photo.receiver_time, photo.captured_at);
  EXPECT_FALSE(photo.captured_at_is_local);
  EXPECT_EQ(photo.clock_minus_utc, 2h);
}

TEST(ReadPhotoTime, FindsTheZoneOfAClockThatIsOffByMinutesAndNoneOfOneThatIsOffByMore) {
  const std::string utc = "drone-dji:UTCAtExposure=\"2021:06:03 12:34:56.0\"";
  const auto zone = [&](const char* clock) {
    return Read(ExifWriter().Ascii(ExifIfd::kExif, 0x9003, clock), Dji(utc)).clock_minus_utc;
  };
  using namespace std::chrono;
  EXPECT_EQ(zone("2021:06:03 08:31:02"), -4h);
  EXPECT_EQ(zone("2021:06:03 12:34:56"), 0h);
  EXPECT_FALSE(zone("2021:06:03 08:28:50")) << "six minutes off the nearest quarter";
  EXPECT_FALSE(zone("2010:01:01 00:00:10"));
}

TEST(ReadPhotoTime, MarksALocalClockAndRefusesImpossibleDates) {
  EXPECT_TRUE(Read(ExifWriter().Ascii(ExifIfd::kExif, 0x9003, "2021:06:03 14:34:56")).captured_at_is_local);
  for (const char* text : {"0000:00:00 00:00:00", "2021:13:03 14:34:56", "2021:02:30 14:34:56", "yesterday",
                           "2021:06:03 25:00:00", "    :  :     :  :  ", ""}) {
    EXPECT_FALSE(Read(ExifWriter().Ascii(ExifIfd::kExif, 0x9003, text)).captured_at) << text;
  }
}

TEST(Exposure, IsTimeBySensitivityAndOpening) {
  const auto tags = [] { return ExifWriter().Rational(ExifIfd::kExif, 0x829A, {{1, 400}}); };
  const Photo whole =
      Read(tags().Short(ExifIfd::kExif, 0x8827, 200).Rational(ExifIfd::kExif, 0x829D, {{4, 1}}));
  EXPECT_NEAR(whole.exposure_log2.value(), std::log2(1.0 / 400.0) + 1.0 - 4.0, 1e-9);
  const Photo fixed_lens = Read(tags().Short(ExifIfd::kExif, 0x8827, 100));
  EXPECT_NEAR(fixed_lens.exposure_log2.value(), std::log2(1.0 / 400.0), 1e-9);
  EXPECT_FALSE(Read(tags()).exposure_log2);
  EXPECT_FALSE(Read(tags().Short(ExifIfd::kExif, 0x8827, 0)).exposure_log2);
  EXPECT_FALSE(Read(ExifWriter().Short(ExifIfd::kExif, 0x8827, 100)).exposure_log2);
}

}  // namespace
}  // namespace skyquilt::flight
