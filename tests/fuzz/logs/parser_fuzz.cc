// One fuzz target a parser: SKYQUILT_FUZZ_PARSER names it. Whatever the bytes are, the parser must answer,
// and a log it gives must keep the promises of flight_log.h.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "core/flight/logs/formats.h"
#include "core/flight/logs/read_log.h"
#include "core/flight/logs/texts/gcp_list.h"

namespace {

void Require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

template <typename Samples>
void RequireRisingTimes(const Samples& samples) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    Require(std::isfinite(samples[i].t_s), "finite times");
    Require(i == 0 || samples[i].t_s >= samples[i - 1].t_s, "rising times");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto result = skyquilt::flight::SKYQUILT_FUZZ_PARSER("fuzz", {data, size});
  if (!result) {
    Require(!result.error().message.empty(), "an error says what is wrong");
    return 0;
  }
#ifndef SKYQUILT_FUZZ_NOT_A_LOG
  RequireRisingTimes(result->imu);
  RequireRisingTimes(result->attitude);
  RequireRisingTimes(result->gimbal);
  RequireRisingTimes(result->gnss);
  RequireRisingTimes(result->baro);
  RequireRisingTimes(result->range);
  RequireRisingTimes(result->events);
#endif
  return 0;
}
