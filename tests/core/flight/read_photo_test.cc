// Containers and damage: where metadata hides, what is refused and with which words, and that no bytes bring
// it down.
#include "core/flight/photos/read_photo.h"

#include <gmock/gmock.h>

#include <random>

#include "core/flight/metadata/xmp.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/flight/synthetic_photo.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using test::ValueOf;
using ::testing::HasSubstr;

const std::string kAngles = std::string(kDjiNamespace) +
                            "drone-dji:GimbalYawDegree=\"12.5\" drone-dji:GimbalPitchDegree=\"-90\" "
                            "drone-dji:GimbalRollDegree=\"0\"";

Bytes BytesOf(const std::string& text) { return Bytes(text.begin(), text.end()); }

Error Refusal(const Bytes& bytes) { return test::ErrorOf(ReadPhotoFromBytes("a.jpg", bytes)); }

// A photo with everything a reader may stumble over.
Bytes RichPhoto() {
  return JpegHeader(
      {.exif = ExifWriter()
                   .Ascii(ExifIfd::kImage, 0x010F, "DJI")
                   .Ascii(ExifIfd::kImage, 0x0110, "FC6310")
                   .Ascii(ExifIfd::kExif, 0x9003, "2021:06:03 12:34:56")
                   .Rational(ExifIfd::kExif, 0x920A, {{88, 10}})
                   .Undefined(ExifIfd::kExif, 0x927C, DjiNote({{9, -90.0f}, {10, 45.0f}}))
                   .Position(46.5, 7.5)
                   .Write(),
       .xmp = XmpPacket(kAngles),
       .extended_xmp = XmpPacket(std::string(kDjiNamespace) + "drone-dji:RelativeAltitude=\"40\"")});
}

TEST(ReadPhoto, KnowsHowLongItsRowsTookToRead) {
  const auto readout_s = [](const char* model, int width_px, int height_px, const std::string& xmp = "") {
    const Bytes exif =
        ExifWriter().Ascii(ExifIfd::kImage, 0x010F, "DJI").Ascii(ExifIfd::kImage, 0x0110, model).Write();
    const auto photo = ReadPhotoFromBytes(
        "a.jpg", JpegHeader({.width_px = width_px, .height_px = height_px, .exif = exif, .xmp = xmp}));
    EXPECT_TRUE(photo.ok());
    return photo->readout_s;
  };
  EXPECT_NEAR(readout_s("FC330", 4000, 3000).value(), 0.033, 1e-9);
  EXPECT_NEAR(readout_s("FC330", 4000, 2250).value(), 0.75 * 0.033, 1e-9);  // three quarters of the rows
  EXPECT_NEAR(readout_s("FC330", 2000, 1500).value(), 0.033, 1e-9);         // made smaller afterwards
  EXPECT_FALSE(readout_s("FC330", 3000, 4000));                             // rows lie across
  EXPECT_NEAR(readout_s("XT705", 5472, 3648).value(), 0.030, 1e-9);         // the widest that it takes
  EXPECT_FALSE(readout_s("FC6310", 5472, 3648));
  EXPECT_FALSE(readout_s("L2D-20c", 5280, 3956,
                         XmpPacket(std::string(kDjiNamespace) + "drone-dji:ShutterType=\"Mechanical\"")));
}

TEST(ReadPhoto, FindsXmpWhereverItHides) {
  const std::string packet = XmpPacket(kAngles);
  Bytes unmarked = JpegHeader({});
  unmarked.insert(unmarked.end() - 2, packet.begin(), packet.end());
  const std::pair<const char*, Bytes> places[] = {
      {"segment", JpegHeader({.xmp = packet})},
      {"extended segment", JpegHeader({.extended_xmp = packet})},
      {"tag 700 of the image",
       JpegHeader({.exif = ExifWriter().Undefined(ExifIfd::kImage, 0x02BC, BytesOf(packet)).Write()})},
      {"tag 700 of the EXIF directory",
       JpegHeader({.exif = ExifWriter().Undefined(ExifIfd::kExif, 0x02BC, BytesOf(packet)).Write()})},
      {"somewhere", unmarked},
      {"TIFF", TiffImage(ExifWriter(), 32, 24, Bytes(32 * 24 * 3, 100), packet)}};
  for (const auto& [where, bytes] : places) {
    SCOPED_TRACE(where);
    const auto photo = ValueOf(ReadPhotoFromBytes("a", bytes));
    ASSERT_TRUE(photo.attitude);
    EXPECT_NEAR(photo.attitude->yaw_rad, 12.5 * geo::kPi / 180.0, 1e-12);
  }
}

TEST(ReadPhoto, ReadsPositionAndSizeOfATiff) {
  const auto photo = ValueOf(ReadPhotoFromBytes(
      "a.tif", TiffImage(ExifWriter().Position(-12.25, 130.5), 40, 30, Bytes(40 * 30 * 3, 7))));
  EXPECT_EQ(photo.intrinsics.width_px, 40);
  EXPECT_EQ(photo.intrinsics.height_px, 30);
  ASSERT_TRUE(photo.position);
  EXPECT_NEAR(photo.position->position.lat_deg, -12.25, 1e-8);
}

// As Yuneec's CGO3+ writes them.
TEST(ReadPhoto, ReadsPropertiesThatStandInNoDescription) {
  const std::string packet =
      "<?xpacket begin=\"?\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
      "  <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
      "    <xmp:GPSAltitude>31</xmp:GPSAltitude>\n    <xmp:CameraYaw>-85.5</xmp:CameraYaw>\n"
      "    <xmp:CameraPitch>-90</xmp:CameraPitch>\n    <xmp:CameraRoll>0.002856</xmp:CameraRoll>\n"
      "  </rdf:RDF>\n<?xpacket end=\"w\"?>\n";
  const ExifWriter exif = ExifWriter().Position(43.780863, 23.743606).Rational(ExifIfd::kGps, 6, {{314, 10}});
  const Photo photo = ValueOf(ReadPhotoFromBytes("a.jpg", JpegHeader({.exif = exif.Write(), .xmp = packet})));
  ASSERT_TRUE(photo.attitude);
  EXPECT_EQ(photo.attitude->kind, AttitudeKind::kGimbal);
  EXPECT_NEAR(photo.attitude->yaw_rad, geo::DegToRad(-85.5), 1e-12);
  EXPECT_NEAR(photo.attitude->pitch_rad, geo::DegToRad(-90.0), 1e-12);
  ASSERT_TRUE(photo.position);
  EXPECT_EQ(photo.position->height_above_takeoff_m, 31.0);
  EXPECT_FALSE(photo.position->height_amsl_m) << "EXIF repeats the height above take-off";
  const std::string alone = XmpPacket("xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\" xmp:GPSAltitude=\"31\"");
  const Photo other = ValueOf(ReadPhotoFromBytes("a.jpg", JpegHeader({.exif = exif.Write(), .xmp = alone})));
  EXPECT_FALSE(other.position.value().height_above_takeoff_m) << "of whichever program";
}

TEST(ReadPhoto, TakesTheHeightAboveTakeOff) {
  EXPECT_EQ(ValueOf(ReadPhotoFromBytes("a.jpg", RichPhoto())).position->height_above_takeoff_m, 40.0);
}

// Programs that write the EXIF block anew keep the maker note byte for byte.
TEST(ReadPhoto, ReadsALittleEndianMakerNoteInABigEndianExif) {
  const ExifWriter exif =
      ExifWriter()
          .Ascii(ExifIfd::kImage, 0x010F, "DJI")
          .Undefined(ExifIfd::kExif, 0x927C, DjiNote({{9, -75.0f}, {10, 45.0f}, {11, 0.0f}}))
          .Position(46.5, 7.5);
  for (const bool is_big_endian : {false, true}) {
    const auto photo = ValueOf(ReadPhotoFromBytes("a.jpg", JpegHeader({.exif = exif.Write(is_big_endian)})));
    ASSERT_TRUE(photo.attitude) << is_big_endian;
    EXPECT_NEAR(photo.attitude->pitch_rad, geo::DegToRad(-75.0), 1e-6);
    EXPECT_NEAR(photo.attitude->yaw_rad, geo::DegToRad(45.0), 1e-6);
    EXPECT_NEAR(photo.position->position.lat_deg, 46.5, 1e-6);
  }
}

TEST(ReadPhoto, TellsCamerasApart) {
  const auto key = [](const JpegParts& parts) {
    return ReadPhotoFromBytes("a.jpg", JpegHeader(parts))->camera_key;
  };
  const auto exif = [](std::uint32_t focal_tenths) {
    return ExifWriter()
        .Ascii(ExifIfd::kImage, 0x0110, "X")
        .Rational(ExifIfd::kExif, 0x920A, {{focal_tenths, 10}})
        .Write();
  };
  EXPECT_EQ(key({.exif = exif(45)}), key({.exif = exif(45)}));
  EXPECT_NE(key({.exif = exif(45)}), key({.exif = exif(90)}));
  EXPECT_NE(key({.exif = exif(45)}), key({.width_px = 2000, .height_px = 1500, .exif = exif(45)}));
}

TEST(ReadPhoto, TakesTheLensFromXmpWhereTheTagsAreLost) {
  const auto read = [](const std::string& tags, const Bytes& exif = {}) {
    return ValueOf(ReadPhotoFromBytes(
        "a.jpg", JpegHeader({.exif = exif,
                             .xmp = XmpPacket("xmlns:exif=\"http://ns.adobe.com/exif/1.0/\" "
                                              "xmlns:tiff=\"http://ns.adobe.com/tiff/1.0/\" " +
                                              tags)})));
  };
  const auto by_sensor = read("tiff:Make=\"DJI\" tiff:Model=\"FC300S\" exif:FocalLength=\"361/100\"");
  EXPECT_EQ(by_sensor.make, "DJI");
  EXPECT_EQ(by_sensor.focal_source, FocalSource::kSensorTable);
  EXPECT_NEAR(by_sensor.intrinsics.focal_x_px, 3.61 / 6.17 * 4000, 1e-9);
  const auto by_equivalent = read("exif:FocalLength=\"20/1\" exif:FocalLengthIn35mmFilm=\"30\"");
  EXPECT_EQ(by_equivalent.focal_source, FocalSource::k35mmEquivalent);
  EXPECT_NEAR(by_equivalent.intrinsics.focal_x_px, 30.0 / 43.2666 * 5000.0, 0.1);
  EXPECT_EQ(read("exif:FocalLengthIn35mmFilm=\"0\"").focal_source, FocalSource::kAssumed);
  // The tags themselves come first.
  const Bytes exif = ExifWriter()
                         .Ascii(ExifIfd::kImage, 0x0110, "FC300S")
                         .Rational(ExifIfd::kExif, 0x920A, {{361, 100}})
                         .Write();
  EXPECT_NEAR(read("tiff:Model=\"FC6310\" exif:FocalLength=\"88/10\"", exif).intrinsics.focal_x_px,
              3.61 / 6.17 * 4000, 1e-9);
}

TEST(ReadPhoto, NotesWhatAFilterMakesOfTheChannels) {
  const auto notes_of = [](const char* make, const char* model, const std::string& bands = "") {
    const Bytes exif =
        ExifWriter().Ascii(ExifIfd::kImage, 0x010F, make).Ascii(ExifIfd::kImage, 0x0110, model).Write();
    const std::string tags =
        "xmlns:Camera=\"http://pix4d.com/camera/1.0/\" Camera:BandName=\"" + bands + "\"";
    const auto photo =
        ReadPhotoFromBytes("a.jpg", JpegHeader({.exif = exif, .xmp = bands.empty() ? "" : XmpPacket(tags)}));
    EXPECT_TRUE(photo.ok());
    std::string said;
    for (const std::string& note : InWords(photo->notes)) said += note;
    return said;
  };
  EXPECT_THAT(notes_of("MAPIR", "Survey3W_RGN"), HasSubstr("the channels RGN:"));
  EXPECT_THAT(notes_of("Maker", "Filtered", "Near infrared, Green, Blue"),
              HasSubstr("Near infrared, Green, Blue:"));
  for (const auto& said :
       {notes_of("MAPIR", "Survey3W_RGB"), notes_of("Parrot", "Sequoia", "Red, Green, Blue"),
        notes_of("Maker", "Model_RGN"), notes_of("DJI", "FC6360", "RGB")})
    EXPECT_EQ(said.find("channels"), std::string::npos) << said;
}

// A FLIR Duo Pro R writes it into both.
TEST(ReadPhoto, TakesNoLargePictureForThermalByTheBandThatItNames) {
  const auto lens_of = [](int width_px, int height_px) {
    const std::string xmp =
        XmpPacket("xmlns:Camera=\"http://pix4d.com/camera/1.0/\" Camera:BandName=\"LWIR\"");
    return ValueOf(ReadPhotoFromBytes("a.jpg",
                                      JpegHeader({.width_px = width_px, .height_px = height_px, .xmp = xmp})))
        .lens;
  };
  EXPECT_EQ(lens_of(640, 512), Lens::kThermal);
  EXPECT_EQ(lens_of(4000, 3000), Lens::kUnsaid);
}

TEST(ReadPhoto, NotesOrientationAndViewersWithoutTurningAnything) {
  const auto photo = ValueOf(ReadPhotoFromBytes(
      "a.jpg", JpegHeader({.exif = ExifWriter()
                                       .Short(ExifIfd::kImage, 0x0112, 6)
                                       .Ascii(ExifIfd::kImage, 0x0131, "Microsoft Windows Photo Viewer 10.0")
                                       .Write()})));
  EXPECT_EQ(photo.intrinsics.width_px, 4000);
  EXPECT_THAT(InWords(photo.notes), ::testing::Contains(HasSubstr("orientation 6")));
  EXPECT_THAT(InWords(photo.notes), ::testing::Contains(HasSubstr("Re-saved by")));
}

TEST(ReadPhoto, RefusesOtherFilesInWordsThatHelp) {
  EXPECT_THAT(Refusal({}).message, HasSubstr("empty"));
  EXPECT_EQ(Refusal({}).code, ErrorCode::kCorrupt);
  EXPECT_THAT(Refusal(BytesOf("Dear pilot,\nthis is a note.\n")).message, HasSubstr("text file"));
  EXPECT_EQ(Refusal(BytesOf("Dear pilot")).code, ErrorCode::kUnsupportedFormat);
  EXPECT_THAT(Refusal(BytesOf(std::string("\0\0\0\x20"
                                          "ftypisom",
                                          12)))
                  .message,
              HasSubstr("video"));
  EXPECT_THAT(Refusal(BytesOf(std::string("\0\0\0\x20"
                                          "ftypheic",
                                          12)))
                  .message,
              HasSubstr("HEIC"));
  for (const char* brands : {"avif", "avis", "mif1    heicavif", "msf1    msf1avis"})
    EXPECT_THAT(Refusal(BytesOf(std::string("\0\0\0\x18", 4) + "ftyp" + brands)).message, HasSubstr("AVIF"))
        << brands;
  for (const char* brands : {"hevc", "msf1", "mif1    mif1heic"})
    EXPECT_THAT(Refusal(BytesOf(std::string("\0\0\0\x18", 4) + "ftyp" + brands)).message, HasSubstr("HEIC"))
        << brands;
  const std::string tar = std::string(257, '\0') + "ustar";
  for (const auto& [head, kind] :
       std::initializer_list<std::pair<std::string, const char*>>{{"PK\x03\x04 rest", "ZIP"},
                                                                  {"7z\xBC\xAF\x27\x1C", "7-Zip"},
                                                                  {"Rar!\x1A\x07", "RAR"},
                                                                  {"\xFD\x37zXZ", "xz"},
                                                                  {"\x28\xB5\x2F\xFD", "Zstandard"},
                                                                  {tar, "tar"}})
    EXPECT_THAT(Refusal(BytesOf(head)).message, HasSubstr("an archive (" + std::string(kind) + ")"));
  EXPECT_THAT(Refusal(TiffImage(ExifWriter().Undefined(ExifIfd::kImage, 0xC612, {1, 4, 0, 0}), 32, 24,
                                Bytes(32 * 24 * 3)))
                  .message,
              HasSubstr("DNG"));
  EXPECT_EQ(Refusal(Bytes(300, 0x01)).code, ErrorCode::kUnsupportedFormat);
}

TEST(ReadPhoto, RefusesJpegsThatAreCutOff) {
  EXPECT_THAT(Refusal(JpegHeader({.has_end = false})).message, HasSubstr("cut off"));
  EXPECT_EQ(Refusal({0xFF, 0xD8, 0xFF, 0xE1, 0x10}).code, ErrorCode::kCorrupt);
  // An end marker of a preview inside the metadata is not the picture's.
  EXPECT_THAT(
      Refusal(
          JpegHeader(
              {.exif = ExifWriter().Undefined(ExifIfd::kExif, 0x927C, {0xFF, 0xD8, 1, 2, 0xFF, 0xD9}).Write(),
               .has_end = false}))
          .message,
      HasSubstr("cut off"));
  Bytes padded = JpegHeader({});
  padded.resize(padded.size() + 200000, 0);  // trailing bytes harm nobody
  EXPECT_TRUE(ReadPhotoFromBytes("a.jpg", padded).ok());
}

TEST(ReadPhoto, RefusesTiffsThatAreCutOff) {
  Bytes tiff = TiffImage(ExifWriter(), 32, 24, Bytes(32 * 24 * 3, 5));
  EXPECT_TRUE(ReadPhotoFromBytes("a.tif", tiff).ok());
  tiff.pop_back();
  EXPECT_THAT(Refusal(tiff).message, HasSubstr("cut off"));
}

TEST(ReadPhoto, RefusesAbsurdSizes) {
  EXPECT_EQ(Refusal(JpegHeader({.width_px = 65535, .height_px = 65535})).code, ErrorCode::kTooLarge);
  EXPECT_EQ(Refusal(JpegHeader({.width_px = 29000, .height_px = 29000})).code, ErrorCode::kTooLarge);
  EXPECT_EQ(Refusal(JpegHeader({.width_px = 4, .height_px = 3})).code, ErrorCode::kUnsupportedFormat);
  EXPECT_EQ(Refusal(JpegHeader({.width_px = 0, .height_px = 0})).code, ErrorCode::kCorrupt);
  EXPECT_EQ(Refusal(TiffImage(ExifWriter(), 2000000000, 2000000000, {})).code, ErrorCode::kTooLarge);
}

TEST(ReadPhoto, SurvivesBeingCutAnywhere) {
  for (const Bytes& whole :
       {RichPhoto(), TiffImage(ExifWriter().Position(1.5, 2.5), 16, 16, Bytes(768, 9), XmpPacket(kAngles))}) {
    for (std::size_t length = 0; length < whole.size(); ++length) {
      const auto photo = ReadPhotoFromBytes("a", std::span(whole).first(length));
      if (!photo.ok()) {
        EXPECT_FALSE(photo.error().message.empty());
      }
    }
  }
}

TEST(ReadPhoto, SurvivesFlippedBytes) {
  std::mt19937 random(1);
  for (const Bytes& whole :
       {RichPhoto(), TiffImage(ExifWriter().Position(1.5, 2.5), 16, 16, Bytes(768, 9), XmpPacket(kAngles))}) {
    for (int round = 0; round < 4000; ++round) {
      Bytes damaged = whole;
      for (int flips = 0; flips < 4; ++flips) {
        damaged[random() % damaged.size()] = static_cast<std::uint8_t>(random() % 3 == 0 ? 0xFF : random());
      }
      const auto photo = ReadPhotoFromBytes("a", damaged);
      if (photo.ok() && photo->position) {
        EXPECT_LE(std::abs(photo->position->position.lat_deg), 90.0);
        EXPECT_LE(std::abs(photo->position->position.lon_deg), 180.0);
      }
      if (photo.ok()) {
        EXPECT_GT(photo->intrinsics.focal_x_px, 0.0);
      }
    }
  }
}

TEST(ReadTiffTags, StopsAtLoopsAndHugeCounts) {
  // The EXIF and GPS pointers lead back to the first directory.
  ExifWriter loop;
  loop.Long(ExifIfd::kImage, 0x8769, 8).Long(ExifIfd::kImage, 0x8825, 8).Long(ExifIfd::kImage, 0x0100, 32);
  Bytes looping = loop.Write();
  MemoryBytes source(looping);
  EXPECT_EQ(ValueOf(ReadTiffTags(source)).values().size(), 3u);
  // One entry that claims four thousand million rationals.
  Bytes huge = ExifWriter().Rational(ExifIfd::kImage, 0x0100, {{1, 1}}).Write();
  for (int i = 0; i < 4; ++i) huge[8 + 2 + 4 + i] = 0xFF;
  MemoryBytes huge_source(huge);
  EXPECT_TRUE(ValueOf(ReadTiffTags(huge_source)).values().empty());
}

TEST(XmpTags, RefusesBrokenAndBottomlessXml) {
  XmpTags xmp;
  EXPECT_FALSE(xmp.AddPacket("<x:xmpmeta"));
  EXPECT_FALSE(xmp.AddPacket(""));
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  EXPECT_FALSE(xmp.AddPacket(deep));
  std::string nested = "<q:a xmlns:q=\"u\">";
  for (int i = 0; i < 200; ++i) nested = "<q:a>" + nested + "</q:a>";
  xmp.AddPacket(XmpPacket("", nested));
  EXPECT_TRUE(xmp.empty());
}

TEST(XmpTags, ReadsNumbersAsPeopleWriteThem) {
  EXPECT_EQ(ParseXmpNumber("+198.31"), 198.31);
  EXPECT_EQ(ParseXmpNumber(" -1e1 "), -10.0);
  EXPECT_EQ(ParseXmpNumber("73/10"), 7.3);
  for (const char* text :
       {"", "+", "-", "nan", "inf", "1/0", "-20000000000", "12abc", "0x10", "1,5", "1e999"}) {
    EXPECT_FALSE(ParseXmpNumber(text)) << text;
  }
}

TEST(XmpTags, KeepsEqualNamesOfDifferentMakersApart) {
  XmpTags xmp;
  ASSERT_TRUE(
      xmp.AddPacket(XmpPacket("xmlns:drone-dji=\"http://elsewhere.example/1.0/\" "
                              "xmlns:own=\"http://www.dji.com/drone-dji/1.0/\" "
                              "own:GimbalYawDegree=\"5\"")));
  EXPECT_EQ(xmp.Number("drone-dji:GimbalYawDegree"), 5.0);
}

}  // namespace
}  // namespace skyquilt::flight
