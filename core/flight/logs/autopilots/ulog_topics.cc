#include "core/flight/logs/autopilots/ulog_topics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace skyquilt::flight {
namespace {

constexpr std::size_t kMaxSpare = 1'000'000;

using Field = std::optional<UlogField>;

std::optional<double> Get(const Field& field, LogBytes payload, std::size_t index = 0) {
  if (!field) return std::nullopt;
  const auto value = UlogNumber(*field, payload, index);
  if (!value || !std::isfinite(*value)) return std::nullopt;
  return value;
}

template <int kSize = 3>
std::optional<Eigen::Matrix<double, kSize, 1>> GetVector(const Field& field, LogBytes payload) {
  Eigen::Matrix<double, kSize, 1> vector;
  for (int i = 0; i < kSize; ++i) {
    const auto number = Get(field, payload, static_cast<std::size_t>(i));
    if (!number) return std::nullopt;
    vector[i] = *number;
  }
  return vector;
}

std::optional<Eigen::Quaterniond> GetQuaternion(const Field& field, LogBytes payload) {
  const auto wxyz = GetVector<4>(field, payload);
  if (!wxyz) return std::nullopt;
  const Eigen::Quaterniond q((*wxyz)[0], (*wxyz)[1], (*wxyz)[2], (*wxyz)[3]);
  if (!(q.norm() > 0.5)) return std::nullopt;
  return q.normalized();
}

struct Stamp {
  Field timestamp;
  Field sample;
  // The time of measurement where it is written, else of publication.
  std::optional<double> Seconds(LogBytes payload) const {
    const auto measured = Get(sample, payload);
    if (measured && *measured > 0.0) return *measured * 1e-6;
    const auto published = Get(timestamp, payload);
    if (!published) return std::nullopt;
    return *published * 1e-6;
  }
};

std::optional<UtcTime> UtcFromUnixUs(std::optional<double> unix_us) {
  if (!unix_us || *unix_us < 9e14 || *unix_us > 7e15) return std::nullopt;  // 1998 to 2191
  return UtcTime(std::chrono::microseconds(std::llround(*unix_us)));
}

// The camera's attitude is the gimbal's where there is one, then of all photos: an airframe does not fly at
// -45 deg of pitch, though it may fall so.
void TellGimbal(std::vector<CameraEvent>& events) {
  constexpr std::ptrdiff_t kOneIn = 10;
  const auto is_turned = [](const CameraEvent& event) { return event.yaw_pitch_roll_rad.has_value(); };
  const auto looks_down = [](const CameraEvent& event) {
    return event.yaw_pitch_roll_rad && event.yaw_pitch_roll_rad->y() < geo::DegToRad(-45.0);
  };
  const auto down = std::count_if(events.begin(), events.end(), looks_down);
  const bool has_gimbal = down > 0 && kOneIn * down >= std::count_if(events.begin(), events.end(), is_turned);
  for (CameraEvent& event : events)
    event.attitude_kind = has_gimbal || looks_down(event) ? AttitudeKind::kGimbal : AttitudeKind::kAirframe;
}

}  // namespace

struct UlogReaders {
  struct Base : UlogTopics::Reader {
    UlogTopics& topics;
    UlogTypes& types;
    std::string topic;
    Stamp stamp;
    Base(UlogTopics& t, UlogTypes& y, std::string_view name) : topics(t), types(y), topic(name) {
      stamp = {Find("timestamp"), Find("timestamp_sample")};
    }
    Field Find(std::string_view name) { return types.Find(topic, name); }
    Field FindEither(std::string_view name, std::string_view other) {
      const Field field = Find(name);
      return field ? field : Find(other);
    }
    LogBuilder& builder() const { return topics.builder_; }
  };

  struct SensorCombined final : Base {
    Field gyro = Find("gyro_rad"), accel = Find("accelerometer_m_s2");
    Field gyro_clips = Find("gyro_clipping"), accel_clips = Find("accelerometer_clipping");
    using Base::Base;
    void Take(LogBytes payload) override {
      const auto t_s = stamp.Seconds(payload);
      const auto rate = GetVector(gyro, payload);
      const auto force = GetVector(accel, payload);
      if (Get(gyro_clips, payload).value_or(0.0) != 0.0 || Get(accel_clips, payload).value_or(0.0) != 0.0) {
        ++topics.clipped_;
      }
      if (t_s && rate && force) builder().Add(ImuSample{*t_s, *rate, *force});
    }
  };

  struct VehicleImu final : Base {
    Field angle = Find("delta_angle"), velocity = Find("delta_velocity");
    Field angle_us = Find("delta_angle_dt"), velocity_us = Find("delta_velocity_dt");
    using Base::Base;
    void Take(LogBytes payload) override {
      const auto t_s = stamp.Seconds(payload);
      const auto d_angle = GetVector(angle, payload);
      const auto d_velocity = GetVector(velocity, payload);
      const double angle_s = Get(angle_us, payload).value_or(0.0) * 1e-6;
      const double velocity_s = Get(velocity_us, payload).value_or(0.0) * 1e-6;
      if (!t_s || !d_angle || !d_velocity || angle_s <= 0.0 || velocity_s <= 0.0) return;
      if (topics.vehicle_imu_.size() >= kMaxSpare || builder().imu_count() > 0) return;
      topics.vehicle_imu_.push_back({*t_s - 0.5 * angle_s, *d_angle / angle_s, *d_velocity / velocity_s});
    }
  };

  struct Attitude final : Base {
    Field q = Find("q");
    using Base::Base;
    void Take(LogBytes payload) override {
      const auto t_s = stamp.Seconds(payload);
      const auto ned_from_body = GetQuaternion(q, payload);
      if (!t_s || !ned_from_body) return;
      topics.heading_rad_ = YawPitchRollFromNed(*ned_from_body)[0];
      builder().Add(AttitudeSample{*t_s, *ned_from_body});
    }
  };

  struct Gimbal final : Base {
    Field q = Find("q"), flags = Find("device_flags"), measured = Find("received_from_mavlink");
    using Base::Base;
    void Take(LogBytes payload) override {
      const auto t_s = stamp.Seconds(payload);
      const auto attitude = GetQuaternion(q, payload);
      // What the autopilot itself sends to servos is no measurement.
      if (!t_s || !attitude || Get(measured, payload).value_or(1.0) == 0.0) return;
      const auto ned_from_gimbal = NedFromGimbalDevice(
          *attitude, static_cast<unsigned>(Get(flags, payload).value_or(0.0)), topics.heading_rad_);
      if (ned_from_gimbal) builder().AddGimbal({*t_s, *ned_from_gimbal});
    }
  };

  struct Gps final : Base {
    bool is_spare = topic == "sensor_gps";
    Field lat = FindEither("latitude_deg", "lat"), lon = FindEither("longitude_deg", "lon");
    Field amsl = FindEither("altitude_msl_m", "alt"),
          ellipsoid = FindEither("altitude_ellipsoid_m", "alt_ellipsoid");
    Field eph = Find("eph"), epv = Find("epv"), fix = Find("fix_type"), utc = Find("time_utc_usec");
    Field north = Find("vel_n_m_s"), east = Find("vel_e_m_s"), down = Find("vel_d_m_s"),
          ned_valid = Find("vel_ned_valid");
    using Base::Base;
    static double Scale(const Field& field, double integer_unit) {
      return field && field->type->name == "double" ? 1.0 : integer_unit;
    }
    void Take(LogBytes payload) override {
      const auto t_s = stamp.Seconds(payload);
      const auto lat_raw = Get(lat, payload);
      const auto lon_raw = Get(lon, payload);
      const double fix_type = Get(fix, payload).value_or(3.0);
      if (!t_s || !lat_raw || !lon_raw) return;
      const auto time_utc = UtcFromUnixUs(Get(utc, payload));
      if (time_utc && fix_type >= 2.0) topics.clock_.Add(*t_s, *time_utc);
      if (fix_type < 3.0) return;
      GnssSample sample;
      sample.t_s = *t_s;
      sample.position = {*lat_raw * Scale(lat, 1e-7), *lon_raw * Scale(lon, 1e-7)};
      if (const auto h = Get(amsl, payload)) sample.height_amsl_m = *h * Scale(amsl, 1e-3);
      if (const auto h = Get(ellipsoid, payload)) {
        if (*h != 0.0) sample.height_ellipsoid_m = *h * Scale(ellipsoid, 1e-3);
      }
      sample.sigma_horizontal_m = Get(eph, payload);
      sample.sigma_vertical_m = Get(epv, payload);
      const auto n = Get(north, payload);
      const auto e = Get(east, payload);
      const auto d = Get(down, payload);
      if (n && e && d && Get(ned_valid, payload).value_or(1.0) != 0.0)
        sample.velocity_in_ned_mps = Eigen::Vector3d(*n, *e, *d);
      sample.is_rtk_fixed = fix_type == 6.0;
      if (!is_spare) {
        builder().Add(sample);
      } else if (topics.sensor_gps_.size() < kMaxSpare) {
        topics.sensor_gps_.push_back(sample);
      }
    }
  };

  struct Baro final : Base {
    Field height = FindEither("baro_alt_meter", "altitude"),
          pressure = FindEither("baro_pressure_pa", "pressure");
    using Base::Base;
    void Take(LogBytes payload) override {
      const auto t_s = stamp.Seconds(payload);
      auto height_m = Get(height, payload);
      if (!height_m) {
        const auto p = Get(pressure, payload);
        // Old drivers wrote hectopascal.
        if (p && *p > 0.0) height_m = StandardHeightM(*p < 2000.0 ? *p * 100.0 : *p);
      }
      if (!t_s || !height_m) return;
      if (topic == "vehicle_air_data") {
        builder().Add(BaroSample{*t_s, *height_m});
      } else if (topics.sensor_baro_.size() < kMaxSpare && builder().baro_count() == 0) {
        topics.sensor_baro_.push_back({*t_s, *height_m});
      }
    }
  };

  struct Range final : Base {
    Field distance = Find("current_distance"), least = Find("min_distance"), most = Find("max_distance");
    Field orientation = Find("orientation"), quality = Find("signal_quality");
    using Base::Base;
    void Take(LogBytes payload) override {
      constexpr double kDownward = 25.0;
      const auto t_s = stamp.Seconds(payload);
      const auto distance_m = Get(distance, payload);
      if (!t_s || !distance_m || Get(orientation, payload).value_or(kDownward) != kDownward) return;
      if (Get(quality, payload).value_or(-1.0) == 0.0 || *distance_m <= 0.0) return;
      if (*distance_m < Get(least, payload).value_or(0.0)) return;
      const double max_m = Get(most, payload).value_or(0.0);
      if (max_m > 0.0 && *distance_m >= max_m) return;
      builder().Add(RangeSample{*t_s, *distance_m});
    }
  };

  struct Camera final : Base {
    bool is_capture = topic == "camera_capture";
    Field utc = Find("timestamp_utc"), sequence = Find("seq"), lat = Find("lat"), lon = Find("lon"),
          amsl = Find("alt");
    Field ground = Find("ground_distance"), q = Find("q"), result = Find("result"),
          feedback = Find("feedback");
    using Base::Base;
    void Take(LogBytes payload) override {
      const auto t_us = Get(stamp.timestamp, payload);
      if (!t_us || Get(result, payload).value_or(1.0) == 0.0) return;
      CameraEvent event;
      event.t_s = *t_us * 1e-6;
      event.is_feedback = is_capture || Get(feedback, payload).value_or(0.0) != 0.0;
      if (const auto number = Get(sequence, payload)) event.sequence = std::llround(*number);
      const auto lat_deg = Get(lat, payload);
      const auto lon_deg = Get(lon, payload);
      if (lat_deg && lon_deg) event.position = geo::LatLon{*lat_deg, *lon_deg};
      event.height_amsl_m = Get(amsl, payload);
      if (const auto above = Get(ground, payload); above && *above > 0.0)
        event.height_above_ground_m = *above;
      if (const auto attitude = GetQuaternion(q, payload))
        event.yaw_pitch_roll_rad = YawPitchRollFromNed(*attitude);
      if (const auto time_utc = UtcFromUnixUs(Get(utc, payload))) topics.clock_.Add(event.t_s, *time_utc);
      if (is_capture) {
        builder().Add(event);
      } else if (topics.triggers_.size() < kMaxSpare) {
        topics.triggers_.push_back(event);
      }
    }
  };
};

std::unique_ptr<UlogTopics::Reader> UlogTopics::MakeReader(UlogTypes& types, std::string_view topic) {
  const auto has = [&](std::string_view field) { return types.Find(topic, field).has_value(); };
  if (!has("timestamp")) return nullptr;
  if (topic == "sensor_combined" && has("gyro_rad"))
    return std::make_unique<UlogReaders::SensorCombined>(*this, types, topic);
  if (topic == "vehicle_imu" && has("delta_angle"))
    return std::make_unique<UlogReaders::VehicleImu>(*this, types, topic);
  if (topic == "vehicle_attitude" && has("q"))
    return std::make_unique<UlogReaders::Attitude>(*this, types, topic);
  if (topic == "gimbal_device_attitude_status" && has("q"))
    return std::make_unique<UlogReaders::Gimbal>(*this, types, topic);
  if (topic == "vehicle_gps_position" || topic == "sensor_gps") {
    return std::make_unique<UlogReaders::Gps>(*this, types, topic);
  }
  if (topic == "vehicle_air_data" || topic == "sensor_baro")
    return std::make_unique<UlogReaders::Baro>(*this, types, topic);
  if (topic == "distance_sensor") return std::make_unique<UlogReaders::Range>(*this, types, topic);
  if (topic == "camera_capture" || topic == "camera_trigger") {
    return std::make_unique<UlogReaders::Camera>(*this, types, topic);
  }
  return nullptr;
}

void UlogTopics::Finish() {
  const auto add_spare = [&](std::size_t count, const auto& samples) {
    if (count > 0) return;
    for (const auto& sample : samples) builder_.Add(sample);
  };
  add_spare(builder_.imu_count(), vehicle_imu_);
  add_spare(builder_.gnss_count(), sensor_gps_);
  add_spare(builder_.baro_count(), sensor_baro_);
  if (builder_.event_count() == 0) {
    const bool any_feedback =
        std::any_of(triggers_.begin(), triggers_.end(), [](const auto& e) { return e.is_feedback; });
    for (const CameraEvent& event : triggers_) {
      if (event.is_feedback || !any_feedback) builder_.Add(event);
    }
  }
  TellGimbal(builder_.log().events);
  builder_.BaroStartsAtZero();
  if (clipped_ > 0) builder_.Warn({RemarkCode::kImuClipped, {{"samples", clipped_}}});
  if (const auto fit = clock_.Solve()) {
    builder_.log().utc_at_zero = fit->utc_at_zero;
    // GPS solutions arrive 0.05 to 0.25 s late, which the scatter does not show.
    builder_.log().utc_sigma_s = std::hypot(0.15, fit->scatter_s);
  }
}

}  // namespace skyquilt::flight
