#include "core/poses/evidence/records_apart.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/base/median.h"

namespace skyquilt::poses {
namespace {

constexpr double kRefutingSigmas = 5.0;
// With corrections: frames of survey and base may lie decimetres apart, antennas are no cameras.
constexpr double kMinCorrectedM = 0.5;
constexpr double kMinPlainM = 15.0;  // what a receiver below trees or in a street may be off by for a flight
constexpr std::size_t kMinRecords = 3;

}  // namespace

RecordsApart AgainstRecords(const Eigen::Vector2d& apart_m, const CommonError& common) {
  RecordsApart apart;
  apart.apart_m = apart_m;
  apart.refuting_m = kRefutingSigmas * common.sigma_m;
  if (common.is_corrected) apart.refuting_m = std::max(kMinCorrectedM, apart.refuting_m);
  apart.agreed_m = common.is_corrected ? apart.refuting_m : std::max(kMinPlainM, apart.refuting_m);
  return apart;
}

std::optional<RecordsApart> RecordsApartOf(const std::vector<RecordedResidual>& residuals) {
  const auto place_of = [](const RecordedResidual& one) {
    return std::pair(one.record->position.lat_deg, one.record->position.lon_deg);
  };
  std::map<std::pair<double, double>, int> at_place;
  for (const RecordedResidual& one : residuals) ++at_place[place_of(one)];
  std::vector<Eigen::Vector2d> apart_m;
  std::vector<const flight::RecordedPosition*> records;
  for (const RecordedResidual& one : residuals) {
    const bool is_repeated = one.record->is_repeated || at_place[place_of(one)] > kMaxAtOnePlace;
    if (is_repeated || !one.residual_m.allFinite()) continue;
    apart_m.push_back(one.residual_m);
    records.push_back(one.record);
  }
  if (records.size() < kMinRecords) return std::nullopt;
  return AgainstRecords(MedianByAxis(apart_m), CommonErrorOf(records));
}

}  // namespace skyquilt::poses
