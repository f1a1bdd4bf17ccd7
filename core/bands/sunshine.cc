#include "core/bands/sunshine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/base/median.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/metadata/xmp.h"

namespace skyquilt::bands {
namespace {

constexpr std::size_t kRecordBytes = 28;
constexpr std::size_t kMaxRecords = 4096;
constexpr std::array<double, 4> kGains = {1.0, 25.0, 428.0, 9876.0};
constexpr double kSaturatedCounts = 60'000.0;
constexpr double kLastSeconds = 2.0;

}  // namespace

std::optional<std::vector<SunshineRecord>> ReadIrradianceList(std::string_view text) {
  const auto bytes = flight::FromBase64(text, kRecordBytes * kMaxRecords);
  if (!bytes || bytes->size() < kRecordBytes) return std::nullopt;
  std::vector<SunshineRecord> records;
  // Padding may be missing: what is behind the last whole record is of no use.
  for (std::size_t at = 0; at + kRecordBytes <= bytes->size(); at += kRecordBytes) {
    const std::uint8_t* record = bytes->data() + at;
    const double time_s = 1e-6 * static_cast<double>(flight::LoadLittle<std::uint64_t>(record));
    const double counts = flight::LoadLittle<std::uint16_t>(record + 8);
    const std::size_t gain = flight::LoadLittle<std::uint16_t>(record + 12);
    const double integration_ms = flight::LoadLittle<std::uint16_t>(record + 14);
    if (gain >= kGains.size() || !(integration_ms > 0.0) || counts >= kSaturatedCounts || counts <= 0.0)
      continue;
    records.push_back({time_s, counts / integration_ms / kGains[gain]});
  }
  if (records.empty()) return std::nullopt;
  return records;
}

std::optional<double> CalibrationCounts(std::string_view text) {
  constexpr std::size_t kNumbersAGain = 4;
  const auto numbers = flight::AllXmpNumbers(text);
  if (!numbers || numbers->size() % kNumbersAGain != 0) return std::nullopt;
  std::optional<double> best;
  double best_gain = 0.0;
  for (std::size_t at = 0; at < numbers->size(); at += kNumbersAGain) {
    const double index = (*numbers)[at], integration_ms = (*numbers)[at + 1], counts = (*numbers)[at + 2];
    if (!(index >= 0.0) || !(index < static_cast<double>(kGains.size())) || index != std::floor(index))
      continue;
    if (!(integration_ms > 0.0) || !(counts > 0.0) || counts >= kSaturatedCounts) continue;
    const double gain = kGains[static_cast<std::size_t>(index)];
    if (gain < best_gain) continue;
    best_gain = gain;
    best = counts / integration_ms / gain;
  }
  return best;
}

double LastCounts(const std::vector<SunshineRecord>& records) {
  double last_s = 0.0;
  for (const SunshineRecord& record : records) last_s = std::max(last_s, record.time_s);
  std::vector<double> counts;
  for (const SunshineRecord& record : records) {
    if (record.time_s >= last_s - kLastSeconds) counts.push_back(record.counts_per_ms);
  }
  return Median(std::move(counts));
}

}  // namespace skyquilt::bands
