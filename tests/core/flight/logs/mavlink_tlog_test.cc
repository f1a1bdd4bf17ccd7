#include <gtest/gtest.h>

#include <tuple>
#include <utility>

#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/flight/logs/log_writers.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using test::ValueOf;
using testing::Append;
using testing::Bytes;
using testing::TlogWriter;

template <typename... Values>
Bytes Pack(Values... values) {
  Bytes bytes;
  (Append(bytes, values), ...);
  return bytes;
}

constexpr std::uint64_t kGroundUs = 1'650'000'000'000'000;
constexpr std::uint64_t kVehicleUs =
    kGroundUs - 3'600'000'000;  // the ground station's clock is an hour ahead

Bytes Telemetry(bool second, bool vehicle_knows_utc) {
  TlogWriter w;
  for (std::uint32_t i = 0; i < 100; ++i) {
    const std::uint32_t boot_ms = 60'000 + i * 250;
    // The link delays packets by up to 200 ms.
    const std::uint64_t ground = kGroundUs + std::uint64_t{boot_ms} * 1000 + (i % 5) * 50'000;
    if (vehicle_knows_utc)
      w.Packet(ground, 2, 137, Pack(kVehicleUs + std::uint64_t{boot_ms} * 1000, boot_ms), second);
    w.Packet(ground, 30, 39, Pack(boot_ms, 0.1f, -0.2f, 1.5f, 0.0f, 0.0f, 0.0f), second);
    w.Packet(ground, 24, 24,
             Pack(std::uint64_t{boot_ms} * 1000, std::int32_t{-353'632'610}, std::int32_t{1'491'652'300},
                  std::int32_t{584'000}, std::uint16_t{70}, std::uint16_t{110}, std::uint16_t{500},
                  std::uint16_t{9000}, std::uint8_t{3}, std::uint8_t{12}),
             second);
    w.Packet(ground, 33, 104,
             Pack(boot_ms, std::int32_t{-353'632'610}, std::int32_t{1'491'652'300}, std::int32_t{584'000},
                  std::int32_t{20'500}, std::int16_t{100}, std::int16_t{-200}, std::int16_t{0},
                  std::uint16_t{9000}),
             second);
    if (i % 20 == 10) {
      w.Packet(ground, 180, 52,
               Pack(kVehicleUs + std::uint64_t{boot_ms} * 1000, std::int32_t{-353'632'610},
                    std::int32_t{1'491'652'300}, 610.5f, 26.5f, 1.0f, 2.0f, 90.0f, 0.0f, std::uint16_t{7},
                    std::uint8_t{0}, std::uint8_t{0}, std::uint8_t{3}),
               second);
    }
    w.Packet(ground, 30, 39, Pack(boot_ms, 3.0f, 3.0f, 3.0f, 0.0f, 0.0f, 0.0f), second,
             200 + (i % 3 == 0 ? 1 : 2));
  }
  return w.bytes();
}

TEST(ParseMavlinkTlog, ReadsBothProtocolsAlike) {
  for (const bool second : {false, true}) {
    const Bytes bytes = Telemetry(second, true);
    ASSERT_TRUE(LooksLikeMavlinkTlog(bytes));
    const auto log = ValueOf(ParseMavlinkTlog("t.tlog", bytes));
    ASSERT_EQ(log.attitude.size(), 100u) << "one vehicle only";
    EXPECT_LT(NedFromYawPitchRoll(1.5, -0.2, 0.1).angularDistance(log.attitude[3].ned_from_body), 1e-6);
    EXPECT_DOUBLE_EQ(log.attitude[3].t_s, 60.75) << "the vehicle's clock, without the delay of the link";
    ASSERT_EQ(log.gnss.size(), 100u);
    EXPECT_NEAR(log.gnss[0].position.lat_deg, -35.363261, 1e-9);
    EXPECT_DOUBLE_EQ(*log.gnss[0].height_amsl_m, 584.0);
    EXPECT_DOUBLE_EQ(log.baro.at(0).height_above_takeoff_m, 20.5);
    EXPECT_EQ(log.message_counts.at("ATTITUDE"), 200u);
  }
}

TEST(ParseMavlinkTlog, PrefersTheVehiclesUtcToTheGroundStations) {
  const auto log = ValueOf(ParseMavlinkTlog("t.tlog", Telemetry(true, true)));
  EXPECT_EQ(log.utc_at_zero->time_since_epoch().count(), static_cast<std::int64_t>(kVehicleUs));
  EXPECT_LT(log.utc_sigma_s, 1.0);
  ASSERT_EQ(log.events.size(), 5u);
  EXPECT_NEAR(log.events[0].t_s, 62.5, 1e-6);
  EXPECT_TRUE(log.events[0].is_feedback);
  EXPECT_NEAR((*log.events[0].yaw_pitch_roll_rad)[0], geo::DegToRad(90.0), 1e-6);
}

TEST(ParseMavlinkTlog, SaysHowLittleItTrustsTheGroundStation) {
  const auto log = ValueOf(ParseMavlinkTlog("t.tlog", Telemetry(false, false)));
  ASSERT_TRUE(log.utc_at_zero.has_value());
  EXPECT_NEAR(
      static_cast<double>(log.utc_at_zero->time_since_epoch().count() - static_cast<std::int64_t>(kGroundUs)),
      1e5, 1e5);
  EXPECT_GE(log.utc_sigma_s, 5.0);
}

TEST(ParseMavlinkTlog, ReadsHowAGimbalHoldsItsCamera) {
  const Eigen::Quaterniond q = NedFromYawPitchRoll(0.5, -1.0, 0.0);
  // GIMBAL_DEVICE_FLAGS; the vehicle heads for 1.5 rad.
  const std::pair<std::uint16_t, double> frames[] = {{32, 2.0}, {0, 2.0}, {64, 0.5}, {16, 0.5}, {48, 2.0}};
  for (const auto& [flags, yaw_rad] : frames) {
    TlogWriter w;
    for (std::uint32_t i = 0; i < 10; ++i) {
      const std::uint32_t boot_ms = 60'000 + i * 250;
      const std::uint64_t ground = kGroundUs + std::uint64_t{boot_ms} * 1000;
      w.Packet(ground, 30, 39, Pack(boot_ms, 0.1f, -0.2f, 1.5f, 0.0f, 0.0f, 0.0f), true);
      // It was started two seconds ago.
      w.Packet(ground + 20'000, 285, 137,
               Pack(std::uint32_t{2000} + i * 250, static_cast<float>(q.w()), static_cast<float>(q.x()),
                    static_cast<float>(q.y()), static_cast<float>(q.z()), 0.0f, 0.0f, 0.0f, std::uint32_t{0},
                    flags, std::uint8_t{0}, std::uint8_t{0}),
               true);
    }
    const auto log = ValueOf(ParseMavlinkTlog("t.tlog", w.bytes()));
    ASSERT_EQ(log.gimbal.size(), 10u) << flags;
    EXPECT_NEAR(log.gimbal[3].t_s, 60.77, 1e-6);
    const auto expected = NedFromYawPitchRoll(yaw_rad, -1.0, 0.0);
    EXPECT_LT(expected.angularDistance(log.gimbal[3].ned_from_body), 1e-5) << flags;
  }
}

// Ten photos, turned so in turn, of a camera that was started so long after the vehicle, which is held at yaw
// 1.5, pitch -0.2. `earlier_ms`: before its packet, for each photo before.
Bytes AnnouncedPhotos(std::uint32_t started_ms, const std::vector<Eigen::Quaterniond>& turned,
                      std::int32_t above_takeoff_mm = 26'500, std::uint32_t earlier_ms = 0) {
  TlogWriter w;
  for (std::uint32_t i = 0; i < 10; ++i) {
    const Eigen::Quaterniond& q = turned[i % turned.size()];
    const std::uint32_t boot_ms = 60'000 + i * 250;
    const std::uint64_t ground = kGroundUs + std::uint64_t{boot_ms} * 1000;
    w.Packet(ground, 30, 39, Pack(boot_ms, 0.1f, -0.2f, 1.5f, 0.0f, 0.0f, 0.0f), true);
    w.Packet(ground + 20'000, 263, 133,
             Pack(std::uint64_t{0}, boot_ms - started_ms - i * earlier_ms, std::int32_t{-353'632'610},
                  std::int32_t{1'491'652'300}, std::int32_t{610'500}, above_takeoff_mm,
                  static_cast<float>(q.w()), static_cast<float>(q.x()), static_cast<float>(q.y()),
                  static_cast<float>(q.z()), static_cast<std::int32_t>(i), std::uint8_t{0}, std::int8_t{1}),
             true);
  }
  return w.bytes();
}

TEST(ParseMavlinkTlog, ACameraMayCountFromItsOwnStart) {
  for (const std::uint32_t started_ms : {0U, 58'000U}) {
    const auto log = ValueOf(
        ParseMavlinkTlog("t.tlog", AnnouncedPhotos(started_ms, {NedFromYawPitchRoll(1.5, -1.5, 0.0)})));
    ASSERT_EQ(log.events.size(), 10U) << started_ms;
    EXPECT_NEAR(log.events[3].t_s, 60.75, started_ms == 0 ? 1e-9 : 0.021) << started_ms;
  }
}

TEST(ParseMavlinkTlog, PhotosThatAreAnnouncedLaterOnLieAtTheirTimes) {
  const auto log = ValueOf(
      ParseMavlinkTlog("t.tlog", AnnouncedPhotos(0, {NedFromYawPitchRoll(1.5, -1.5, 0.0)}, 26'500, 6000)));
  ASSERT_EQ(log.events.size(), 10U);
  EXPECT_NEAR(log.events.front().t_s, 62.25 - 54.0, 1e-9);
  EXPECT_NEAR(log.events.back().t_s, 60.0, 1e-9);
}

TEST(ParseMavlinkTlog, PhotosWithTheVehiclesOwnAttitudeAreOfACameraFixedToIt) {
  const std::pair<double, AttitudeKind> kinds[] = {
      {-0.2, AttitudeKind::kAirframe}, {-0.7, AttitudeKind::kGimbal}, {-1.5, AttitudeKind::kGimbal}};
  for (const auto& [pitch_rad, kind] : kinds) {
    const auto log =
        ValueOf(ParseMavlinkTlog("t.tlog", AnnouncedPhotos(0, {NedFromYawPitchRoll(1.5, pitch_rad, 0.1)})));
    ASSERT_EQ(log.events.size(), 10U) << pitch_rad;
    EXPECT_TRUE(log.events[3].attitude_kind == kind) << pitch_rad;
    EXPECT_NEAR((*log.events[3].yaw_pitch_roll_rad)[1], pitch_rad, 1e-4);
  }
}

TEST(ParseMavlinkTlog, WhoseAttitudeItIsTheMostPhotosTell) {
  const auto own = NedFromYawPitchRoll(1.5, -0.2, 0.1);
  const auto of_turn = NedFromYawPitchRoll(2.0, -0.2, 0.4), down = NedFromYawPitchRoll(1.5, -1.5, 0.0);
  for (const auto& [usual, other, kind] :
       {std::tuple{own, of_turn, AttitudeKind::kAirframe}, {down, own, AttitudeKind::kGimbal}}) {
    const auto log =
        ValueOf(ParseMavlinkTlog("t.tlog", AnnouncedPhotos(0, {usual, usual, usual, usual, other})));
    ASSERT_EQ(log.events.size(), 10U);
    for (const CameraEvent& event : log.events) EXPECT_TRUE(event.attitude_kind == kind);
  }
}

TEST(ParseMavlinkTlog, AHeightThatPx4DoesNotKnowIsNone) {
  const auto q = NedFromYawPitchRoll(1.5, -0.2, 0.1);
  const auto known = ValueOf(ParseMavlinkTlog("t.tlog", AnnouncedPhotos(0, {q})));
  EXPECT_EQ(known.events.at(0).height_above_takeoff_m, 26.5);
  const auto unknown = ValueOf(ParseMavlinkTlog("t.tlog", AnnouncedPhotos(0, {q}, -1000)));
  EXPECT_FALSE(unknown.events.at(0).height_above_takeoff_m);
  EXPECT_EQ(unknown.events.at(0).height_amsl_m, 610.5);
}

TEST(ParseMavlinkTlog, SkipsPacketsWithAWrongChecksum) {
  Bytes bytes = Telemetry(true, true);
  bytes[bytes.size() / 2] ^= 0xFF;
  const auto log = ValueOf(ParseMavlinkTlog("t.tlog", bytes));
  std::uint64_t messages = 0;
  for (const auto& [name, count] : log.message_counts) messages += count;
  EXPECT_GE(messages, 503u);
  EXPECT_LE(messages, 504u);
  bool said = false;
  for (const auto& warning : InWords(log.warnings))
    said = said || warning.find("damaged") != std::string::npos;
  EXPECT_TRUE(said);
}

}  // namespace
}  // namespace skyquilt::flight
