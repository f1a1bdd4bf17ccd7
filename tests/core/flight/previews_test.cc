// Small pictures without records beside photos of their names: previews of cameras and programs, and what
// only looks like them.
#include "core/flight/aside/previews.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "core/flight/aside/copies.h"
#include "core/flight/photos/read_photo.h"
#include "tests/core/flight/synthetic_photo.h"

namespace skyquilt::flight {
namespace {

Photo WithRecords(const std::string& name, int number) {
  const auto exif = ExifWriter()
                        .Ascii(ExifIfd::kImage, 0x010F, "DJI")
                        .Ascii(ExifIfd::kImage, 0x0110, "FC6310")
                        .Ascii(ExifIfd::kExif, 0x9003, fmt::format("2024:06:01 10:00:{:02}", number))
                        .Position(46.5 + 0.0003 * number, 7.5);
  const auto photo =
      ReadPhotoFromBytes(name, JpegHeader({.width_px = 4000, .height_px = 3000, .exif = exif.Write()}));
  EXPECT_TRUE(photo.ok()) << name;
  return photo ? *photo : Photo();
}

Photo Bare(const std::string& name, int width_px, int height_px) {
  const auto photo = ReadPhotoFromBytes(name, JpegHeader({.width_px = width_px, .height_px = height_px}));
  EXPECT_TRUE(photo.ok()) << name;
  return photo ? *photo : Photo();
}

std::vector<Photo> Flown(int count) {
  std::vector<Photo> photos;
  for (int i = 1; i <= count; ++i) photos.push_back(WithRecords(fmt::format("DJI_{:04}.JPG", i), i));
  return photos;
}

std::size_t Kept(std::vector<Photo> photos) {
  std::vector<LeftOutPhoto> left_out;
  LeaveOutCopies(photos, left_out);
  return photos.size();
}

TEST(FindPreviews, LeavesOutWhatLiesBesidePhotosForLooking) {
  for (const char* pattern : {"small/DJI_{:04}.JPG", "DJI_{:04}.SCR", "small_DJI_{:04}.JPG"}) {
    std::vector<Photo> photos = Flown(5);
    for (int i = 1; i <= 5; ++i) photos.push_back(Bare(fmt::format(fmt::runtime(pattern), i), 640, 480));
    // Two kinds of previews in one folder, and one whose photo is not there.
    for (int i = 1; i <= 5; ++i) photos.push_back(Bare(fmt::format("DJI_{:04}.THM", i), 160, 120));
    photos.push_back(Bare("DJI_0009.THM", 160, 120));
    EXPECT_EQ(Kept(photos), 6U) << pattern;
    const auto previews = FindPreviews(photos);
    EXPECT_EQ(previews[5], std::optional<std::size_t>(0));
    EXPECT_EQ(previews[0], std::nullopt);
  }
}

TEST(FindPreviews, TakesNoOtherFlightForPreviews) {
  // Two of equal names say nothing, nor do a few of many.
  std::vector<Photo> photos = Flown(8);
  for (int i = 1; i <= 2; ++i) photos.push_back(Bare(fmt::format("b/DJI_{:04}.JPG", i), 2000, 1500));
  EXPECT_EQ(Kept(photos), 10U);
  for (int i = 6; i <= 12; ++i) photos.push_back(Bare(fmt::format("c/DJI_{:04}.JPG", i), 2000, 1500));
  EXPECT_EQ(Kept(photos), 17U);
  // Of another aspect, and as large as the photos.
  photos = Flown(5);
  for (int i = 1; i <= 5; ++i) photos.push_back(Bare(fmt::format("d/DJI_{:04}.JPG", i), 1600, 900));
  for (int i = 1; i <= 5; ++i) photos.push_back(Bare(fmt::format("e/DJI_{:04}.JPG", i), 4000, 3000));
  EXPECT_EQ(Kept(photos), 15U);
}

TEST(FindPreviews, KeepsPicturesOfWhichNoneHasRecords) {
  std::vector<Photo> photos;
  for (int i = 1; i <= 5; ++i) {
    photos.push_back(Bare(fmt::format("DJI_{:04}.JPG", i), 4000, 3000));
    photos.push_back(Bare(fmt::format("b/DJI_{:04}.JPG", i), 2000, 1500));
  }
  EXPECT_EQ(Kept(photos), 10U);
}

}  // namespace
}  // namespace skyquilt::flight
