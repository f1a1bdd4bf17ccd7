#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "core/simulate/writers/write_logs.h"

namespace skyquilt::simulate {
namespace {

enum Topic : std::uint16_t { kSensor, kAttitude, kGps, kAir, kDistance, kCapture, kTrigger };

constexpr const char* kFormats[] = {
    "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
    "int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;uint32_t "
    "accelerometer_integral_dt;",
    "vehicle_attitude:uint64_t timestamp;uint64_t timestamp_sample;float[4] q;",
    "vehicle_gps_position:uint64_t timestamp;uint64_t time_utc_usec;double latitude_deg;double longitude_deg;"
    "double altitude_msl_m;double altitude_ellipsoid_m;float eph;float epv;float vel_n_m_s;float vel_e_m_s;"
    "float vel_d_m_s;uint8_t fix_type;bool vel_ned_valid;",
    "vehicle_air_data:uint64_t timestamp;uint64_t timestamp_sample;float baro_alt_meter;",
    "distance_sensor:uint64_t timestamp;float min_distance;float max_distance;float current_distance;"
    "uint8_t orientation;int8_t signal_quality;",
    "camera_capture:uint64_t timestamp;uint64_t timestamp_utc;double lat;double lon;float alt;float "
    "ground_distance;"
    "float[4] q;uint32_t seq;int8_t result;",
    "camera_trigger:uint64_t timestamp;uint64_t timestamp_utc;uint32_t seq;bool feedback;",
};

std::string TopicName(const char* format) {
  const std::string text(format);
  return text.substr(0, text.find(':'));
}

std::uint64_t Micros(double t_s) {
  return static_cast<std::uint64_t>(std::llround(std::max(0.0, t_s) * 1e6));
}

class UlogWriter {
 public:
  explicit UlogWriter(const flight::FlightLog& log) : utc_at_zero_(log.utc_at_zero) {
    file_.PutText(std::string_view("ULog\x01\x12\x35\x01", 8), 8).Put<std::uint64_t>(0);
    ByteWriter flags;
    flags.PutText("", 40);
    Message('B', flags);
    for (const char* format : kFormats) {
      ByteWriter body;
      body.PutText(format, std::string_view(format).size());
      Message('F', body);
    }
    for (std::uint16_t id = 0; id < static_cast<std::uint16_t>(std::size(kFormats)); ++id) {
      ByteWriter body;
      const std::string name = TopicName(kFormats[id]);
      body.Put<std::uint8_t>(0).Put(id).PutText(name, name.size());
      Message('A', body);
    }
  }

  void Take(const LogRecord& record) {
    known_.Take(record);
    std::visit([this](const auto* sample) { Write(*sample); }, record);
  }
  std::vector<std::uint8_t> Finish() { return std::move(file_.bytes()); }

 private:
  void Message(char type, ByteWriter& body) {
    file_.Put(static_cast<std::uint16_t>(body.bytes().size())).Put(static_cast<std::uint8_t>(type));
    file_.bytes().insert(file_.bytes().end(), body.bytes().begin(), body.bytes().end());
  }
  static ByteWriter Data(Topic topic, double t_s) {
    ByteWriter body;
    body.Put(static_cast<std::uint16_t>(topic)).Put(Micros(t_s));
    return body;
  }
  std::uint64_t UtcMicros(double t_s) const {
    if (!utc_at_zero_) return 0;
    return static_cast<std::uint64_t>(utc_at_zero_->time_since_epoch().count() + std::llround(t_s * 1e6));
  }
  static void PutVector(const Eigen::Vector3d& v, ByteWriter& body) {
    for (int i = 0; i < 3; ++i) body.Put(static_cast<float>(v[i]));
  }
  static void PutQuaternion(const Eigen::Quaterniond& q, ByteWriter& body) {
    for (const double v : {q.w(), q.x(), q.y(), q.z()}) body.Put(static_cast<float>(v));
  }

  void Write(const flight::ImuSample& s) {
    ByteWriter body = Data(kSensor, s.t_s);
    PutVector(s.angular_rate_radps, body);
    body.Put<std::uint32_t>(4000).Put<std::int32_t>(0);
    PutVector(s.specific_force_mps2, body);
    body.Put<std::uint32_t>(4000);
    Message('D', body);
  }
  void Write(const flight::AttitudeSample& s) {
    ByteWriter body = Data(kAttitude, s.t_s);
    body.Put(Micros(s.t_s));
    PutQuaternion(s.ned_from_body, body);
    Message('D', body);
  }
  void Write(const flight::GnssSample& s) {
    ByteWriter body = Data(kGps, s.t_s);
    body.Put(UtcMicros(s.t_s)).Put(s.position.lat_deg).Put(s.position.lon_deg);
    const double ellipsoid_m = s.height_ellipsoid_m.value_or(0.0);
    body.Put(s.height_amsl_m.value_or(std::numeric_limits<double>::quiet_NaN())).Put(ellipsoid_m);
    body.Put(static_cast<float>(s.sigma_horizontal_m.value_or(1.5)))
        .Put(static_cast<float>(s.sigma_vertical_m.value_or(3.0)));
    PutVector(s.velocity_in_ned_mps.value_or(Eigen::Vector3d::Zero()), body);
    body.Put<std::uint8_t>(s.is_rtk_fixed ? 6 : 3).Put<std::uint8_t>(s.velocity_in_ned_mps ? 1 : 0);
    Message('D', body);
  }
  void Write(const flight::BaroSample& s) {
    ByteWriter body = Data(kAir, s.t_s);
    body.Put(Micros(s.t_s)).Put(static_cast<float>(s.height_above_takeoff_m));
    Message('D', body);
  }
  void Write(const flight::RangeSample& s) {
    ByteWriter body = Data(kDistance, s.t_s);
    body.Put(0.1f)
        .Put(50.0f)
        .Put(static_cast<float>(s.distance_m))
        .Put<std::uint8_t>(25)
        .Put<std::int8_t>(100);
    Message('D', body);
  }
  void Write(const flight::CameraEvent& s) {
    const auto sequence = static_cast<std::uint32_t>(s.sequence.value_or(0));
    if (!s.is_feedback) {
      ByteWriter body = Data(kTrigger, s.t_s);
      body.Put(UtcMicros(s.t_s)).Put(sequence).Put<std::uint8_t>(0);
      Message('D', body);
      return;
    }
    constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();
    ByteWriter body = Data(kCapture, s.t_s);
    body.Put(UtcMicros(s.t_s));
    body.Put(known_.gnss ? known_.gnss->position.lat_deg : kAbsent)
        .Put(known_.gnss ? known_.gnss->position.lon_deg : kAbsent);
    body.Put(static_cast<float>(known_.gnss ? known_.gnss->height_amsl_m.value_or(kAbsent) : kAbsent));
    body.Put(static_cast<float>(kAbsent));
    if (known_.attitude != nullptr) {
      PutQuaternion(known_.attitude->ned_from_body, body);
    } else {
      for (int i = 0; i < 4; ++i) body.Put(static_cast<float>(kAbsent));
    }
    body.Put(sequence).Put<std::int8_t>(1);
    Message('D', body);
  }

  std::optional<flight::UtcTime> utc_at_zero_;
  AutopilotKnowledge known_;
  ByteWriter file_;
};

}  // namespace

std::vector<std::uint8_t> UlogBytes(const flight::FlightLog& log) {
  UlogWriter writer(log);
  for (const LogRecord& record : RecordsInTime(log)) writer.Take(record);
  return writer.Finish();
}

}  // namespace skyquilt::simulate
