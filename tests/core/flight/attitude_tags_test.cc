// Every maker's convention for angles and speeds, and the traps among them.
#include "core/flight/metadata/attitude_tags.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <limits>

#include "core/flight/photos/read_photo.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/lat_lon.h"
#include "tests/core/flight/synthetic_photo.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using geo::DegToRad;
using geo::RadToDeg;

struct AttitudeRead {
  std::optional<RecordedAttitude> attitude;
  std::vector<Remark> notes;
};

AttitudeRead ReadXmp(const std::string& attributes, const std::string& elements = "",
                     const std::string& make = "", const std::optional<DjiMakerNote>& note = std::nullopt) {
  XmpTags xmp;
  EXPECT_TRUE(xmp.AddPacket(XmpPacket(attributes, elements)));
  AttitudeRead read;
  read.attitude = AttitudeFromTags(xmp, note, make, read.notes);
  return read;
}

void ExpectAngles(const AttitudeRead& read, AttitudeKind kind, double yaw_deg, double pitch_deg,
                  double roll_deg) {
  ASSERT_TRUE(read.attitude);
  EXPECT_EQ(read.attitude->kind, kind);
  EXPECT_NEAR(RadToDeg(read.attitude->yaw_rad), yaw_deg, 1e-9);
  EXPECT_NEAR(RadToDeg(read.attitude->pitch_rad), pitch_deg, 1e-9);
  EXPECT_NEAR(RadToDeg(read.attitude->roll_rad), roll_deg, 1e-9);
}

std::string Dji(const std::string& yaw, const std::string& pitch, const std::string& roll) {
  return kDjiNamespace + ("drone-dji:GimbalYawDegree=\"" + yaw + "\" drone-dji:GimbalPitchDegree=\"" + pitch +
                          "\" drone-dji:GimbalRollDegree=\"" + roll + "\" ");
}

// The camera's axes in north-east-down: columns are image right, image down, optical axis.
Eigen::Matrix3d NedFromCam(const RecordedAttitude& attitude) {
  const Eigen::Matrix3d ned_from_source = (Eigen::AngleAxisd(attitude.yaw_rad, Eigen::Vector3d::UnitZ()) *
                                           Eigen::AngleAxisd(attitude.pitch_rad, Eigen::Vector3d::UnitY()) *
                                           Eigen::AngleAxisd(attitude.roll_rad, Eigen::Vector3d::UnitX()))
                                              .toRotationMatrix();
  Eigen::Matrix3d cam_from_source;
  if (attitude.kind == AttitudeKind::kGimbal) {
    cam_from_source << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  } else {
    cam_from_source << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  }
  return ned_from_source * cam_from_source.transpose();
}

TEST(AttitudeFromTags, TakesDjiGimbalAnglesAsTheyAre) {
  ExpectAngles(ReadXmp(Dji("+45.00", "-89.90", "+0.00")), AttitudeKind::kGimbal, 45.0, -89.9, 0.0);
  ExpectAngles(ReadXmp(Dji("-131.40", "-60.0", "1.5")), AttitudeKind::kGimbal, -131.4, -60.0, 1.5);
}

TEST(AttitudeFromTags, ReadsTheElementFormAndForeignPrefixes) {
  const std::string uri = "xmlns:mine=\"http://www.dji.com/drone-dji/1.0/\"";
  ExpectAngles(ReadXmp(uri,
                       "<mine:GimbalYawDegree> +10.5 </mine:GimbalYawDegree><mine:GimbalPitchDegree>-90"
                       "</mine:GimbalPitchDegree><mine:GimbalRollDegree>0</mine:GimbalRollDegree>"),
               AttitudeKind::kGimbal, 10.5, -90.0, 0.0);
}

TEST(AttitudeFromTags, ReadsAGimbalRollOf180AsAHalfTurnOfTheYaw) {
  const AttitudeRead read = ReadXmp(Dji("170.0", "-89.9", "180.0"));
  ExpectAngles(read, AttitudeKind::kGimbal, -10.0, -90.1, 0.0);
  EXPECT_TRUE(read.notes.empty()) << "it is the same rotation, only written otherwise";
  RecordedAttitude as_written;
  as_written.yaw_rad = DegToRad(170.0);
  as_written.pitch_rad = DegToRad(-89.9);
  as_written.roll_rad = DegToRad(180.0);
  EXPECT_LT((NedFromCam(as_written) - NedFromCam(*read.attitude)).norm(), 1e-12);
}

TEST(AttitudeFromTags, KeepsTheRotationWhateverTheRoll) {
  for (double yaw = -180.0; yaw < 180.0; yaw += 37.0) {
    for (double pitch = -120.0; pitch <= 30.0; pitch += 17.0) {
      for (double roll = -180.0; roll <= 180.0; roll += 29.0) {
        const AttitudeRead read =
            ReadXmp(Dji(std::to_string(yaw), std::to_string(pitch), std::to_string(roll)));
        ASSERT_TRUE(read.attitude);
        EXPECT_LE(std::abs(read.attitude->roll_rad), DegToRad(90.0) + 1e-9);
        RecordedAttitude as_written;
        as_written.yaw_rad = DegToRad(yaw);
        as_written.pitch_rad = DegToRad(pitch);
        as_written.roll_rad = DegToRad(roll);
        EXPECT_LT((NedFromCam(as_written) - NedFromCam(*read.attitude)).norm(), 1e-9);
      }
    }
  }
}

TEST(AttitudeFromTags, RefusesAllZeroGimbalAnglesAndSaysSo) {
  const AttitudeRead read = ReadXmp(Dji("0.0", "+0.00", "0"));
  EXPECT_FALSE(read.attitude);
  ASSERT_EQ(read.notes.size(), 1u);
  EXPECT_EQ(read.notes[0], Remark(RemarkCode::kAnglesZero, {{"tags", "drone-dji"}}));
}

TEST(AttitudeFromTags, TakesOnlyTheHeadingOfADjiAirframe) {
  const std::string flight =
      "drone-dji:FlightYawDegree=\"33\" drone-dji:FlightPitchDegree=\"-14\" "
      "drone-dji:FlightRollDegree=\"3\" ";
  const AttitudeRead without_gimbal = ReadXmp(kDjiNamespace + flight);
  ExpectAngles(without_gimbal, AttitudeKind::kAirframe, 33.0, 0.0, 0.0);
  EXPECT_EQ(without_gimbal.notes.size(), 1u);
  ExpectAngles(ReadXmp(Dji("12", "-90", "0") + flight), AttitudeKind::kGimbal, 12.0, -90.0, 0.0);
}

TEST(AttitudeFromTags, CountsParrotAnafiFromTheHorizon) {
  ExpectAngles(ReadXmp("xmlns:drone-parrot=\"http://www.parrot.com/drone-parrot/1.0/\" "
                       "drone-parrot:CameraYawDegree=\"100.5\" drone-parrot:CameraPitchDegree=\"-12\" "
                       "drone-parrot:CameraRollDegree=\"0.3\" drone-parrot:DroneYawDegree=\"80\""),
               AttitudeKind::kGimbal, 100.5, -12.0, 0.3);
}

TEST(AttitudeFromTags, CountsYuneecFromTheHorizon) {
  const std::string drone =
      "xmlns:y=\"http://www.yuneec.com/drone-yuneec/1.0/\" y:DroneYaw=\"96.699997\" "
      "y:DronePitch=\"-3.72\" y:DroneRoll=\"1.64\" ";
  ExpectAngles(
      ReadXmp(drone + "y:GimbalYaw=\"73.230003\" y:GimbalPitch=\"-89.95999\" y:GimbalRoll=\"0.000000\""),
      AttitudeKind::kGimbal, 73.230003, -89.95999, 0.0);
  const AttitudeRead without_gimbal = ReadXmp(drone);
  ExpectAngles(without_gimbal, AttitudeKind::kAirframe, 96.699997, 0.0, 0.0);
  EXPECT_EQ(without_gimbal.notes.size(), 1u);
}

TEST(AttitudeFromTags, CountsThePix4dSchemeFromNadir) {
  const std::string uri = "xmlns:Camera=\"http://pix4d.com/camera/1.0/\" ";
  const AttitudeRead down =
      ReadXmp(uri + "Camera:Yaw=\"350\" Camera:Pitch=\"0.5\" Camera:Roll=\"-7\"", "", "Parrot");
  ExpectAngles(down, AttitudeKind::kAirframe, -10.0, 0.5, -7.0);
  // 90 degrees of pitch look at the horizon, along the heading, with the picture upright.
  const AttitudeRead ahead = ReadXmp(uri + "Camera:Yaw=\"90\" Camera:Pitch=\"90\" Camera:Roll=\"0\"");
  ASSERT_TRUE(ahead.attitude);
  const Eigen::Matrix3d ned_from_cam = NedFromCam(*ahead.attitude);
  EXPECT_LT((ned_from_cam.col(2) - Eigen::Vector3d(0, 1, 0)).norm(), 1e-9);  // towards east
  EXPECT_LT((ned_from_cam.col(1) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-9);  // image down is down
}

TEST(AttitudeFromTags, AgreesForOldAutelsGimbalAndThePix4dSchemeWithoutRoll) {
  const std::string tags =
      "xmlns:Camera=\"http://www.pix4d.com/camera/1.0\" Camera:Yaw=\"123\" Camera:Pitch=\"14\" "
      "Camera:Roll=\"0\"";
  const AttitudeRead autel = ReadXmp(tags, "", "Autel Robotics");
  ExpectAngles(autel, AttitudeKind::kGimbal, 123.0, -76.0, 0.0);
  const AttitudeRead other = ReadXmp(tags);
  ASSERT_TRUE(other.attitude);
  EXPECT_LT((NedFromCam(*autel.attitude) - NedFromCam(*other.attitude)).norm(), 1e-12);
}

TEST(AttitudeFromTags, CountsFromTheHorizonWhatWouldLookBackwardsFromNadir) {
  const auto tags = [](const std::string& pitch) {
    return "xmlns:Camera=\"http://pix4d.com/camera/1.0\" Camera:Yaw=\"123\" Camera:Pitch=\"" + pitch +
           "\" Camera:Roll=\"0.5\"";
  };
  for (const char* make : {"Camera", "Autel Robotics", ""}) {  // the XL715 calls its maker "Camera"
    SCOPED_TRACE(make);
    ExpectAngles(ReadXmp(tags("-90"), "", make), AttitudeKind::kGimbal, 123.0, -90.0, 0.5);
    ExpectAngles(ReadXmp(tags("-61"), "", make), AttitudeKind::kGimbal, 123.0, -61.0, 0.5);
  }
  ExpectAngles(ReadXmp(tags("-45")), AttitudeKind::kAirframe, 123.0, -45.0, 0.5);  // of an oblique rig
  // No gimbal of Autel's looks back.
  ExpectAngles(ReadXmp(tags("-45"), "", "Autel Robotics"), AttitudeKind::kGimbal, 123.0, -45.0, 0.5);
  ExpectAngles(ReadXmp(tags("-2"), "", "Autel Robotics"), AttitudeKind::kGimbal, 123.0, -92.0, 0.5);
}

TEST(AttitudeFromTags, KnowsAutelsXl715ByItsXmp) {
  const Photo photo = test::ValueOf(ReadPhotoFromBytes(
      "a.jpg", JpegHeader({.exif = ExifWriter().Ascii(ExifIfd::kImage, 0x010F, "Camera").Write(),
                           .xmp = XmpPacket(
                               "xmlns:tiff=\"http://ns.adobe.com/tiff/1.0/\" tiff:Make=\"Autel Robotics\" "
                               "xmlns:Camera=\"http://pix4d.com/camera/1.0\" Camera:Yaw=\"123\" "
                               "Camera:Pitch=\"-30\" Camera:Roll=\"0\"")})));
  EXPECT_EQ(photo.make, "Autel Robotics");
  ExpectAngles({photo.attitude, {}}, AttitudeKind::kGimbal, 123.0, -30.0, 0.0);
}

TEST(AttitudeFromTags, ReadsPhaseOnesFractions) {
  ExpectAngles(ReadXmp("xmlns:aerialgps=\"http://www.phaseone.com/aerialgps/\"",
                       "<aerialgps:GPSIMUYaw>3015700/10000</aerialgps:GPSIMUYaw>"
                       "<aerialgps:GPSIMUPitch>-908070/10000</aerialgps:GPSIMUPitch>"
                       "<aerialgps:GPSIMURoll>2380/10000</aerialgps:GPSIMURoll>"),
               AttitudeKind::kGimbal, -58.43, -90.807, 0.238);
}

TEST(AttitudeFromTags, ReadsBothNamesOfOldSensefly) {
  const std::string uri = "xmlns:sensefly=\"http://ns.sensefly.com/sensefly/1.0/\" ";
  ExpectAngles(
      ReadXmp(uri + "sensefly:Heading=\"242.5\" sensefly:PitchAngle=\"5.9\" sensefly:RollAngle=\"-10.8\""),
      AttitudeKind::kAirframe, -117.5, 5.9, -10.8);
  ExpectAngles(ReadXmp(uri + "sensefly:Yaw=\"12\" sensefly:Pitch=\"1\" sensefly:Roll=\"2\""),
               AttitudeKind::kAirframe, 12.0, 1.0, 2.0);
}

TEST(AttitudeFromTags, ReadsSkydiosStructureInEveryForm) {
  const std::string uri =
      "xmlns:s=\"https://www.skydio.com/drone-skydio/1.0/\" "
      "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\"";
  const std::string fields = "<s:Yaw>-20.5</s:Yaw><s:Pitch>-88</s:Pitch><s:Roll>0.5</s:Roll>";
  for (const std::string& element :
       {"<s:CameraOrientationNED rdf:parseType=\"Resource\">" + fields + "</s:CameraOrientationNED>",
        "<s:CameraOrientationNED><rdf:Description>" + fields + "</rdf:Description></s:CameraOrientationNED>",
        std::string("<s:CameraOrientationNED s:Yaw=\"-20.5\" s:Pitch=\"-88\" s:Roll=\"0.5\"/>")}) {
    SCOPED_TRACE(element);
    ExpectAngles(ReadXmp(uri, element), AttitudeKind::kGimbal, -20.5, -88.0, 0.5);
  }
}

TEST(AttitudeFromTags, SumsTealsPlatformAndCamera) {
  ExpectAngles(
      ReadXmp("xmlns:exif=\"http://ns.adobe.com/exif/1.0/\" exif:PlatformYaw=\"170\" exif:CameraYaw=\"20\" "
              "exif:PlatformPitch=\"-5\" exif:CameraPitch=\"-80\" exif:PlatformRoll=\"1\" "
              "exif:CameraRoll=\"-1\""),
      AttitudeKind::kGimbal, -170.0, -85.0, 0.0);
}

TEST(AttitudeFromTags, RefusesSentinelsAndNonsense) {
  EXPECT_FALSE(ReadXmp("xmlns:Camera=\"http://pix4d.com/camera/1.0/\" Camera:Yaw=\"-20000000000\" "
                       "Camera:Pitch=\"-20000000000\" Camera:Roll=\"-20000000000\"")
                   .attitude);
  EXPECT_FALSE(ReadXmp(Dji("nan", "-90", "0")).attitude);
  EXPECT_FALSE(ReadXmp(Dji("inf", "-90", "0")).attitude);
  EXPECT_FALSE(ReadXmp(Dji("north", "down", "none")).attitude);
  EXPECT_FALSE(ReadXmp(Dji("5000", "-90", "0")).attitude);
  EXPECT_FALSE(ReadXmp("").attitude);
}

TEST(AttitudeFromTags, FallsBackToTheDjiMakerNote) {
  const auto note =
      ReadDjiMakerNote(DjiNote({{3, 1.0f}, {7, 46.0f}, {9, -89.5f}, {10, 45.25f}, {11, 0.5f}}), false);
  ASSERT_TRUE(note);
  ExpectAngles(ReadXmp("", "", "DJI", note), AttitudeKind::kGimbal, 45.25, -89.5, 0.5);
  ExpectAngles(ReadXmp(Dji("1", "-90", "0"), "", "DJI", note), AttitudeKind::kGimbal, 1.0, -90.0, 0.0);
  ExpectAngles(ReadXmp("", "", "DJI", ReadDjiMakerNote(DjiNote({{7, 46.0f}}), false)),
               AttitudeKind::kAirframe, 46.0, 0.0, 0.0);
}

std::optional<RecordedDirection> DirectionOf(std::uint32_t numerator, std::uint32_t denominator,
                                             const std::string& reference, std::uint16_t orientation = 1) {
  const Bytes exif = ExifWriter()
                         .Rational(ExifIfd::kGps, 0x11, {{numerator, denominator}})
                         .Ascii(ExifIfd::kGps, 0x10, reference)
                         .Short(ExifIfd::kImage, 0x0112, orientation)
                         .Write();
  const auto photo = test::ValueOf(ReadPhotoFromBytes("a.jpg", JpegHeader({.exif = exif})));
  return photo.direction;
}

TEST(DirectionFromTags, TakesTheCompassOfThePictureAsItIsStored) {
  const auto read = test::ValueOf(DirectionOf(29309, 92, "T"));
  EXPECT_NEAR(RadToDeg(read.yaw_rad), 29309.0 / 92.0 - 360.0, 1e-9);
  EXPECT_TRUE(read.is_from_true_north);
  for (const char* reference : {"M", ""})
    EXPECT_FALSE(test::ValueOf(DirectionOf(10, 1, reference)).is_from_true_north) << reference;
  // Shown turned by a quarter clockwise, its left side is on top: the stored top is to the right of that.
  const std::pair<std::uint16_t, double> yaw_by_orientation[] = {
      {1, 10.0}, {2, 10.0}, {3, -170.0}, {4, -170.0}, {5, -80.0}, {6, 100.0}, {7, 100.0}, {8, -80.0}};
  for (const auto& [orientation, yaw_deg] : yaw_by_orientation) {
    EXPECT_NEAR(RadToDeg(test::ValueOf(DirectionOf(10, 1, "T", orientation)).yaw_rad), yaw_deg, 1e-9)
        << orientation;
  }
}

TEST(DirectionFromTags, TakesNothingThatIsNoDirection) {
  const std::pair<std::uint32_t, std::uint32_t> nothing[] = {
      {0, 1}, {0, 0}, {5, 0}, {360, 1}, {4294967295u, 1}};
  for (const auto& [numerator, denominator] : nothing)
    EXPECT_FALSE(DirectionOf(numerator, denominator, "T")) << numerator << "/" << denominator;
  EXPECT_TRUE(DirectionOf(35999, 100, "T"));
}

TEST(ReadDjiMakerNote, GoesByItsOwnByteOrder) {
  const auto note = ReadDjiMakerNote(DjiNote({{9, -89.5f}, {10, 45.25f}, {11, 0.5f}}), true);
  ASSERT_TRUE(note) << "little-endian inside a big-endian EXIF";
  EXPECT_EQ(note->camera_pitch_deg, -89.5);
  EXPECT_EQ(note->camera_yaw_deg, 45.25);
}

TEST(ReadDjiMakerNote, RefusesWhatIsNotDjis) {
  EXPECT_FALSE(ReadDjiMakerNote({}, false));
  const Bytes cut_off = [] {
    Bytes note = DjiNote({{9, -90.0f}, {10, 1.0f}});
    note.resize(20);
    return note;
  }();
  EXPECT_FALSE(ReadDjiMakerNote(cut_off, false));
  EXPECT_FALSE(ReadDjiMakerNote(Bytes(4000, 0xFF), true));
  EXPECT_FALSE(ReadDjiMakerNote(DjiNote({{9, std::numeric_limits<float>::quiet_NaN()}}), false));
}

TEST(VelocityFromTags, TurnsEveryFrameToEastNorthUp) {
  XmpTags dji;
  ASSERT_TRUE(dji.AddPacket(XmpPacket(kDjiNamespace + std::string("drone-dji:FlightXSpeed=\"+3.0\" "
                                                                  "drone-dji:FlightYSpeed=\"-4.0\" "
                                                                  "drone-dji:FlightZSpeed=\"+0.5\""))));
  EXPECT_EQ(test::ValueOf(VelocityFromTags(dji)), Eigen::Vector3d(-4.0, 3.0, -0.5));

  XmpTags sequoia;
  ASSERT_TRUE(sequoia.AddPacket(XmpPacket("xmlns:Camera=\"http://pix4d.com/camera/1.0/\"",
                                          "<Camera:IMULinearVelocity><rdf:Seq><rdf:li>1.5</"
                                          "rdf:li><rdf:li>-2</rdf:li><rdf:li>0.25</rdf:li></rdf:Seq>"
                                          "</Camera:IMULinearVelocity>")));
  EXPECT_EQ(test::ValueOf(VelocityFromTags(sequoia)), Eigen::Vector3d(1.5, -2.0, 0.25));
}

TEST(VelocityFromTags, RefusesAllZeroAndImpossibleSpeeds) {
  for (const char* z : {"0", "5000"}) {
    XmpTags xmp;
    ASSERT_TRUE(xmp.AddPacket(XmpPacket(kDjiNamespace +
                                        std::string("drone-dji:FlightXSpeed=\"0.0\" "
                                                    "drone-dji:FlightYSpeed=\"-0.0\" "
                                                    "drone-dji:FlightZSpeed=\"") +
                                        z + "\"")));
    EXPECT_FALSE(VelocityFromTags(xmp));
  }
}

// What cameras write of their gyros, whole, damaged and impossible.

constexpr const char* kCameraNamespace = "xmlns:Camera=\"http://pix4d.com/camera/1.0/\" ";

struct Record {
  std::uint64_t us = 0;
  float x = 0.0F, y = 0.0F, z = 0.0F;
};

std::string Base64(const std::vector<std::uint8_t>& bytes) {
  const std::string signs = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t at = 0; at + 2 < bytes.size(); at += 3) {
    const std::uint32_t three =
        (std::uint32_t{bytes[at]} << 16) | (std::uint32_t{bytes[at + 1]} << 8) | bytes[at + 2];
    for (int k = 3; k >= 0; --k) text += signs[(three >> (6 * k)) & 63U];
  }
  return text;
}

std::string Written(const std::vector<Record>& records) {
  std::vector<std::uint8_t> bytes;
  const auto append = [&](auto number) {
    for (std::size_t i = 0; i < sizeof(number); ++i)
      bytes.push_back(static_cast<std::uint8_t>(number >> (8 * i)));
  };
  for (const Record& record : records) {
    append(record.us);
    for (const float rate : {record.x, record.y, record.z}) append(std::bit_cast<std::uint32_t>(rate));
    append(std::uint32_t{1});
  }
  return Base64(bytes);
}

struct GyroRead {
  std::optional<RecordedTurning> turning;
  std::vector<Remark> notes;
};

GyroRead ReadText(const std::string& text, const std::string& offset_ns = "10000000") {
  XmpTags xmp;
  EXPECT_TRUE(
      xmp.AddPacket(XmpPacket(kCameraNamespace + ("Camera:IMUTimeOffset=\"" + offset_ns +
                                                  "\" Camera:IMUAngularVelocity=\"" + text + "\" "))));
  GyroRead read;
  read.turning = TurningFromTags(xmp, read.notes);
  return read;
}

// The first three records of a photo by a Parrot Sequoia, with the line ends that stand around them.
TEST(TurningFromTags, ReadsWhatASequoiaWrites) {
  const GyroRead read = ReadText(
      "&#xA;G2qNEAAAAAAcYco9yLNVO6Ow6L0BAAAAA26NEAAAAACVPd49AGDcNh/S1r0BAAAA63GNEAAAAABKRuk9bJ4xvJGF3b0BAAAA"
      "&#xA;",
      "10417635");
  ASSERT_TRUE(read.turning);
  EXPECT_TRUE(read.notes.empty());
  ASSERT_EQ(read.turning->samples.size(), 3U);
  const TurnRate& first = read.turning->samples.front();
  EXPECT_NEAR(first.time_s, -0.010417635, 1e-9);
  EXPECT_NEAR(read.turning->samples[1].time_s - first.time_s, 0.001, 1e-9);
  // Body x 0.0988, y 0.0033, z -0.1136 rad/s.
  EXPECT_NEAR(first.in_cam_radps.x(), 0.0033, 5e-5);
  EXPECT_NEAR(first.in_cam_radps.y(), -0.0988, 5e-5);
  EXPECT_NEAR(first.in_cam_radps.z(), -0.1136, 5e-5);
}

TEST(TurningFromTags, ReadsAsManyRecordsAsAPhotoNeeds) {
  std::vector<Record> records;
  for (std::uint64_t i = 0; i < 600; ++i) records.push_back({5'000'000 + 1000 * i, 0.1F, 0.0F, 0.0F});
  const GyroRead read = ReadText(Written(records));
  ASSERT_TRUE(read.turning);
  EXPECT_EQ(read.turning->samples.size(), 600U);
}

TEST(TurningFromTags, RefusesWhatNoGyroWrites) {
  const auto expect_refused = [](const std::string& text, const std::string& offset_ns, const char* why) {
    const GyroRead read = ReadText(text, offset_ns);
    EXPECT_FALSE(read.turning) << why;
    ASSERT_EQ(read.notes.size(), 1U) << why;
    const std::string note = InWords(read.notes.front());
    EXPECT_NE(note.find(why), std::string::npos) << note;
  };
  const Record first{1000, 0.1F, 0.2F, 0.3F}, second{2000, 0.1F, 0.2F, 0.3F};
  const std::string good = Written({first, second});
  ASSERT_TRUE(ReadText(good).turning);
  expect_refused(good + "AAAA", "0", "damaged");
  expect_refused(good.substr(0, good.size() - 1) + "*", "0", "damaged");
  expect_refused("=" + good, "0", "damaged");
  expect_refused(Written({first}), "0", "too few");
  expect_refused(good, "5000000000", "impossible time");
  expect_refused(Written({second, first}), "0", "backwards");
  expect_refused(Written({first, first}), "0", "backwards");
  expect_refused(Written({first, {500'000, 0.0F, 0.0F, 0.0F}}), "0", "gaps");
  expect_refused(Written({first, {2000, std::nanf(""), 0.0F, 0.0F}}), "0", "impossible rates");
  expect_refused(Written({first, {2000, 0.0F, std::numeric_limits<float>::infinity(), 0.0F}}), "0",
                 "impossible rates");
  expect_refused(Written({first, {2000, 0.0F, 0.0F, 100.0F}}), "0", "impossible rates");
  std::vector<Record> many;
  for (std::uint64_t i = 0; i < 5000; ++i) many.push_back({1000 * i, 0.1F, 0.0F, 0.0F});
  expect_refused(Written(many), "0", "damaged");
}

TEST(TurningFromTags, SaysNothingOfPhotosWithoutAGyro) {
  XmpTags xmp;
  std::vector<Remark> notes;
  EXPECT_FALSE(TurningFromTags(xmp, notes));
  EXPECT_FALSE(ReadText("").turning);
  EXPECT_TRUE(notes.empty());
}

}  // namespace
}  // namespace skyquilt::flight
