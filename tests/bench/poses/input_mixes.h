// The mixes of inputs whose accuracy is measured: what a user may have brought, each as the smoother's input.
#pragma once

#include <array>
#include <string_view>

#include "tests/bench/poses/recorded_sensors.h"

namespace skyquilt::bench {

enum class InputMix {
  kImuStart,
  kImuBaroStartEnd,
  kGnssCourse,
  kGnssAttitudeBaro,  // what XMP holds: fixes at the photos only
  kGnssPoorCompassBaro,
  kGnssImuBaro,
  kGnssImuAttitudeBaro,
  kRtkAttitude,
  kRtkImu,
};

SensorErrors ErrorsOf(InputMix mix);
// The survey of the table. Where photos alone are the record, their camera hangs in a gimbal.
FlightPlan PlanOf(InputMix mix);
poses::SmootherInput InputOf(InputMix mix, const AnalyticFlight& flight, const RecordedSensors& sensors);

}  // namespace skyquilt::bench
