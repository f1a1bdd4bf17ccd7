#include "core/alignment/stages/doubt_photos.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/alignment/features/sharpness.h"
#include "core/base/median.h"

namespace skyquilt::alignment {
namespace {

constexpr double kSamePixelPx = 1.0;
constexpr double kCopiedShare = 0.4;    // of the features that must lie at the same pixels
constexpr double kBlurredShare = 0.35;  // of the fine detail that others show of the same ground
constexpr std::size_t kEnoughToCompare = 2;
constexpr std::size_t kFewPhotos = 5;
constexpr std::size_t kRichInFeatures = 300;
constexpr double kSurelySharedOverlap = 0.4;
constexpr int kWitnesses = 3;  // linked photos that overlap and know nothing of it
constexpr double kMinGapM = 300.0;
constexpr double kGapOverExtent = 1.0;
constexpr double kMaxLeftOutShare = 0.1;

bool ShowsTheSamePixels(const PhotoPair& verified_pair, const MatchedFlight& input) {
  const PhotoFeatures& first = *input.features[verified_pair.first];
  const PhotoFeatures& second = *input.features[verified_pair.second];
  const auto same = std::count_if(verified_pair.matches.begin(), verified_pair.matches.end(),
                                  [&](const KeypointMatch& match) {
                                    const Keypoint& a = first.keypoints[match.first];
                                    const Keypoint& b = second.keypoints[match.second];
                                    return std::hypot(a.x_px - b.x_px, a.y_px - b.y_px) < kSamePixelPx;
                                  });
  const std::size_t fewer = std::min(first.keypoints.size(), second.keypoints.size());
  return static_cast<double>(same) > kCopiedShare * static_cast<double>(fewer);
}

// Against those that are linked, and so surely show the same ground; a photo without verified pairs, which
// may show any, must besides be of little sharpness by itself, whatever it shows.
void FindBlurred(const std::vector<PhotoPair>& pairs, const Relief& relief, MatchedFlight& input) {
  const std::size_t count = input.views.size();
  std::vector<std::vector<double>> linked(count), overlapping(count), by_itself(count);
  const auto against = [&](int own, int other, std::vector<std::vector<double>>& shares) {
    const std::optional<double> share =
        SharpnessAgainst(input.features[own]->detail, input.views[own], input.features[other]->detail,
                         input.views[other], relief);
    if (share) shares[own].push_back(*share);
  };
  for (const PhotoPair& verified_pair : input.links) {
    against(verified_pair.first, verified_pair.second, linked);
    against(verified_pair.second, verified_pair.first, linked);
  }
  std::vector<double> sharpness(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    if (input.features[i] != nullptr) sharpness[i] = SharpnessByItself(input.features[i]->detail);
  }
  for (const PhotoPair& pair : pairs) {
    if (pair.overlap < kSurelySharedOverlap || !input.features[pair.first] || !input.features[pair.second])
      continue;
    for (const auto& [own, other] : {std::pair(pair.first, pair.second), {pair.second, pair.first}}) {
      if (linked[own].size() >= kEnoughToCompare) continue;
      against(own, other, overlapping);
      by_itself[own].push_back(sharpness[own] / (sharpness[other] + 1e-9));
    }
  }
  const auto is_less_sharp = [](const std::vector<double>& shares) {
    return shares.size() >= kEnoughToCompare && Median(shares) < kBlurredShare;
  };
  for (std::size_t i = 0; i < count; ++i) {
    const bool is_linked = linked[i].size() >= kEnoughToCompare;
    input.findings[i].is_blurred =
        is_linked ? is_less_sharp(linked[i]) : is_less_sharp(overlapping[i]) && is_less_sharp(by_itself[i]);
    const std::vector<double>& shares = is_linked ? linked[i] : overlapping[i];
    if (shares.size() >= kEnoughToCompare) input.findings[i].sharpness = Median(shares);
  }
}

}  // namespace

void DoubtPhotos(const std::vector<PhotoPair>& pairs, const Relief& relief, MatchedFlight& flight) {
  const std::size_t count = flight.views.size();
  const std::vector<int> linked = CountPairs(count, flight.links);
  std::vector<int> witnesses(count, 0);
  for (const PhotoPair& verified_pair : flight.links) {
    PhotoFindings& later = flight.findings[verified_pair.second];
    if (!later.copy_of && ShowsTheSamePixels(verified_pair, flight)) later.copy_of = verified_pair.first;
  }
  FindBlurred(pairs, relief, flight);
  for (const PhotoPair& pair : pairs) {
    if (pair.overlap < kSurelySharedOverlap) continue;
    if (linked[pair.second] > 1) ++witnesses[pair.first];
    if (linked[pair.first] > 1) ++witnesses[pair.second];
  }
  for (std::size_t i = 0; i < count; ++i) {
    PhotoFindings& own = flight.findings[i];
    own.shows_other_place = linked[i] == 0 && witnesses[i] >= kWitnesses && flight.features[i] &&
                            flight.features[i]->keypoints.size() >= kRichInFeatures && !own.is_blurred;
  }
}

std::vector<flight::Remark> DoubtsInRemarks(const PhotoFindings& findings,
                                            const std::vector<std::string>& names) {
  using flight::RemarkCode;
  std::vector<flight::Remark> remarks;
  if (findings.copy_of) remarks.push_back({RemarkCode::kDoubtCopy, {{"other", names[*findings.copy_of]}}});
  if (findings.is_blurred) remarks.push_back(RemarkCode::kDoubtBlurred);
  if (findings.shows_other_place) remarks.push_back(RemarkCode::kDoubtOtherPlace);
  return remarks;
}

std::vector<flight::Remark> DoubtsInRemarks(const std::vector<PhotoFindings>& findings,
                                            const std::vector<std::string>& names) {
  using flight::RemarkCode;
  constexpr int kNamedApart = 3;  // more of them is one thing to know: the aircraft hovered
  const PhotoFindings* first = nullptr;
  std::string photo;
  int copies = 0;
  for (std::size_t i = 0; i < findings.size(); ++i) {
    if (!findings[i].copy_of) continue;
    if (copies++ == 0) first = &findings[i], photo = names[i];
  }
  std::vector<flight::Remark> remarks;
  if (copies > kNamedApart) {
    remarks.push_back({RemarkCode::kSamePictures,
                       {{"photos", copies}, {"photo", photo}, {"other", names[*first->copy_of]}}});
  }
  for (std::size_t i = 0; i < findings.size(); ++i) {
    for (flight::Remark& remark : DoubtsInRemarks(findings[i], names)) {
      if (copies > kNamedApart && remark.code == RemarkCode::kDoubtCopy) continue;
      remarks.push_back({RemarkCode::kOfPhoto, {{"photo", names[i]}, {"said", std::move(remark)}}});
    }
  }
  return remarks;
}

PhotoSet LeaveOutFarAway(AlignedFlight& flight) {
  const std::size_t count = flight.photos.size();
  PhotoSet far_away(count);
  if (count < kFewPhotos) return far_away;
  const std::vector<Eigen::Vector2d> places = EastNorthOf(flight.photos);
  const Eigen::Vector2d middle = MedianByAxis(places);
  // By distance from the middle, the block grows until a gap as wide as itself; among the first photos of a
  // high flight every step is one.
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return (places[a] - middle).norm() < (places[b] - middle).norm();
  });
  const double may_leave = std::max(1.0, kMaxLeftOutShare * static_cast<double>(count));
  std::size_t kept = count;
  for (std::size_t k = count - 1; static_cast<double>(count - k) <= may_leave; --k) {
    const double inner_m = (places[order[k - 1]] - middle).norm();
    const double gap_m = (places[order[k]] - middle).norm() - inner_m;
    if (gap_m > std::max(kMinGapM, 2.0 * kGapOverExtent * inner_m)) kept = k;
  }
  for (std::size_t k = kept; k < count; ++k) {
    if (flight.photos[order[k]].placement == Placement::kPoseOnly) far_away.Add(order[k]);
  }
  std::vector<AlignedPhoto> near;
  for (std::size_t i = 0; i < count; ++i) {
    if (!far_away.Has(i)) {
      near.push_back(std::move(flight.photos[i]));
      continue;
    }
    flight.left_out.push_back({flight.photos[i].photo.name, ErrorCode::kNoPosition,
                               flight::Remark(flight::RemarkCode::kLeftFarAway,
                                              {{"apart_km", (places[i] - middle).norm() / 1000.0}})});
  }
  flight.photos = std::move(near);
  return far_away;
}

}  // namespace skyquilt::alignment
