// What cameras write of their gyros, whole, damaged and impossible.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "core/flight/metadata/attitude_tags.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/flight/synthetic_photo.h"

namespace skyquilt::flight {
namespace {

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
