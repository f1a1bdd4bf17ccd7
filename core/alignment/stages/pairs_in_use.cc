#include "core/alignment/stages/pairs_in_use.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/alignment/from_records/direct_registration.h"

namespace skyquilt::alignment {
namespace {

constexpr std::size_t kSomePlaces = 9;

struct Shared {
  std::vector<SharedPlace> places;
  double square_px = 0.0;  // of both photos' reprojection errors
  double square_m = 0.0;
};

void AddPair(const std::vector<View>& views, const Track& track, const Observation& one,
             const Observation& other, std::map<std::pair<int, int>, Shared>& pairs) {
  const bool in_order = one.photo < other.photo;
  const Observation& first = in_order ? one : other;
  const Observation& second = in_order ? other : one;
  Shared& shared = pairs[{first.photo, second.photo}];
  shared.places.push_back({first.pixel_in_image, second.pixel_in_image});
  for (const Observation* seen : {&first, &second}) {
    const View& view = views[seen->photo];
    const double error_px = ReprojectionErrorPx(view, *seen, track.point_in_enu);
    shared.square_px += 0.5 * error_px * error_px;
    shared.square_m += 0.5 * std::pow(error_px * view.GsdM(), 2);
  }
}

void Tell(std::map<std::pair<int, int>, Shared>& pairs, const std::vector<std::string>& names,
          bool is_by_direct, std::vector<AlignPairReport>& told) {
  for (const auto& [photos, shared] : pairs) {
    AlignPairReport pair;
    pair.first = names[photos.first];
    pair.second = names[photos.second];
    const auto count = static_cast<double>(shared.places.size());
    pair.matches = static_cast<int>(shared.places.size());
    pair.rms_px = std::sqrt(shared.square_px / count);
    pair.rms_m = std::sqrt(shared.square_m / count);
    pair.is_by_direct = is_by_direct;
    const std::size_t step = (shared.places.size() + kSomePlaces - 1) / kSomePlaces;
    for (std::size_t k = 0; k < shared.places.size(); k += step) pair.some.push_back(shared.places[k]);
    told.push_back(std::move(pair));
  }
}

}  // namespace

std::vector<AlignPairReport> PairsInUse(const BundleProblem& problem, const std::vector<std::string>& names) {
  const std::vector<View> views = ViewsOf(problem);
  std::map<std::pair<int, int>, Shared> by_points, by_direct;
  for (const Track& track : problem.tracks) {
    for (std::size_t a = 0; a < track.observations.size(); ++a) {
      for (std::size_t b = a + 1; b < track.observations.size(); ++b) {
        AddPair(views, track, track.observations[a], track.observations[b], by_points);
      }
    }
  }
  for (const Track& track : problem.soft_tracks) {
    if (Agrees(views, track)) {
      AddPair(views, track, track.observations.front(), track.observations.back(), by_direct);
    }
  }
  std::vector<AlignPairReport> told;
  Tell(by_points, names, false, told);
  Tell(by_direct, names, true, told);
  return told;
}

}  // namespace skyquilt::alignment
