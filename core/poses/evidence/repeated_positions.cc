#include "core/poses/evidence/repeated_positions.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <utility>

#include "core/base/median.h"
#include "core/geo/geodesic.h"

namespace skyquilt::poses {
namespace {

using flight::Photo;

// Where no times say that moments differ: two may be one picture twice.
constexpr std::size_t kOneMoment = 2;

// Photos of one camera, one after the other at one and the same place.
using Stay = std::vector<Photo*>;

bool IsSamePlace(const geo::LatLon& a, const geo::LatLon& b) {
  return a.lat_deg == b.lat_deg && a.lon_deg == b.lon_deg;
}

std::map<std::string, std::vector<Stay>> StaysOfCameras(std::vector<Photo>& photos) {
  std::map<std::string, std::vector<Stay>> of_camera;
  for (Photo& photo : photos) {
    if (!photo.position) continue;
    std::vector<Stay>& stays = of_camera[photo.camera_key];
    const bool is_same =
        !stays.empty() && IsSamePlace(stays.back().front()->position->position, photo.position->position);
    if (!is_same) stays.emplace_back();
    stays.back().push_back(&photo);
  }
  return of_camera;
}

double ApartM(const Stay& a, const Stay& b) {
  return geo::MetresApart(a.front()->position->position, b.front()->position->position);
}

// From one photo to the next, as most of the flight has it.
double UsualStepM(const std::vector<Stay>& stays) {
  std::vector<double> steps_m;
  for (std::size_t s = 0; s + 1 < stays.size(); ++s)
    steps_m.push_back(ApartM(stays[s], stays[s + 1]) / static_cast<double>(stays[s].size()));
  return MedianIfAny(std::move(steps_m)).value_or(0.0);
}

bool IsRepeat(const Stay& stay, const Photo& photo) {
  const auto& first = stay.front()->captured_at;
  if (first && photo.captured_at) return *photo.captured_at > *first;
  return &photo != stay.front() && stay.size() > kOneMoment;
}

// `next`: null at the end of the flight, where nothing says which way it went on.
int MoveOn(const Stay& stay, const Stay* next, double step_m) {
  int moved = 0;
  const geo::LatLon from = stay.front()->position->position;
  for (std::size_t k = 1; k < stay.size(); ++k) {
    if (!IsRepeat(stay, *stay[k])) continue;
    flight::RecordedPosition& position = *stay[k]->position;
    const auto steps = static_cast<double>(k);
    double flown_m = steps * step_m;
    if (next != nullptr) {
      const double share = steps / static_cast<double>(stay.size());
      flown_m = std::max(flown_m, share * ApartM(stay, *next));
      position.position = geo::OnTheWay(from, next->front()->position->position, share);
    }
    position.sigma_horizontal_m = std::hypot(SigmaOfRecordM(position), flown_m);
    position.is_repeated = true;
    ++moved;
  }
  return moved;
}

}  // namespace

std::optional<flight::Remark> MoveRepeatedPositions(std::vector<Photo>& photos) {
  int moved = 0;
  for (const auto& [camera, stays] : StaysOfCameras(photos)) {
    const double step_m = UsualStepM(stays);
    for (std::size_t s = 0; s < stays.size(); ++s)
      moved += MoveOn(stays[s], s + 1 < stays.size() ? &stays[s + 1] : nullptr, step_m);
  }
  if (moved == 0) return std::nullopt;
  return flight::Remark{flight::RemarkCode::kPositionsRepeated,
                        {{"photos", moved}, {"total", photos.size()}}};
}

}  // namespace skyquilt::poses
