#include "core/pipeline/report/capture_span.h"

#include <fmt/chrono.h>
#include <fmt/core.h>

#include <cstdlib>

namespace skyquilt::pipeline {
namespace {

std::string Seconds(flight::UtcTime time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}", fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)));
}

std::string Written(flight::UtcTime time, bool is_local, std::optional<std::chrono::minutes> zone) {
  if (is_local) return Seconds(time);
  if (!zone) return Seconds(time) + "Z";
  const long minutes = std::labs(zone->count());
  return fmt::format("{}{}{:02}:{:02}", Seconds(time + *zone), zone->count() < 0 ? '-' : '+', minutes / 60,
                     minutes % 60);
}

}  // namespace

std::optional<CaptureSpan> CaptureSpanOf(const std::vector<const flight::Photo*>& photos) {
  const flight::Photo* first = nullptr;
  const flight::Photo* last = nullptr;
  const flight::Photo* zoned = nullptr;  // the first that knows its zone: it is the flight's
  for (const flight::Photo* photo : photos) {
    if (!photo->captured_at) continue;
    if (first != nullptr && photo->captured_at_is_local != first->captured_at_is_local) {
      if (photo->captured_at_is_local) continue;
      first = last = nullptr;
    }
    if (first == nullptr || *photo->captured_at < *first->captured_at) first = photo;
    if (last == nullptr || *photo->captured_at > *last->captured_at) last = photo;
    if (photo->clock_minus_utc && (zoned == nullptr || *photo->captured_at < *zoned->captured_at))
      zoned = photo;
  }
  if (first == nullptr) return std::nullopt;
  const bool is_local = first->captured_at_is_local;
  const auto zone = zoned != nullptr ? zoned->clock_minus_utc : std::nullopt;
  return CaptureSpan{Written(*first->captured_at, is_local, zone),
                     Written(*last->captured_at, is_local, zone)};
}

}  // namespace skyquilt::pipeline
