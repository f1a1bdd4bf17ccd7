// The focal length from each of its sources, and images that are not the camera's full size.
#include "core/flight/photos/choose_intrinsics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string_view>

#include "core/camera/sensor_database.h"
#include "core/flight/photos/read_photo.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/flight/synthetic_photo.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

ChosenIntrinsics Choose(int width_px, int height_px, const ExifRecord& exif,
                        const std::string& attributes = "", const std::string& elements = "") {
  XmpTags xmp;
  EXPECT_TRUE(xmp.AddPacket(XmpPacket(attributes, elements)));
  std::vector<Remark> notes;
  return ChooseIntrinsics(width_px, height_px, exif, xmp, notes);
}

const std::string kDewarp =
    std::string(kDjiNamespace) +
    "drone-dji:CalibratedOpticalCenterX=\"2736\" drone-dji:CalibratedOpticalCenterY=\"1824\" "
    "drone-dji:CalibratedFocalLength=\"3666.67\" "
    "drone-dji:DewarpData=\"2018-09-04;3678.87,3677.12,-11.25,15.61,-0.26,0.11,0.0003,-0.0004,-0.03\" ";

TEST(ChooseIntrinsics, PrefersTheFactoryCalibration) {
  const auto chosen = Choose(5472, 3648, {}, kDewarp);
  EXPECT_EQ(chosen.source, FocalSource::kDewarpData);
  EXPECT_EQ(chosen.intrinsics.focal_x_px, 3678.87);
  EXPECT_EQ(chosen.intrinsics.focal_y_px, 3677.12);
  EXPECT_EQ(chosen.intrinsics.center_x_px, 2735.5 - 11.25);
  EXPECT_EQ(chosen.intrinsics.center_y_px, 1823.5 + 15.61);
  EXPECT_EQ(chosen.intrinsics.k1, -0.26);
  EXPECT_EQ(chosen.intrinsics.k2, 0.11);
  EXPECT_EQ(chosen.intrinsics.p1, 0.0003);
  EXPECT_EQ(chosen.intrinsics.p2, -0.0004);
  EXPECT_EQ(chosen.intrinsics.k3, -0.03);
}

TEST(ChooseIntrinsics, ScalesTheCalibrationToAResizedImage) {
  const auto half = Choose(2736, 1824, {}, kDewarp);
  EXPECT_DOUBLE_EQ(half.intrinsics.focal_x_px, 3678.87 / 2);
  EXPECT_DOUBLE_EQ(half.intrinsics.center_x_px, 1367.5 - 11.25 / 2);
  EXPECT_EQ(half.intrinsics.k1, -0.26);
}

TEST(ChooseIntrinsics, KeepsTheCalibrationOfAnImageCroppedToAnotherAspect) {
  EXPECT_EQ(Choose(5472, 3078, {}, kDewarp).intrinsics.focal_x_px, 3678.87);  // 16:9
  EXPECT_EQ(Choose(4864, 3648, {}, kDewarp).intrinsics.focal_x_px, 3678.87);  // 4:3
}

TEST(ChooseIntrinsics, DoesNotTakeOutDistortionTwice) {
  const auto chosen = Choose(5472, 3648, {}, kDewarp + "drone-dji:DewarpFlag=\"1\"");
  EXPECT_EQ(chosen.source, FocalSource::kDewarpData);
  EXPECT_FALSE(chosen.intrinsics.HasDistortion());
  EXPECT_TRUE(Choose(5472, 3648, {}, kDewarp + "drone-dji:DewarpFlag=\"0\"").intrinsics.HasDistortion());
}

TEST(ChooseIntrinsics, IgnoresEmptyAndAbsurdCalibrations) {
  for (const char* numbers : {"0,0,0,0,0,0,0,0,0", "nan,nan,0,0,0,0,0,0,0", "3678,1200,0,0,0,0,0,0,0",
                              "3678,3678,9000,0,0,0,0,0,0", "1,2,3", "", ",,,,,,,,"}) {
    const auto chosen = Choose(5472, 3648, {},
                               kDjiNamespace +
                                   std::string("drone-dji:CalibratedFocalLength=\"3666.67\" "
                                               "drone-dji:DewarpData=\"2018-09-04;") +
                                   numbers + "\"");
    EXPECT_EQ(chosen.source, FocalSource::kCalibrated) << numbers;
    EXPECT_EQ(chosen.intrinsics.focal_x_px, 3666.67);
  }
}

TEST(ChooseIntrinsics, TakesSkydiosCalibrationInThePixelsOfThePicture) {
  const auto calibrated = [](const std::string& center_x) {
    return "xmlns:s=\"https://www.skydio.com/drone-skydio/1.0/\" s:CalibratedFocalLengthX=\"6334.2\" "
           "s:CalibratedFocalLengthY=\"6305.5\" s:CalibratedOpticalCenterX=\"" +
           center_x + "\" s:CalibratedOpticalCenterY=\"1735.5\"";
  };
  for (const char* center_x : {"2311.5", "2329.0"}) {  // the second of a lens that sits beside the middle
    const auto whole = Choose(4624, 3472, {}, calibrated(center_x));
    EXPECT_EQ(whole.source, FocalSource::kCalibrated);
    EXPECT_EQ(whole.intrinsics.focal_x_px, 6334.2);
    EXPECT_EQ(whole.intrinsics.focal_y_px, 6305.5);
  }
  EXPECT_DOUBLE_EQ(Choose(2312, 1736, {}, calibrated("2311.5")).intrinsics.focal_x_px, 3167.1);
  EXPECT_EQ(Choose(4624, 3472, {},
                   "xmlns:s=\"https://www.skydio.com/drone-skydio/1.0/\" s:CalibratedFocalLengthX=\"0\"")
                .source,
            FocalSource::kAssumed);
}

TEST(ChooseIntrinsics, ReadsSkydiosCalibrationAsTheStructureThatItIs) {
  const std::string uri = "xmlns:s=\"https://www.skydio.com/drone-skydio/1.0/\"";
  const auto structure = [](const std::string& name, const std::string& x, const std::string& y) {
    const std::string open = "<s:" + name + " rdf:parseType=\"Resource\">", close = "</s:" + name + ">";
    return open + "<s:X>" + x + "</s:X><s:Y>" + y + "</s:Y>" + close;
  };
  const auto in_attributes = [](const std::string& name, const std::string& x, const std::string& y) {
    return "<s:" + name + " s:X=\"" + x + "\" s:Y=\"" + y + "\"/>";
  };
  const std::string whole = structure("CalibratedFocalLength", "4940.1", "4938.7") +
                            structure("CalibratedOpticalCenter", "4095.5", "3071.5");
  for (const std::string& elements :
       {whole, in_attributes("CalibratedFocalLength", "4940.1", "4938.7") +
                   in_attributes("CalibratedOpticalCenter", "4095.5", "3071.5")}) {
    const auto chosen = Choose(8192, 6144, {}, uri, elements);
    EXPECT_EQ(chosen.source, FocalSource::kCalibrated);
    EXPECT_EQ(chosen.intrinsics.focal_x_px, 4940.1);
    EXPECT_EQ(chosen.intrinsics.focal_y_px, 4938.7);
  }
  EXPECT_DOUBLE_EQ(Choose(4096, 3072, {}, uri, whole).intrinsics.focal_x_px, 2470.05);
}

TEST(ChooseIntrinsics, ReadsThePix4dSchemesLens) {
  ExifRecord exif;
  exif.focal_plane_x_px_per_mm = exif.focal_plane_y_px_per_mm = 1280 / 4.8;
  const auto chosen =
      Choose(1280, 960, exif,
             "xmlns:Camera=\"http://pix4d.com/camera/1.0/\" Camera:PerspectiveFocalLength=\"5.5\" "
             "Camera:PerspectiveFocalLengthUnits=\"mm\" Camera:PrincipalPoint=\"2.43,1.79\" "
             "Camera:PerspectiveDistortion=\"-0.1,0.15,-0.07,0.0002,-0.0003\"");
  EXPECT_EQ(chosen.source, FocalSource::kXmpCamera);
  EXPECT_NEAR(chosen.intrinsics.focal_x_px, 5.5 * 1280 / 4.8, 1e-9);
  EXPECT_NEAR(chosen.intrinsics.center_x_px, 2.43 * 1280 / 4.8 - 0.5, 1e-9);
  EXPECT_EQ(chosen.intrinsics.k3, -0.07);
  EXPECT_EQ(chosen.intrinsics.p1, 0.0002);
}

TEST(ChooseIntrinsics, ReadsThePix4dSchemesLensOfASensorThatNoTagMeasures) {
  const std::string lens =
      "xmlns:Camera=\"http://pix4d.com/camera/1.0/\" Camera:PerspectiveFocalLength=\"8.6\" "
      "Camera:PerspectiveFocalLengthUnits=\"mm\" Camera:PrincipalPoint=\"6.55,4.45\" "
      "Camera:PerspectiveDistortion=\"-0.1,0.15,-0.07,0.0002,-0.0003\"";
  ExifRecord listed;
  listed.model = "FC6310";
  const auto by_table = Choose(5472, 3648, listed, lens);
  EXPECT_EQ(by_table.source, FocalSource::kXmpCamera);
  EXPECT_NEAR(by_table.intrinsics.focal_x_px, 8.6 * 5472 / 13.2, 1e-9);
  EXPECT_NEAR(by_table.intrinsics.center_x_px, 6.55 * 5472 / 13.2 - 0.5, 1e-9);
  EXPECT_NEAR(by_table.intrinsics.center_y_px, 4.45 * 5472 / 13.2 - 0.5, 1e-9);
  EXPECT_EQ(by_table.intrinsics.k1, -0.1);
  ExifRecord compared;
  compared.focal_length_mm = 8.8;
  compared.focal_length_35mm_mm = 24.0;
  const auto by_equivalent = Choose(5472, 3648, compared, lens);
  EXPECT_EQ(by_equivalent.source, FocalSource::k35mmEquivalent) << "no more exact than that";
  EXPECT_NEAR(by_equivalent.intrinsics.focal_x_px, 8.6 / 8.8 * FocalPxFrom35mm(24.0, 5472, 3648), 1e-9);
  EXPECT_EQ(by_equivalent.intrinsics.k1, -0.1);
  EXPECT_EQ(by_equivalent.intrinsics.center_x_px, 2735.5) << "of a rounded number a centre is worth nothing";
  // A sensor that is given another size here would move the centre.
  std::string aside = lens;
  aside.replace(aside.find("6.55"), 4, "6.40");
  EXPECT_EQ(Choose(5472, 3648, listed, aside).intrinsics.center_x_px, 2735.5);
  EXPECT_EQ(Choose(5472, 3648, listed, aside).intrinsics.k1, -0.1);
  // Another lens than that of the picture.
  ExifRecord other = listed;
  other.focal_length_mm = 4.5;
  EXPECT_FALSE(Choose(5472, 3648, other, lens).intrinsics.HasDistortion());
  other.focal_length_mm.reset();
  other.focal_length_35mm_mm = 48.0;
  EXPECT_EQ(Choose(5472, 3648, other, lens).source, FocalSource::k35mmEquivalent);
  // A part of the sensor, and a zoom, of which the lens is not that of the picture.
  compared.model = "FC6310";
  compared.focal_length_35mm_mm = 40.0;
  EXPECT_FALSE(Choose(5472, 3648, compared, lens).intrinsics.HasDistortion());
  listed.digital_zoom = 2.0;
  EXPECT_FALSE(Choose(5472, 3648, listed, lens).intrinsics.HasDistortion());
  EXPECT_EQ(Choose(5472, 3648, {}, lens).source, FocalSource::kAssumed) << "of unknown size";
}

TEST(ChooseIntrinsics, ReadsFisheyesOfFourNumbersAndOfFive) {
  ExifRecord exif;
  exif.focal_plane_x_px_per_mm = 1233.0;
  const std::string scheme =
      "xmlns:Camera=\"http://pix4d.com/camera/1.0/\" Camera:PrincipalPoint=\"3.244,2.433\" "
      "Camera:FisheyeAffineMatrix=\"10858.1,0,0,10858.1\" Camera:FisheyePolynomial=\"";
  for (const char* known : {"0,1,0.1542,-0.7726", "0,1,0.1542,-0.7726,0.2407"})
    EXPECT_EQ(Choose(8000, 6000, exif, scheme + known + "\"").source, FocalSource::kXmpCamera) << known;
  for (const char* unknown : {"0,1,0.1542", "0,1,0.1542,-0.7726,0.2407,0.1"})
    EXPECT_EQ(Choose(8000, 6000, exif, scheme + unknown + "\"").source, FocalSource::kAssumed) << unknown;
}

// As MicaSense's cameras did before they named the unit: the centre is in millimetres all the same.
TEST(ChooseIntrinsics, ReadsAFocalLengthInPixelsThatNamesNoUnit) {
  ExifRecord exif;
  exif.focal_length_mm = 5.5;
  exif.focal_plane_x_px_per_mm = exif.focal_plane_y_px_per_mm = 1280 / 4.8;
  const auto lens = [&](const std::string& focal, const std::string& unit) {
    return Choose(1280, 960, exif,
                  "xmlns:Camera=\"http://pix4d.com/camera/1.0/\" Camera:PrincipalPoint=\"2.43,1.79\" "
                  "Camera:PerspectiveDistortion=\"-0.1,0.15,-0.07,0.0002,-0.0003\" " +
                      unit + " Camera:PerspectiveFocalLength=\"" + focal + "\"");
  };
  for (const char* unit : {"", "Camera:PerspectiveFocalLengthUnits=\"pixels\""}) {
    const auto chosen = lens("1459.7272592972727", unit);
    EXPECT_EQ(chosen.source, FocalSource::kXmpCamera) << unit;
    EXPECT_NEAR(chosen.intrinsics.focal_x_px, 1459.7272593, 1e-6);
    EXPECT_NEAR(chosen.intrinsics.center_x_px, 2.43 * 1280 / 4.8 - 0.5, 1e-9);
    EXPECT_EQ(chosen.intrinsics.k1, -0.1);
  }
  EXPECT_NEAR(lens("5.4418739708109527", "").intrinsics.focal_x_px, 5.4418739708 * 1280 / 4.8, 1e-6);
}

TEST(ChooseIntrinsics, UsesTheFocalPlaneBeforeTheTable) {
  ExifRecord exif;
  exif.model = "FC6310";
  exif.focal_length_mm = 8.8;
  exif.focal_plane_x_px_per_mm = 400.0;
  EXPECT_EQ(Choose(5472, 3648, exif).intrinsics.focal_x_px, 8.8 * 400.0);
  exif.focal_plane_x_px_per_mm.reset();
  const auto table = Choose(5472, 3648, exif);
  EXPECT_EQ(table.source, FocalSource::kSensorTable);
  EXPECT_NEAR(table.intrinsics.focal_x_px, 8.8 / 13.2 * 5472, 1e-9);
}

TEST(ChooseIntrinsics, KnowsHowLargeASensorIs) {
  ExifRecord exif;
  exif.model = "XT705";  // Autel's EVO II Pro, whose calibration is of 4404 pixels
  exif.focal_length_mm = 10.57;
  exif.focal_length_35mm_mm = 28.0;
  const auto chosen = Choose(5472, 3648, exif);
  EXPECT_EQ(chosen.source, FocalSource::kSensorTable);
  EXPECT_NEAR(chosen.intrinsics.focal_x_px, 4404.17, 30.0);
  exif.model = "DSC-RX0M2";  // a part of a sensor of 1 inch
  exif.focal_length_mm = 7.9;
  exif.focal_length_35mm_mm = 24.0;
  EXPECT_NEAR(Choose(4800, 3200, exif).intrinsics.focal_x_px, 24.0 / 36.0 * 4800, 80.0);
}

TEST(ChooseIntrinsics, ScalesTheTableToSmallTurnedAndCroppedImages) {
  ExifRecord exif;
  exif.model = "fc300s";
  exif.focal_length_mm = 3.61;
  const double full = 3.61 / 6.17 * 4000;
  EXPECT_NEAR(Choose(4000, 3000, exif).intrinsics.focal_x_px, full, 1e-9);
  EXPECT_NEAR(Choose(4000, 2250, exif).intrinsics.focal_x_px, full, 1e-9);
  EXPECT_NEAR(Choose(2000, 1500, exif).intrinsics.focal_x_px, full / 2, 1e-9);
  EXPECT_NEAR(Choose(3000, 4000, exif).intrinsics.focal_x_px, full, 1e-9);
  EXPECT_NEAR(Choose(8000, 6000, exif).intrinsics.focal_x_px, full * 2, 1e-9);
  exif.digital_zoom = 2.0;
  EXPECT_NEAR(Choose(4000, 3000, exif).intrinsics.focal_x_px, full * 2, 1e-9);
}

TEST(ChooseIntrinsics, TurnsThe35mmEquivalentByTheDiagonal) {
  ExifRecord exif;
  exif.model = "a camera nobody listed";
  exif.focal_length_35mm_mm = 24.0;
  const auto chosen = Choose(6000, 4000, exif);
  EXPECT_EQ(chosen.source, FocalSource::k35mmEquivalent);
  EXPECT_NEAR(chosen.intrinsics.focal_x_px, 24.0 / 36.0 * 6000, 1e-6);  // 3:2: the same by width
  // The diagonal view of 24 mm is 84.06 degrees, on 4:3 as on 3:2.
  const double focal = FocalPxFrom35mm(24.0, 4000, 3000);
  EXPECT_NEAR(2.0 * std::atan(2500.0 / focal) * 180.0 / geo::kPi, 84.06, 0.01);
  EXPECT_EQ(FocalPxFrom35mm(24.0, 4000, 2250), focal);  // a wide crop keeps the number
  EXPECT_EQ(FocalPxFrom35mm(24.0, 3000, 4000), focal);
}

// An FC300S: 6.17 mm of 4000 pixels, 20 mm as an equivalent.
ExifRecord ExifInUnit(double factor) {
  ExifRecord exif;
  exif.focal_length_mm = 3.61;
  exif.focal_plane_x_px_per_mm = exif.focal_plane_y_px_per_mm = factor * 4000.0 / 6.17;
  return exif;
}

TEST(ChooseIntrinsics, LeavesAFocalPlaneOfTheWrongUnitAside) {
  for (const double factor : {2.54, 1.0 / 2.54}) {
    for (const bool is_listed : {true, false}) {
      SCOPED_TRACE(testing::Message() << factor << " " << is_listed);
      ExifRecord exif = ExifInUnit(factor);
      if (is_listed) exif.model = "FC300S";
      if (!is_listed) exif.focal_length_35mm_mm = 20.0;
      std::vector<Remark> notes;
      const auto chosen = ChooseIntrinsics(4000, 3000, exif, XmpTags(), notes);
      EXPECT_EQ(chosen.source, is_listed ? FocalSource::kSensorTable : FocalSource::k35mmEquivalent);
      EXPECT_NEAR(chosen.intrinsics.focal_x_px, 3.61 / 6.17 * 4000, 60.0);
      ASSERT_EQ(notes.size(), 1u);
      EXPECT_EQ(notes[0].code, RemarkCode::kSensorOfWrongUnit);
    }
  }
}

TEST(ChooseIntrinsics, BelievesTheSmallestThermalSensors) {
  ExifRecord exif;
  exif.focal_length_mm = 1.77;
  exif.focal_plane_x_px_per_mm = exif.focal_plane_y_px_per_mm = 1000.0 / 12.0;  // 12 um: 160 px are 1.92 mm
  const auto chosen = Choose(160, 120, exif);
  EXPECT_EQ(chosen.source, FocalSource::kFocalPlane);
  EXPECT_NEAR(chosen.intrinsics.focal_x_px, 147.5, 0.1);
  exif.focal_plane_x_px_per_mm = 1000.0 / 5.0;
  EXPECT_NE(Choose(160, 120, exif).source, FocalSource::kFocalPlane) << "0.8 mm";
}

// A FLIR Duo Pro R: 640 x 512 pixels of 17 micrometres.
TEST(ChooseIntrinsics, KnowsTheSidesOfAThermalSensorByTheirShape) {
  const auto taken = [](int width_px, int height_px, std::uint32_t x_um, std::uint32_t y_um) {
    const Bytes exif = ExifWriter()
                           .Rational(ExifIfd::kExif, 0x920A, {{13, 1}})
                           .Rational(ExifIfd::kExif, 0xA20E, {{x_um, 1000}})
                           .Rational(ExifIfd::kExif, 0xA20F, {{y_um, 1000}})
                           .Short(ExifIfd::kExif, 0xA210, 4)
                           .Write();
    return test::ValueOf(ReadPhotoFromBytes(
        "a.jpg", JpegHeader({.width_px = width_px, .height_px = height_px, .exif = exif})));
  };
  const Photo duo = taken(640, 512, 10880, 8700);
  EXPECT_EQ(duo.focal_source, FocalSource::kFocalPlane);
  EXPECT_NEAR(duo.intrinsics.focal_x_px, 13.0 / 0.017, 0.1);
  EXPECT_NEAR(taken(640, 512, 58824, 58824).intrinsics.focal_x_px, 13.0 / 0.017, 0.1) << "a resolution";
  EXPECT_EQ(taken(4000, 3000, 10880, 8704).focal_source, FocalSource::kAssumed) << "its visible camera";
  EXPECT_EQ(taken(640, 512, 3840, 3072).focal_source, FocalSource::kAssumed) << "6 micrometres";
}

TEST(ChooseIntrinsics, KeepsAFocalPlaneThatAnyOtherSourceConfirms) {
  ExifRecord exif = ExifInUnit(1.0);
  exif.model = "FC300S";
  exif.focal_length_35mm_mm = 50.0;  // wrong
  EXPECT_EQ(Choose(4000, 3000, exif).source, FocalSource::kFocalPlane);
  // A copy of 1600 pixels is 2.5 times smaller: no unit.
  exif.focal_length_35mm_mm = 20.0;
  exif.recorded_width_px = 4000;
  EXPECT_EQ(Choose(1600, 1200, exif).source, FocalSource::kFocalPlane);
  // Nothing beside it, and a sensor that may be.
  EXPECT_EQ(Choose(4000, 3000, ExifInUnit(1.0 / 2.54)).source, FocalSource::kFocalPlane);
}

// Programs write the size of what they made and leave the focal plane that of the camera's picture, or take
// that of the preview in a raw picture.
TEST(ChooseIntrinsics, LeavesAFocalPlaneOfAnotherPictureAside) {
  constexpr std::pair<int, double> kSizes[] = {{2000, 1.0}, {1000, 1.0}, {4000, 0.5}};
  for (const auto& [side_px, factor] : kSizes) {
    for (const bool is_listed : {true, false}) {
      SCOPED_TRACE(testing::Message() << side_px << " " << factor << " " << is_listed);
      ExifRecord exif = ExifInUnit(factor);
      exif.recorded_width_px = side_px;
      if (is_listed) exif.model = "FC300S";
      if (!is_listed) exif.focal_length_35mm_mm = 20.0;
      std::vector<Remark> notes;
      const auto chosen = ChooseIntrinsics(side_px, 3 * side_px / 4, exif, XmpTags(), notes);
      EXPECT_EQ(chosen.source, is_listed ? FocalSource::kSensorTable : FocalSource::k35mmEquivalent);
      EXPECT_NEAR(chosen.intrinsics.focal_x_px, 3.61 / 6.17 * side_px, 0.015 * side_px);
      ASSERT_EQ(notes.size(), 1u);
      EXPECT_EQ(notes[0].code, RemarkCode::kSensorOfOtherSize);
    }
  }
  // By its shape a part, which keeps its pixels; the equivalent stays that of the whole.
  ExifRecord part = ExifInUnit(1.0);
  part.recorded_width_px = 2000;
  part.focal_length_35mm_mm = 20.0;
  EXPECT_EQ(Choose(2000, 2000, part).source, FocalSource::kFocalPlane);
}

TEST(ChooseIntrinsics, TakesAnUprightPictureForNoPartOfAnother) {
  ExifRecord exif = ExifInUnit(1.0);
  for (const auto& [width_px, height_px] : {std::pair(3000, 4000), {4000, 3000}}) {
    exif.recorded_width_px = width_px;
    std::vector<Remark> notes;
    const auto chosen = ChooseIntrinsics(width_px, height_px, exif, XmpTags(), notes);
    EXPECT_EQ(chosen.source, FocalSource::kFocalPlane);
    EXPECT_TRUE(notes.empty()) << InWords(notes.front());
  }
}

// A full-frame camera that keeps to APS-C writes the size of the part, and the pixels of the whole in a
// millimetre.
TEST(ChooseIntrinsics, KeepsTheFocalPlaneOfACropMode) {
  ExifRecord exif;
  exif.model = "ILCE-7R";
  exif.focal_length_mm = 35.0;
  exif.focal_plane_x_px_per_mm = exif.focal_plane_y_px_per_mm = 7360.0 / 35.9;
  exif.recorded_width_px = 4800;
  for (const std::optional<double> equivalent_mm : {std::optional<double>(), std::optional(52.0)}) {
    exif.focal_length_35mm_mm = equivalent_mm;
    const auto crop = Choose(4800, 3200, exif);
    EXPECT_EQ(crop.source, FocalSource::kFocalPlane) << equivalent_mm.value_or(0.0);
    EXPECT_NEAR(crop.intrinsics.focal_x_px, 35.0 * 7360.0 / 35.9, 1e-6);
  }
  // By its equivalent, or by a size that is no crop's, a smaller copy of the whole.
  exif.focal_length_35mm_mm = 35.0;
  EXPECT_EQ(Choose(4800, 3200, exif).source, FocalSource::kSensorTable);
  exif.focal_length_35mm_mm.reset();
  exif.recorded_width_px = 3680;
  const auto copy = Choose(3680, 2456, exif);
  EXPECT_EQ(copy.source, FocalSource::kSensorTable);
  EXPECT_NEAR(copy.intrinsics.focal_x_px, 35.0 / 35.9 * 3680, 1e-6);
}

TEST(ChooseIntrinsics, LeavesASensorThatNoCameraHasAside) {
  std::vector<Remark> notes;
  EXPECT_EQ(ChooseIntrinsics(4000, 3000, ExifInUnit(4.4), XmpTags(), notes).source, FocalSource::kAssumed);
  EXPECT_NE(InWords(notes.at(0)).find("1.4 mm wide"), std::string::npos) << InWords(notes.at(0));
}

// What was chosen, and the one thing that was said of it.
ChosenIntrinsics ChooseSaying(RemarkCode said, const ExifRecord& exif, const std::string& attributes = "") {
  XmpTags xmp;
  EXPECT_TRUE(xmp.AddPacket(XmpPacket(attributes)));
  std::vector<Remark> notes;
  const auto chosen = ChooseIntrinsics(4000, 3000, exif, xmp, notes);
  EXPECT_EQ(notes.size(), 1u);
  EXPECT_TRUE(!notes.empty() && notes[0].code == said);
  return chosen;
}

TEST(ChooseIntrinsics, CountsAZoomOnceInACalibration) {
  const std::string calibrated = std::string(kDjiNamespace) + "drone-dji:CalibratedFocalLength=\"2340\" ";
  ExifRecord exif;
  exif.digital_zoom = 2.0;
  // The equivalent counts the zoom (4680 px), the calibration does not.
  exif.focal_length_35mm_mm = 40.0;
  auto chosen = ChooseSaying(RemarkCode::kZoomCounted, exif, calibrated);
  EXPECT_EQ(chosen.source, FocalSource::kCalibrated);
  EXPECT_DOUBLE_EQ(chosen.intrinsics.focal_x_px, 4680.0);
  // By the lens and the sensor (2340 px), whatever the equivalent counts.
  exif.model = "FC300S";
  exif.focal_length_mm = 3.61;
  exif.focal_length_35mm_mm = 20.0;
  chosen = ChooseSaying(RemarkCode::kZoomCounted, exif, calibrated);
  EXPECT_DOUBLE_EQ(chosen.intrinsics.focal_x_px, 4680.0);
  EXPECT_EQ(Choose(4000, 3000, exif, std::string(kDjiNamespace) + "drone-dji:CalibratedFocalLength=\"4680\"")
                .intrinsics.focal_x_px,
            4680.0)
      << "it has the zoom in already";
  // Nothing tells.
  exif.model = "a camera nobody listed";
  chosen = ChooseSaying(RemarkCode::kZoomDoubtful, exif, calibrated);
  EXPECT_EQ(chosen.source, FocalSource::kDoubtful);
  EXPECT_EQ(chosen.intrinsics.focal_x_px, 2340.0);
  EXPECT_EQ(ChooseSaying(RemarkCode::kZoomDoubtful, exif).source, FocalSource::kDoubtful) << "an equivalent";
}

TEST(ChooseIntrinsics, CountsAZoomInTheCentreOfACalibration) {
  ExifRecord exif;
  exif.model = "FC6310";
  exif.focal_length_mm = 8.8;
  exif.digital_zoom = 2.0;
  const auto chosen = Choose(5472, 3648, exif, kDewarp);
  EXPECT_EQ(chosen.source, FocalSource::kDewarpData);
  EXPECT_DOUBLE_EQ(chosen.intrinsics.focal_x_px, 2.0 * 3678.87);
  EXPECT_DOUBLE_EQ(chosen.intrinsics.center_x_px, 2735.5 - 2.0 * 11.25);
  EXPECT_EQ(chosen.intrinsics.k1, -0.26);
}

TEST(ChooseIntrinsics, KnowsACropModeByItsEquivalent) {
  ExifRecord exif;
  exif.model = "FC300S";
  exif.focal_length_mm = 3.61;
  exif.focal_length_35mm_mm = 20.0;
  EXPECT_EQ(Choose(4000, 3000, exif).source, FocalSource::kSensorTable);
  exif.focal_length_35mm_mm = 30.0;
  const auto crop = ChooseSaying(RemarkCode::kCropOfSensor, exif);
  EXPECT_EQ(crop.source, FocalSource::k35mmEquivalent);
  EXPECT_EQ(crop.intrinsics.focal_x_px, FocalPxFrom35mm(30.0, 4000, 3000));
  // What no crop explains.
  for (const double equivalent_mm : {10.0, 90.0}) {
    exif.focal_length_35mm_mm = equivalent_mm;
    const auto doubted = ChooseSaying(RemarkCode::kFocalLengthsApart, exif);
    EXPECT_EQ(doubted.source, FocalSource::kDoubtful);
    EXPECT_NEAR(doubted.intrinsics.focal_x_px, 3.61 / 6.17 * 4000, 1e-9);
  }
}

TEST(ChooseIntrinsics, SaysWhenItHadToAssume) {
  XmpTags xmp;
  std::vector<Remark> notes;
  const auto chosen = ChooseIntrinsics(4000, 3000, {}, xmp, notes);
  EXPECT_EQ(chosen.source, FocalSource::kAssumed);
  EXPECT_EQ(notes.size(), 1u);
  EXPECT_GT(chosen.intrinsics.focal_x_px, 0.0);
}

TEST(FocalSourceName, HasAWordForEach) {
  for (const auto source : {FocalSource::kDewarpData, FocalSource::kCalibrated, FocalSource::kXmpCamera,
                            FocalSource::kFocalPlane, FocalSource::kSensorTable, FocalSource::k35mmEquivalent,
                            FocalSource::kDoubtful, FocalSource::kAssumed}) {
    EXPECT_NE(std::string_view(FocalSourceName(source)), "unknown");
  }
}

TEST(FindSensor, KnowsNoCameraByPartOfItsName) {
  EXPECT_TRUE(camera::FindSensor("FC6310"));
  EXPECT_TRUE(camera::FindSensor("PHANTOM VISION FC200"));  // all of it is the Phantom 2 Vision's
  EXPECT_FALSE(camera::FindSensor("FC"));
  EXPECT_FALSE(camera::FindSensor(""));
}

}  // namespace
}  // namespace skyquilt::flight
