// Which pictures a map is made of: copies beside their originals, several cameras, panoramas and raw
// pictures, and all that must not be taken for such.
#include "core/flight/aside/aside.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "core/flight/aside/copies.h"
#include "core/flight/aside/one_camera.h"
#include "core/flight/aside/picture_name.h"
#include "core/flight/photos/read_photo.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/flight/synthetic_photo.h"

namespace skyquilt::flight {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A picture as a camera writes it; what is changed of it makes a copy, or another camera.
struct Taken {
  std::string time = "2024:06:01 10:00:00";
  std::string sub_seconds{};
  double lat_deg = 46.5, lon_deg = 7.5;
  std::string model = "M3T";
  std::string software = "v01.02";
  std::string source = "WideCamera";  // the lens; none: no XMP of the maker
  bool has_note = true;
  std::uint32_t exposure = 500;
  std::uint16_t focal_35mm = 24;
  int width_px = 4000, height_px = 3000;
};

Photo Picture(const std::string& name, const Taken& taken) {
  ExifWriter exif;
  exif.Ascii(ExifIfd::kImage, 0x010F, "DJI").Ascii(ExifIfd::kImage, 0x0110, taken.model);
  if (!taken.software.empty()) exif.Ascii(ExifIfd::kImage, 0x0131, taken.software);
  if (!taken.time.empty()) exif.Ascii(ExifIfd::kExif, 0x9003, taken.time);
  if (!taken.sub_seconds.empty()) exif.Ascii(ExifIfd::kExif, 0x9291, taken.sub_seconds);
  if (taken.has_note) exif.Undefined(ExifIfd::kExif, 0x927C, DjiNote({{9, -90.0f}}));
  exif.Rational(ExifIfd::kExif, 0x829A, {{1, taken.exposure}})
      .Short(ExifIfd::kExif, 0xA405, taken.focal_35mm);
  if (taken.lat_deg != 0.0) exif.Position(taken.lat_deg, taken.lon_deg);
  const auto photo = ReadPhotoFromBytes(
      name, JpegHeader({.width_px = taken.width_px,
                        .height_px = taken.height_px,
                        .exif = exif.Write(),
                        .xmp = taken.source.empty()
                                   ? ""
                                   : XmpPacket(std::string(kDjiNamespace) + "drone-dji:ImageSource=\"" +
                                               taken.source + "\"")}));
  EXPECT_TRUE(photo.ok()) << name;
  return photo ? *photo : Photo();
}

// As an editor writes it.
Taken Edited(Taken taken) {
  taken.software = "Adobe Photoshop Lightroom Classic 12.4 (Windows)";
  taken.source = "";
  return taken;
}

std::vector<std::string> NamesOf(const std::vector<Photo>& photos) {
  std::vector<std::string> names;
  for (const Photo& photo : photos) names.push_back(photo.name);
  return names;
}

std::vector<std::string> Left(std::vector<Photo> photos) {
  std::vector<LeftOutPhoto> left_out;
  LeaveOutCopies(photos, left_out);
  return NamesOf(photos);
}

TEST(FindCopies, KnowsACopyByItsName) {
  for (const char* name :
       {"DJI_0021-2.jpg", "DJI_0021 copy.jpg", "DJI_0021_edited.jpg", "dji_0021 (1).jpg",
        "DJI_0021 - Copy (2).JPG", "Copy of DJI_0021.JPG", "web/DJI_0021.jpg", "DJI_0021~2.png"}) {
    // Whichever comes first, and though its fix is one of a thousand kilometres away.
    Taken stale = Edited({});
    stale.lat_deg = 37.0;
    for (const bool is_first : {true, false}) {
      std::vector<Photo> photos{Picture("DJI_0021.JPG", {}), Picture(name, stale)};
      if (is_first) std::swap(photos[0], photos[1]);
      EXPECT_THAT(Left(photos), ElementsAre("DJI_0021.JPG")) << name;
    }
  }
}

TEST(FindCopies, NamesTheOriginalAndTheReason) {
  std::vector<Photo> photos{Picture("a_0001-2.jpg", Edited({})), Picture("a_0001.jpg", {})};
  std::vector<LeftOutPhoto> left_out;
  LeaveOutCopies(photos, left_out);
  ASSERT_EQ(left_out.size(), 1U);
  EXPECT_EQ(left_out[0].name, "a_0001-2.jpg");
  EXPECT_EQ(left_out[0].code, ErrorCode::kConflict);
  EXPECT_THAT(InWords(left_out[0].reason), HasSubstr("a_0001.jpg"));
}

TEST(FindCopies, KnowsARenamedCopyByItsMoment) {
  EXPECT_THAT(Left({Picture("DJI_0021.JPG", {}), Picture("north meadow.jpg", Edited({}))}),
              ElementsAre("DJI_0021.JPG"));
  Taken small = Edited({});
  small.software = "";
  small.has_note = false;
  small.width_px = 1600, small.height_px = 1200;
  EXPECT_THAT(Left({Picture("DJI_0021.JPG", {}), Picture("IMG-WA17.jpg", small)}),
              ElementsAre("DJI_0021.JPG"));
  // Elsewhere in that second: the one before or after it.
  small.lat_deg += 0.00005;
  EXPECT_EQ(Left({Picture("DJI_0021.JPG", {}), Picture("IMG-WA17.jpg", small)}).size(), 2U);
}

TEST(FindCopies, BelievesAFarPlaceUnlessSeveralCopiesShareIt) {
  Taken far = Edited({});
  far.lat_deg = 46.53;
  // Another aircraft's, in the same second.
  EXPECT_EQ(Left({Picture("DJI_0021.JPG", {}), Picture("north meadow.jpg", far)}).size(), 2U);
  Taken next = far, next_original;
  next.time = next_original.time = "2024:06:01 10:00:05";
  EXPECT_THAT(Left({Picture("DJI_0021.JPG", {}), Picture("DJI_0022.JPG", next_original),
                    Picture("north meadow.jpg", far), Picture("the barn.jpg", next)}),
              ElementsAre("DJI_0021.JPG", "DJI_0022.JPG"));
  // The second aircraft goes on.
  next.lat_deg += 0.0003;
  EXPECT_EQ(Left({Picture("DJI_0021.JPG", {}), Picture("DJI_0022.JPG", next_original),
                  Picture("north meadow.jpg", far), Picture("the barn.jpg", next)})
                .size(),
            4U);
}

TEST(FindCopies, KeepsTheOriginalUnderAnotherName) {
  EXPECT_THAT(Left({Picture("DJI_0021.JPG", Edited({})), Picture("DJI_0021_orig.JPG", {})}),
              ElementsAre("DJI_0021_orig.JPG"));
}

TEST(FindCopies, LeavesEditedPicturesWithoutAnOriginal) {
  EXPECT_EQ(Left({Picture("DJI_0021-2.jpg", Edited({})),
                  Picture("DJI_0022-2.jpg", Edited({.time = "2024:06:01 10:00:02"}))})
                .size(),
            2U);
  // Two of one exposure are one too many.
  EXPECT_EQ(Left({Picture("DJI_0021-2.jpg", Edited({})), Picture("DJI_0021-3.jpg", Edited({}))}).size(), 1U);
}

TEST(FindCopies, TakesNoSeriesForCopies) {
  // A burst within one second, at one place, with and without fractions.
  EXPECT_EQ(
      Left({Picture("DJI_0001.JPG", {}), Picture("DJI_0002.JPG", {}), Picture("DJI_0003.JPG", {})}).size(),
      3U);
  EXPECT_EQ(Left({Picture("20240601_100000.jpg", {}), Picture("20240601_100000(0).jpg", {}),
                  Picture("20240601_100000-1.jpg", {})})
                .size(),
            3U);
  EXPECT_EQ(
      Left({Picture("A_1.JPG", {.sub_seconds = "10"}), Picture("A_1-2.JPG", Edited({.sub_seconds = "60"}))})
          .size(),
      2U);
  // One of a burst was edited in place, one of a bracket by another program under another name.
  EXPECT_EQ(Left({Picture("DJI_0001.JPG", {}), Picture("DJI_0002.JPG", Edited({}))}).size(), 2U);
  EXPECT_EQ(Left({Picture("DJI_0001.JPG", {}), Picture("DJI_0002_edit.JPG", Edited({}))}).size(), 2U);
  EXPECT_EQ(Left({Picture("DJI_0001.JPG", {}), Picture("sunny.jpg", Edited({.exposure = 2000}))}).size(), 2U);
}

TEST(FindCopies, TakesNoSecondCardForCopies) {
  Taken later;
  later.time = "2024:06:01 11:00:00";
  EXPECT_EQ(Left({Picture("DJI_0001.JPG", {}), Picture("DJI_0001 (2).JPG", later),
                  Picture("b/DJI_0001.JPG", later)})
                .size(),
            3U);
  // Nothing but the name is alike.
  Taken bare{.time = "", .lat_deg = 0.0, .source = "", .has_note = false};
  EXPECT_EQ(Left({Picture("DJI_0001.JPG", bare), Picture("DJI_0001 (2).JPG", bare)}).size(), 2U);
}

TEST(FindCopies, TakesNoOtherSensorForACopy) {
  Taken bare = Edited({});
  bare.software = "", bare.has_note = false;
  bare.width_px = 1600, bare.height_px = 1200;
  const Taken thermal{.source = "InfraredCamera"};
  EXPECT_EQ(Left({Picture("thermal/0001.JPG", thermal), Picture("0001.JPG", bare)}).size(), 2U);
  EXPECT_EQ(Left({Picture("IRX_0001.JPG", thermal), Picture("MAX_0001.JPG", bare)}).size(), 2U);
  // Bands of a rig whose files have one number each.
  std::vector<Photo> bands{Picture("IMG_0001_1.tif", bare), Picture("IMG_0001_2.tif", {}),
                           Picture("IMG_0001.tif", {})};
  bands[0].band_name = "LWIR", bands[1].band_name = "NIR", bands[2].band_name = "Red";
  EXPECT_EQ(Left(bands).size(), 3U);
}

TEST(FindCopies, TakesTheFileWhoseMetadataWereChanged) {
  std::vector<Photo> photos{Picture("DJI_0001.JPG", {.time = "2024:06:01 12:00:00"}),
                            Picture("DJI_0001.JPG_original", {})};
  std::vector<LeftOutPhoto> left_out;
  LeaveOutCopies(photos, left_out);
  EXPECT_THAT(NamesOf(photos), ElementsAre("DJI_0001.JPG"));
  ASSERT_EQ(left_out.size(), 1U);
  EXPECT_THAT(InWords(left_out[0].reason), HasSubstr("metadata"));
  // Unless it lost its position, or what the maker wrote.
  EXPECT_THAT(Left({Picture("a.JPG", {.lat_deg = 0.0}), Picture("a.JPG_original", {})}),
              ElementsAre("a.JPG_original"));
  EXPECT_THAT(Left({Picture("a.JPG", {.source = ""}), Picture("a.JPG_original", {})}),
              ElementsAre("a.JPG_original"));
}

TEST(FindCopies, LooksAtAThousandPhotosAtOnce) {
  std::vector<Photo> photos;
  for (int i = 0; i < 1000; ++i) {
    Photo photo = Picture("DJI_0001.JPG", Edited({}));
    photo.name = fmt::format("{}/DJI_0001-{}.JPG", i, i % 90 + 1);
    photos.push_back(std::move(photo));
  }
  EXPECT_EQ(FindCopies(photos).size(), photos.size());
}

TEST(PictureName, ReadsMarksOfCopies) {
  const auto unmarked = [](const char* name) {
    const auto read = WithoutCopyMark(PictureNameOf(name).stem);
    return read ? read->stem : "-";
  };
  EXPECT_EQ(unmarked("DJI_0021-2.jpg"), "dji_0021");
  EXPECT_EQ(unmarked("DJI_0021_W-2.jpg"), "dji_0021_w");
  EXPECT_EQ(unmarked("IMG_1 (1).jpg"), "img_1");
  EXPECT_EQ(unmarked("IMG_1 copy 2.jpg"), "img_1 copy");
  for (const char* own : {"DJI_0021.JPG", "DJI_20240601100000_0001.JPG", "IMG_0001.tif", "P-2.JPG", "(1).jpg",
                          "copy.jpg", "-2.jpg", "", ".", "_", "/", "a.jpg_original"})
    EXPECT_EQ(unmarked(own), "-") << own;
}

// A flight of `count` moments 5 s and 30 m apart.
void AddCamera(const std::string& mark, const Taken& taken, int count, Flight& flight, int from = 0) {
  for (int i = from; i < from + count; ++i) {
    Taken one = taken;
    one.time = fmt::format("2024:06:01 10:{:02}:{:02}", i * 5 / 60, i * 5 % 60);
    if (one.lat_deg != 0.0) one.lat_deg += 0.00027 * i;
    flight.photos.push_back(Picture(fmt::format("DJI_{:04}{}.JPG", i, mark), one));
  }
}

const Taken kThermal{.source = "InfraredCamera", .focal_35mm = 40, .width_px = 640, .height_px = 512};
const Taken kZoom{.source = "ZoomCamera", .focal_35mm = 162};

TEST(KeepOneCamera, TakesTheWideOneOfSeveralLenses) {
  for (const bool has_positions : {true, false}) {
    for (const bool has_sources : {true, false}) {
      Flight flight;
      for (auto [mark, taken] : {std::pair("_T", kThermal), {"_Z", kZoom}, {"_W", Taken{}}}) {
        if (!has_positions) taken.lat_deg = 0.0;
        if (!has_sources) taken.source = "";
        AddCamera(mark, taken, 6, flight);
      }
      KeepOneCamera(flight);
      ASSERT_EQ(flight.photos.size(), 6U);
      for (const Photo& photo : flight.photos) EXPECT_THAT(photo.name, HasSubstr("_W"));
      ASSERT_EQ(flight.left_out.size(), 12U);
      EXPECT_EQ(flight.left_out[0].code, ErrorCode::kUnprocessable);
      ASSERT_EQ(flight.warnings.size(), 2U);
      EXPECT_THAT(InWords(flight.warnings[0]),
                  ::testing::AllOf(HasSubstr("6 pictures"), HasSubstr("4000 x 3000 px")));
    }
  }
}

TEST(KeepOneCamera, MissingPicturesAreNoReasonForAnother) {
  Flight flight;
  AddCamera("_T", kThermal, 20, flight);
  AddCamera("_V", {.source = "VisibleCamera"}, 19, flight);
  KeepOneCamera(flight);
  EXPECT_EQ(flight.photos.size(), 19U);
}

TEST(KeepOneCamera, MakesAThermalMapOfThermalPictures) {
  Flight flight;
  AddCamera("_T", kThermal, 6, flight);
  KeepOneCamera(flight);
  EXPECT_EQ(flight.photos.size(), 6U);
  EXPECT_THAT(flight.warnings, IsEmpty());
  AddCamera("_W", {}, 2, flight);
  KeepOneCamera(flight);
  EXPECT_EQ(flight.photos.size(), 6U);
  ASSERT_EQ(flight.left_out.size(), 2U);
  EXPECT_THAT(InWords(flight.left_out[0].reason), HasSubstr("visible"));
}

TEST(KeepOneCamera, CountsVisiblePicturesOverAllTheirCameras) {
  Flight flight;
  AddCamera("_T", kThermal, 14, flight);
  AddCamera("", {.model = "FC6310", .source = "", .focal_35mm = 35}, 12, flight, 20);
  AddCamera("", {.model = "M3E", .source = ""}, 12, flight, 40);
  KeepOneCamera(flight);
  EXPECT_EQ(flight.photos.size(), 24U);
  ASSERT_EQ(flight.left_out.size(), 14U);
  EXPECT_THAT(InWords(flight.left_out[0].reason), HasSubstr("A thermal picture"));
}

TEST(KeepOneCamera, KeepsCamerasThatFlewApart) {
  Flight flight;
  AddCamera("", {}, 6, flight);
  // Another model beside it at the same time, the same one later, and the same one zoomed in on the way.
  AddCamera("b", {.lon_deg = 7.501, .model = "FC6310", .source = "", .focal_35mm = 35}, 4, flight);
  AddCamera("", {}, 6, flight, 20);
  AddCamera("", {.focal_35mm = 48}, 3, flight, 40);
  KeepOneCamera(flight);
  EXPECT_EQ(flight.photos.size(), 19U);
  EXPECT_THAT(flight.left_out, IsEmpty());
}

TEST(KeepOneCamera, KeepsRigsOfLikeCamerasAndBands) {
  Flight flight;
  AddCamera("_a", {.model = "Rig", .source = ""}, 5, flight);
  AddCamera("_b", {.model = "Rig", .source = ""}, 5, flight);
  AddCamera("_5", {.model = "Rig", .source = "", .width_px = 1280, .height_px = 960}, 5, flight);
  for (std::size_t i = 10; i < 15; ++i) flight.photos[i].band_name = "NIR";
  KeepOneCamera(flight);
  EXPECT_EQ(flight.photos.size(), 15U);
}

TEST(KeepOneCamera, KeepsTheCameraOfAnObliqueRigThatLooksDown) {
  const auto rig = [](std::optional<AttitudeKind> kind) {
    Flight flight;
    for (const char* mark : {"_a", "_b", "_c", "_d"})
      AddCamera(mark, {.model = "Rig", .source = "", .focal_35mm = 50}, 5, flight);
    AddCamera("_e", {.model = "Rig", .source = "", .focal_35mm = 35}, 5, flight);
    for (Photo& photo : flight.photos) {
      photo.attitude.reset();
      if (kind) photo.attitude = RecordedAttitude{.kind = *kind, .pitch_rad = -1.5, .source = ""};
    }
    KeepOneCamera(flight);
    return flight.photos.size();
  };
  EXPECT_EQ(rig(std::nullopt), 25U);
  EXPECT_EQ(rig(AttitudeKind::kAirframe), 25U) << "the aircraft's angles do not say where a camera looks";
  EXPECT_EQ(rig(AttitudeKind::kGimbal), 20U) << "all look down: a second focal length of one moment";
}

TEST(KeepOneCamera, LeavesASecondCameraOfTheSameMoments) {
  Flight flight;
  AddCamera("", {.model = "A", .source = ""}, 8, flight);
  AddCamera("x", {.model = "B", .source = "", .focal_35mm = 60}, 5, flight);
  KeepOneCamera(flight);
  ASSERT_EQ(flight.photos.size(), 8U);
  EXPECT_EQ(flight.photos[0].model, "A");
  ASSERT_FALSE(flight.left_out.empty());
  EXPECT_THAT(InWords(flight.left_out[0].reason), HasSubstr("DJI B"));
}

TEST(LeftOutInLines, SaysAReasonOfManyOnce) {
  std::vector<LeftOutPhoto> photos;
  for (const char* name : {"a", "b", "c", "d"}) photos.push_back({name, ErrorCode::kConflict, "Often."});
  photos.push_back({"e", ErrorCode::kCorrupt, "Once."});
  EXPECT_THAT(LeftOutInLines(photos), ElementsAre("a and 3 more: Often.", "e: Once."));
}

TEST(LeftOutInLines, EndsAfterTwentyLines) {
  std::vector<LeftOutPhoto> photos(60, {"many", ErrorCode::kConflict, "Often."});
  for (int i = 0; i < 500; ++i)
    photos.push_back(LeftAside(fmt::format("{}-2", i), Aside::kCopy, fmt::format("{}", i)));
  const auto lines = LeftOutInLines(photos);
  ASSERT_EQ(lines.size(), 21U);
  EXPECT_EQ(lines.back(), "and 481 more pictures");
  EXPECT_THAT(InWords(FirstLeftOut(photos)), ::testing::EndsWith(" And 498 more pictures."));
}

std::string Refused(const Bytes& bytes) {
  const auto photo = ReadPhotoFromBytes("a", bytes);
  return photo ? "" : photo.error().message;
}

TEST(WhyPanorama, KnowsPanoramasByTagsAndShape) {
  const auto with = [](const std::string& projection, int width_px, int height_px) {
    return Refused(JpegHeader(
        {.width_px = width_px,
         .height_px = height_px,
         .xmp = XmpPacket("xmlns:p=\"http://ns.google.com/photos/1.0/panorama/\" p:ProjectionType=\"" +
                          projection + "\"")}));
  };
  EXPECT_THAT(with("equirectangular", 4000, 2000), HasSubstr("panorama"));
  EXPECT_THAT(with("cylindrical", 4000, 3000), HasSubstr("panorama"));
  EXPECT_EQ(with("rectilinear", 4000, 3000), "");
  EXPECT_EQ(with("", 3000, 1000), "");
  EXPECT_THAT(with("", 3001, 1000), HasSubstr("panorama"));
  EXPECT_THAT(with("", 1000, 3001), HasSubstr("over three times its short one"));
}

// A directory of numbers behind a TIFF.
std::uint32_t AddDirectory(const std::vector<std::pair<std::uint16_t, std::uint32_t>>& numbers, Bytes& file) {
  const auto put = [&](std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) file.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  };
  const auto offset = static_cast<std::uint32_t>(file.size());
  put(static_cast<std::uint32_t>(numbers.size()), 2);
  for (const auto& [tag, value] : numbers) {
    put(tag, 2);
    put(4, 2);
    put(1, 4);
    put(value, 4);
  }
  put(0, 4);
  return offset;
}

// A TIFF of 32 x 24 with another picture below or behind it.
Bytes TiffWithAnother(ExifWriter tags, bool is_below,
                      const std::vector<std::pair<std::uint16_t, std::uint32_t>>& other) {
  const Bytes pixels(32 * 24 * 3, 5);
  if (is_below) tags.Long(ExifIfd::kImage, 0x014A, 0);
  Bytes file = TiffImage(tags, 32, 24, pixels);
  const auto offset = static_cast<std::uint32_t>(file.size());
  if (is_below) {
    file = TiffImage(tags.Long(ExifIfd::kImage, 0x014A, offset), 32, 24, pixels);
  } else {
    const std::size_t next = 8 + 2 + 12 * (file[8] + 256 * std::size_t{file[9]});
    for (std::size_t i = 0; i < 4; ++i) file[next + i] = static_cast<std::uint8_t>(offset >> (8 * i));
  }
  EXPECT_EQ(AddDirectory(other, file), offset);
  return file;
}

TEST(WhyRaw, KnowsRawPicturesByTheirContent) {
  constexpr std::uint16_t kSubfile = 0xFE, kWidth = 0x100, kHeight = 0x101, kCompression = 0x103,
                          kPhotometric = 0x106;
  const ExifWriter nikon =
      ExifWriter().Ascii(ExifIfd::kImage, 0x010F, "NIKON CORPORATION").Long(ExifIfd::kImage, kSubfile, 1);
  const auto message = Refused(
      TiffWithAnother(nikon, true, {{kSubfile, 0}, {kWidth, 2072}, {kHeight, 1380}, {kCompression, 34713}}));
  EXPECT_THAT(message, ::testing::AllOf(HasSubstr("raw picture"), HasSubstr("NIKON"), HasSubstr("JPEG")));
  EXPECT_THAT(
      Refused(TiffWithAnother(ExifWriter(), true, {{kWidth, 60}, {kHeight, 40}, {kPhotometric, 32803}})),
      HasSubstr("raw picture"));
  // A thumbnail before the picture, whatever that is.
  EXPECT_THAT(Refused(TiffWithAnother(ExifWriter().Long(ExifIfd::kImage, kSubfile, 1), false,
                                      {{kWidth, 4000}, {kHeight, 3000}})),
              HasSubstr("thumbnail"));
  // Overviews behind a picture or below it are usual; so is a page that calls itself reduced and is alone.
  for (const bool is_below : {true, false}) {
    EXPECT_EQ(Refused(TiffWithAnother(ExifWriter(), is_below, {{kSubfile, 1}, {kWidth, 16}, {kHeight, 12}})),
              "");
  }
  EXPECT_EQ(
      Refused(TiffImage(ExifWriter().Long(ExifIfd::kImage, kSubfile, 1), 32, 24, Bytes(32 * 24 * 3, 5))), "");
  // A directory that lies below itself, and one that lies nowhere.
  for (const std::uint32_t offset : {8U, 4'000'000'000U}) {
    EXPECT_EQ(
        Refused(TiffImage(ExifWriter().Long(ExifIfd::kImage, 0x014A, offset), 32, 24, Bytes(32 * 24 * 3, 5))),
        "");
  }
}

TEST(WhyMap, KnowsGeoTiffsThatNoCameraWrote) {
  constexpr std::uint16_t kGeoKeyDirectory = 34735;
  const auto refused = [](const ExifWriter& tags) {
    return Refused(TiffImage(tags, 32, 24, Bytes(32 * 24 * 3, 5)));
  };
  const ExifWriter map = ExifWriter().Short(ExifIfd::kImage, kGeoKeyDirectory, 1);
  EXPECT_THAT(refused(map), HasSubstr("a map (a GeoTIFF"));
  EXPECT_EQ(refused(ExifWriter(map).Ascii(ExifIfd::kImage, 0x010F, "Parrot")), "");
  EXPECT_EQ(refused(ExifWriter(map).Ascii(ExifIfd::kImage, 0x0110, "Tau 2")), "") << "a model alone";
  EXPECT_EQ(refused(ExifWriter(map).Rational(ExifIfd::kExif, 0x829A, {{1, 500}})), "") << "it was exposed";
  EXPECT_EQ(refused(ExifWriter(map).Position(46.5, 7.5)), "");
  EXPECT_EQ(refused(ExifWriter()), "");
}

TEST(WhyRaw, KnowsFormatsByTheirMarks) {
  using namespace std::string_literals;
  for (const auto& [head, format] : {std::pair("FUJIFILMCCD-RAW 0201"s, "RAF"s),
                                     {"IIRO\x08\0\0\0"s, "ORF"s},
                                     {"IIU\0\x18\0\0\0"s, "RW2"s},
                                     {"\0\0\0\x18"
                                      "ftypcrx \0\0\0\1"s,
                                      "CR3"s},
                                     {"II*\0\x10\0\0\0CR\2\0"s, "CR2"s}}) {
    EXPECT_EQ(RawFormatOf(Bytes(head.begin(), head.end())), format);
    EXPECT_THAT(Refused(Bytes(head.begin(), head.end())), HasSubstr(format));
    EXPECT_EQ(RawFormatOf(Bytes(head.begin(), head.begin() + 3)), "");
  }
  EXPECT_EQ(RawFormatOf({}), "");
}

}  // namespace
}  // namespace skyquilt::flight
