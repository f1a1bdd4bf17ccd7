// What the topics of a ULog mean for a FlightLog: one reader per topic, with the fields it needs looked up
// once, at subscription. One thread.
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/autopilots/ulog_types.h"
#include "core/flight/logs/log_builder.h"

namespace skyquilt::flight {

class UlogTopics {
 public:
  explicit UlogTopics(LogBuilder& builder) : builder_(builder) {}

  // Reads one message of a subscribed topic.
  class Reader {
   public:
    virtual ~Reader() = default;
    virtual void Take(LogBytes payload) = 0;
  };
  // Nothing for a topic we do not read or that lacks the fields we need.
  std::unique_ptr<Reader> MakeReader(UlogTypes& types, std::string_view topic);

  // Chooses among sources of the same thing and fills the clock.
  void Finish();

 private:
  friend struct UlogReaders;
  LogBuilder& builder_;
  ClockPairs clock_;
  std::uint64_t clipped_ = 0;
  std::optional<double> heading_rad_;    // of the vehicle, by its last attitude
  std::vector<ImuSample> vehicle_imu_;   // used where sensor_combined is absent
  std::vector<GnssSample> sensor_gps_;   // used where vehicle_gps_position is absent
  std::vector<BaroSample> sensor_baro_;  // used where vehicle_air_data is absent
  std::vector<CameraEvent> triggers_;    // used where camera_capture is absent
};

}  // namespace skyquilt::flight
