#include "core/alignment/stages/track_ties.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "core/alignment/from_records/direct_registration.h"
#include "core/alignment/matching/verified_pair.h"
#include "core/alignment/scene/disjoint_sets.h"

namespace skyquilt::alignment {
namespace {

constexpr int kSomePlaces = 9;

// Which observation of which track.
struct SeenAt {
  int track = 0, at = 0;
};

// By photo, in the tracks' order.
std::vector<std::vector<SeenAt>> SeenByPhoto(std::size_t photos, const std::vector<Track>& tracks) {
  std::vector<std::vector<SeenAt>> seen(photos);
  for (int t = 0; t < static_cast<int>(tracks.size()); ++t) {
    const std::vector<Observation>& observations = tracks[t].observations;
    for (int k = 0; k < static_cast<int>(observations.size()); ++k)
      seen[observations[k].photo].push_back({t, k});
  }
  return seen;
}

// What an observation adds to each pair that its photo is half of.
struct HalfErrors {
  double square_px = 0.0, square_m = 0.0;
};

std::vector<HalfErrors> HalfErrorsOf(const std::vector<View>& views, const Track& track) {
  std::vector<HalfErrors> errors;
  errors.reserve(track.observations.size());
  for (const Observation& seen : track.observations) {
    const View& view = views[seen.photo];
    const double error_px = ReprojectionErrorPx(view, seen, track.point_in_enu);
    errors.push_back({0.5 * error_px * error_px, 0.5 * std::pow(error_px * view.GsdM(), 2)});
  }
  return errors;
}

// What one photo shares with another.
struct Shared {
  int places = 0;
  double square_px = 0.0;  // of both photos' reprojection errors
  double square_m = 0.0;
  int told_every = 1;  // of the places
  int passed = 0;
  std::size_t report = 0;
};

// One photo after the other with all that come after it in its tracks: a first time to count their places,
// a second time to tell some of them.
void TellPairs(const std::vector<View>& views, const std::vector<Track>& tracks,
               const std::vector<std::string>& names, bool is_by_direct, std::vector<AlignPairReport>& told) {
  std::vector<std::vector<HalfErrors>> errors;
  errors.reserve(tracks.size());
  for (const Track& track : tracks) errors.push_back(HalfErrorsOf(views, track));
  const std::vector<std::vector<SeenAt>> seen_by_photo = SeenByPhoto(views.size(), tracks);
  std::vector<Shared> shared_with(views.size());
  std::vector<int> partners;
  for (std::size_t first = 0; first < views.size(); ++first) {
    const auto for_each_place = [&](const auto& take) {
      for (const SeenAt& one : seen_by_photo[first]) {
        const int end = static_cast<int>(tracks[one.track].observations.size());
        for (int other = one.at + 1; other < end; ++other) take(one.track, one.at, other);
      }
    };
    partners.clear();
    for_each_place([&](int track, int one, int other) {
      const int partner = tracks[track].observations[other].photo;
      Shared& shared = shared_with[partner];
      if (shared.places++ == 0) partners.push_back(partner);
      for (const int k : {one, other}) {
        shared.square_px += errors[track][k].square_px;
        shared.square_m += errors[track][k].square_m;
      }
    });
    std::sort(partners.begin(), partners.end());
    for (const int partner : partners) {
      Shared& shared = shared_with[partner];
      shared.told_every = (shared.places + kSomePlaces - 1) / kSomePlaces;
      shared.report = told.size();
      AlignPairReport& pair = told.emplace_back();
      pair.first = names[first];
      pair.second = names[partner];
      pair.matches = shared.places;
      pair.rms_px = std::sqrt(shared.square_px / shared.places);
      pair.rms_m = std::sqrt(shared.square_m / shared.places);
      pair.is_by_direct = is_by_direct;
      pair.some.reserve((shared.places + shared.told_every - 1) / shared.told_every);
    }
    for_each_place([&](int track, int one, int other) {
      const std::vector<Observation>& seen = tracks[track].observations;
      Shared& shared = shared_with[seen[other].photo];
      if (shared.passed++ % shared.told_every != 0) return;
      told[shared.report].some.emplace_back(seen[one].pixel_in_image, seen[other].pixel_in_image);
    });
    for (const int partner : partners) shared_with[partner] = {};
  }
}

}  // namespace

std::vector<int> FindAligned(const BundleProblem& problem, std::vector<Support>& support) {
  const std::size_t count = problem.photos.size();
  const std::vector<View> views = ViewsOf(problem);
  PhotoSet strong(count, true);
  for (int before = -1; before != strong.Count();) {
    before = strong.Count();
    support.assign(count, {});
    for (const Track& track : problem.tracks) {
      std::vector<const Observation*> seen;
      for (const Observation& one : track.observations) {
        if (strong.Has(one.photo)) seen.push_back(&one);
      }
      if (seen.size() < 2) continue;
      for (const Observation* one : seen) {
        Support& own = support[one->photo];
        ++own.observations;
        const double residual = ReprojectionErrorPx(views[one->photo], *one, track.point_in_enu);
        own.square_px += residual * residual;
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (support[i].observations < kEnoughObservations) strong.Remove(i);
    }
  }
  const std::vector<std::vector<SeenAt>> seen_by_photo = SeenByPhoto(count, problem.tracks);
  std::vector<int> last_tied_to(count, -1);
  std::vector<PhotoPair> ties;  // no more than hold the components together
  DisjointSets sets(count);
  for (int i = 0; i < static_cast<int>(count); ++i) {
    if (!strong.Has(i)) continue;
    last_tied_to[i] = i;
    for (const SeenAt& one : seen_by_photo[i]) {
      for (const Observation& other : problem.tracks[one.track].observations) {
        if (!strong.Has(other.photo) || last_tied_to[other.photo] == i) continue;
        last_tied_to[other.photo] = i;
        ++support[i].tied_to;
        const int own_set = sets.SetOf(i), other_set = sets.SetOf(other.photo);
        if (own_set == other_set) continue;
        sets.Join(own_set, other_set);
        ties.push_back({i, other.photo, {}, {}, 0.0});
      }
    }
  }
  return FindConnectedComponents(count, ties).of_photo;
}

std::vector<AlignPairReport> PairsInUse(const BundleProblem& problem, const std::vector<std::string>& names) {
  const std::vector<View> views = ViewsOf(problem);
  std::vector<Track> by_direct;
  std::copy_if(problem.soft_tracks.begin(), problem.soft_tracks.end(), std::back_inserter(by_direct),
               [&](const Track& tie) { return Agrees(views, tie); });
  std::vector<AlignPairReport> told;
  TellPairs(views, problem.tracks, names, false, told);
  TellPairs(views, by_direct, names, true, told);
  return told;
}

}  // namespace skyquilt::alignment
