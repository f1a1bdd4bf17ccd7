#include <cmath>
#include <optional>

#include "core/base/check.h"
#include "core/simulate/writers/write_logs.h"

namespace skyquilt::simulate {
namespace {

constexpr std::uint8_t kFmt = 128;
constexpr double kTriggerDelayS = 0.05;
constexpr std::int64_t kGpsEpochUnixS = 315964800;
constexpr std::int64_t kLeapSeconds = 18;
constexpr std::int64_t kWeekMs = 7LL * 86400 * 1000;

struct Layout {
  std::uint8_t type;
  const char* name;
  const char* codes;
  const char* labels;
};

constexpr Layout kLayouts[] = {
    {129, "IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"},
    {130, "ATT", "QccccCC", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"},
    {131, "GPS", "QBBIHBcLLeffffB", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U"},
    {132, "GPA", "QBCCCC", "TimeUS,I,VDop,HAcc,VAcc,SAcc"},
    {133, "BARO", "QBff", "TimeUS,I,Alt,Press"},
    {134, "RFND", "QBCBB", "TimeUS,Instance,Dist,Stat,Orient"},
    {135, "TRIG", "QBHIHLLeeeccC", "TimeUS,I,Img,GPSTime,GPSWeek,Lat,Lng,Alt,RelAlt,GPSAlt,R,P,Y"},
    {136, "CAM", "QBHIHLLeeeccC", "TimeUS,I,Img,GPSTime,GPSWeek,Lat,Lng,Alt,RelAlt,GPSAlt,R,P,Y"},
};

std::size_t SizeOf(char code) {
  switch (code) {
    case 'B':
      return 1;
    case 'H':
    case 'c':
    case 'C':
      return 2;
    case 'I':
    case 'L':
    case 'e':
    case 'f':
      return 4;
    case 'Q':
      return 8;
    default:
      SKYQUILT_CHECK(false, "an unknown DataFlash code");
      return 0;
  }
}

std::int16_t Centi16(double v) { return static_cast<std::int16_t>(std::lround(100.0 * v)); }
std::uint16_t CentiU16(double v) { return static_cast<std::uint16_t>(std::lround(100.0 * v)); }
std::int32_t Centi32(double v) { return static_cast<std::int32_t>(std::lround(100.0 * v)); }
std::int32_t Degrees7(double deg) { return static_cast<std::int32_t>(std::llround(1e7 * deg)); }

double HeightAmslM(const flight::GnssSample& gnss) {
  return gnss.height_amsl_m ? *gnss.height_amsl_m : gnss.height_ellipsoid_m.value_or(0.0);
}

struct Angles {
  double yaw_deg = 0.0, pitch_deg = 0.0, roll_deg = 0.0;
};

Angles AnglesOf(const Eigen::Quaterniond& ned_from_body) {
  const Eigen::Matrix3d m = ned_from_body.toRotationMatrix();
  double yaw_deg = geo::RadToDeg(std::atan2(m(1, 0), m(0, 0)));
  if (yaw_deg < 0.0) yaw_deg += 360.0;
  return {yaw_deg, geo::RadToDeg(std::asin(std::clamp(-m(2, 0), -1.0, 1.0))),
          geo::RadToDeg(std::atan2(m(2, 1), m(2, 2)))};
}

class DataflashWriter {
 public:
  explicit DataflashWriter(const flight::FlightLog& log) : utc_at_zero_(log.utc_at_zero) {
    PutFormat({kFmt, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"}, 89);
    for (const Layout& layout : kLayouts) {
      std::size_t length = 3;
      for (const char* code = layout.codes; *code != 0; ++code) length += SizeOf(*code);
      PutFormat(layout, static_cast<std::uint8_t>(length));
    }
  }

  void Take(const LogRecord& record) {
    known_.Take(record);
    std::visit([this](const auto* sample) { Write(*sample); }, record);
  }
  std::vector<std::uint8_t> Finish() { return std::move(out_.bytes()); }

 private:
  void PutFormat(const Layout& layout, std::uint8_t length) {
    Head(kFmt)
        .Put(layout.type)
        .Put(length)
        .PutText(layout.name, 4)
        .PutText(layout.codes, 16)
        .PutText(layout.labels, 64);
  }
  ByteWriter& Head(std::uint8_t type) {
    return out_.Put<std::uint8_t>(0xA3).Put<std::uint8_t>(0x95).Put(type);
  }
  ByteWriter& Head(std::uint8_t type, double t_s) {
    return Head(type).Put(static_cast<std::uint64_t>(std::llround(std::max(0.0, t_s) * 1e6)));
  }
  // Milliseconds of the GPS week and the week; zeros without a clock.
  std::pair<std::uint32_t, std::uint16_t> GpsTime(double t_s) const {
    if (!utc_at_zero_) return {0, 0};
    const std::int64_t unix_ms =
        std::llround(static_cast<double>(utc_at_zero_->time_since_epoch().count()) / 1e3 + t_s * 1e3);
    const std::int64_t gps_ms = unix_ms + (kLeapSeconds - kGpsEpochUnixS) * 1000;
    return {static_cast<std::uint32_t>(gps_ms % kWeekMs), static_cast<std::uint16_t>(gps_ms / kWeekMs)};
  }

  void Write(const flight::ImuSample& s) {
    Head(129, s.t_s).Put<std::uint8_t>(0);
    for (int i = 0; i < 3; ++i) out_.Put(static_cast<float>(s.angular_rate_radps[i]));
    for (int i = 0; i < 3; ++i) out_.Put(static_cast<float>(s.specific_force_mps2[i]));
  }
  void Write(const flight::AttitudeSample& s) {
    const Angles a = AnglesOf(s.ned_from_body);
    Head(130, s.t_s)
        .Put(Centi16(a.roll_deg))
        .Put(Centi16(a.roll_deg))
        .Put(Centi16(a.pitch_deg))
        .Put(Centi16(a.pitch_deg));
    out_.Put(CentiU16(a.yaw_deg)).Put(CentiU16(a.yaw_deg));
  }
  void Write(const flight::GnssSample& s) {
    const auto [tow_ms, week] = GpsTime(s.t_s);
    const Eigen::Vector3d v = s.velocity_in_ned_mps.value_or(Eigen::Vector3d::Zero());
    double course_deg = geo::RadToDeg(std::atan2(v.y(), v.x()));
    if (course_deg < 0.0) course_deg += 360.0;
    Head(131, s.t_s).Put<std::uint8_t>(0).Put<std::uint8_t>(s.is_rtk_fixed ? 6 : 3).Put(tow_ms).Put(week);
    out_.Put<std::uint8_t>(17)
        .Put(Centi16(0.8))
        .Put(Degrees7(s.position.lat_deg))
        .Put(Degrees7(s.position.lon_deg));
    out_.Put(Centi32(HeightAmslM(s)))
        .Put(static_cast<float>(v.head<2>().norm()))
        .Put(static_cast<float>(course_deg));
    out_.Put(static_cast<float>(v.z())).Put(0.0f).Put<std::uint8_t>(1);
    Head(132, s.t_s)
        .Put<std::uint8_t>(0)
        .Put(CentiU16(1.2))
        .Put(CentiU16(s.sigma_horizontal_m.value_or(1.5)));
    out_.Put(CentiU16(s.sigma_vertical_m.value_or(3.0))).Put(CentiU16(0.1));
  }
  void Write(const flight::BaroSample& s) {
    const double pressure_pa = 101325.0 * std::pow(1.0 - 2.25577e-5 * s.height_above_takeoff_m, 5.25588);
    Head(133, s.t_s).Put<std::uint8_t>(0).Put(static_cast<float>(s.height_above_takeoff_m));
    out_.Put(static_cast<float>(pressure_pa));
  }
  void Write(const flight::RangeSample& s) {
    Head(134, s.t_s)
        .Put<std::uint8_t>(0)
        .Put(CentiU16(s.distance_m))
        .Put<std::uint8_t>(4)
        .Put<std::uint8_t>(25);
  }
  void Write(const flight::CameraEvent& s) {
    // With a shutter feedback the log holds the command as TRIG and the shutter as CAM; else CAM is the
    // command.
    if (s.is_feedback) WriteCamera(135, s.t_s - kTriggerDelayS, s);
    WriteCamera(136, s.t_s, s);
  }
  void WriteCamera(std::uint8_t type, double t_s, const flight::CameraEvent& s) {
    const auto [tow_ms, week] = GpsTime(t_s);
    Head(type, t_s)
        .Put<std::uint8_t>(0)
        .Put(static_cast<std::uint16_t>(s.sequence.value_or(0)))
        .Put(tow_ms)
        .Put(week);
    const bool has_fix = known_.gnss != nullptr;
    out_.Put(has_fix ? Degrees7(known_.gnss->position.lat_deg) : 0)
        .Put(has_fix ? Degrees7(known_.gnss->position.lon_deg) : 0);
    const std::int32_t alt = has_fix ? Centi32(HeightAmslM(*known_.gnss)) : 0;
    const double above_m = known_.baro != nullptr ? known_.baro->height_above_takeoff_m : 0.0;
    out_.Put(alt).Put(Centi32(above_m)).Put(alt);
    const Angles a = known_.attitude != nullptr ? AnglesOf(known_.attitude->ned_from_body) : Angles{};
    out_.Put(Centi16(a.roll_deg)).Put(Centi16(a.pitch_deg)).Put(CentiU16(a.yaw_deg));
  }

  std::optional<flight::UtcTime> utc_at_zero_;
  AutopilotKnowledge known_;
  ByteWriter out_;
};

}  // namespace

std::vector<std::uint8_t> DataflashBytes(const flight::FlightLog& log) {
  DataflashWriter writer(log);
  for (const LogRecord& record : RecordsInTime(log)) writer.Take(record);
  return writer.Finish();
}

}  // namespace skyquilt::simulate
