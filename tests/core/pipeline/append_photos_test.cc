// Photos of a recalled flight: what they are read as today, drawn in the range they were drawn in.
#include "core/pipeline/append_photos.h"

#include <gtest/gtest.h>

namespace skyquilt::pipeline {
namespace {

using flight::SampleKind;

flight::Photo GreyPhoto(const std::string& name, SampleKind kind, double high) {
  flight::Photo photo;
  photo.name = name;
  photo.path = "/now/" + name;
  photo.camera_key = "camera";
  photo.sample_kind = kind;
  photo.sample_range = flight::SampleRange{0.0, high};
  return photo;
}

TEST(FillPhotos, KeepsTheRangeThatTheMapIsDrawnIn) {
  alignment::AlignedFlight known;
  known.photos.resize(2);
  known.photos[0].photo.name = "a";
  known.photos[0].photo.sample_range = flight::SampleRange{0.0, 40.0};
  known.photos[1].photo.name = "b";
  flight::Flight read;
  read.photos = {GreyPhoto("a", SampleKind::kFloating, 45.0), GreyPhoto("b", SampleKind::kFloating, 45.0)};
  FillPhotos(read, known);
  EXPECT_EQ(known.photos[0].photo.path, "/now/a");
  EXPECT_EQ(known.photos[0].photo.sample_range->high, 40.0);
  EXPECT_EQ(known.photos[1].photo.sample_range->high, 45.0) << "none was remembered";
}

TEST(KeepSampleRanges, GivesNewPhotosTheRangeOfTheirCameraAndKind) {
  alignment::AlignedFlight known;
  known.photos.resize(1);
  known.photos[0].photo = GreyPhoto("a", SampleKind::kFloating, 40.0);
  std::vector<flight::Photo> photos{GreyPhoto("b", SampleKind::kFloating, 45.0),
                                    GreyPhoto("c", SampleKind::kLevels, 9000.0),
                                    GreyPhoto("d", SampleKind::kFloating, 45.0)};
  photos[2].sample_range.reset();
  KeepSampleRanges(known, photos);
  EXPECT_EQ(photos[0].sample_range->high, 40.0);
  EXPECT_EQ(photos[1].sample_range->high, 9000.0);
  EXPECT_FALSE(photos[2].sample_range) << "one that cannot be decoded";
}

}  // namespace
}  // namespace skyquilt::pipeline
