#include "core/alignment/scene/scene_tracks.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/alignment/scene/keypoints.h"

namespace skyquilt::alignment {
namespace {

constexpr float kOnePlacePx = 1.0F;  // described in two directions

bool IsOnePlace(const PhotoFeatures& features, int a, int b) {
  const Keypoint& x = features.keypoints[static_cast<std::size_t>(a)];
  const Keypoint& y = features.keypoints[static_cast<std::size_t>(b)];
  return std::hypot(x.x_px - y.x_px, x.y_px - y.y_px) <= kOnePlacePx;
}

// Disjoint sets of observations that know their members.
class ElementSets {
 public:
  ElementSets(const RegistrationInput& input, const std::vector<int>& first_of) : input_(input) {
    root_.resize(static_cast<std::size_t>(first_of.back()));
    std::iota(root_.begin(), root_.end(), 0);
    members_.resize(root_.size());
    for (std::size_t i = 0; i + 1 < first_of.size(); ++i) {
      for (int k = first_of[i]; k < first_of[i + 1]; ++k) {
        members_[static_cast<std::size_t>(k)] = {{static_cast<int>(i), k - first_of[i]}};
      }
    }
  }

  void Join(int a, int b) {
    a = Find(a);
    b = Find(b);
    if (a == b) return;
    std::vector<TrackElement>& of_a = Members(a);
    std::vector<TrackElement>& of_b = Members(b);
    std::vector<TrackElement> merged;
    merged.reserve(of_a.size() + of_b.size());
    auto next_a = of_a.begin();
    auto next_b = of_b.begin();
    while (next_a != of_a.end() || next_b != of_b.end()) {
      if (next_b == of_b.end() || (next_a != of_a.end() && next_a->photo < next_b->photo)) {
        merged.push_back(*next_a++);
      } else if (next_a == of_a.end() || next_b->photo < next_a->photo) {
        merged.push_back(*next_b++);
      } else {
        const PhotoFeatures& features = *input_.photos[static_cast<std::size_t>(next_a->photo)].features;
        if (!IsOnePlace(features, next_a->keypoint, next_b->keypoint)) return;
        merged.push_back(*next_a++);
        ++next_b;
      }
    }
    root_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    Members(std::max(a, b)) = {};
    Members(std::min(a, b)) = std::move(merged);
  }

  std::vector<std::vector<TrackElement>>& members() { return members_; }

 private:
  int Find(int i) {
    while (root_[static_cast<std::size_t>(i)] != i) {
      int& up = root_[static_cast<std::size_t>(i)];
      i = up = root_[static_cast<std::size_t>(up)];
    }
    return i;
  }
  std::vector<TrackElement>& Members(int i) { return members_[static_cast<std::size_t>(i)]; }

  const RegistrationInput& input_;
  std::vector<int> root_;
  std::vector<std::vector<TrackElement>> members_;
};

}  // namespace

SceneTracks JoinMatches(const RegistrationInput& input, const std::vector<GraphPair>& pairs) {
  std::vector<int> first_of(input.photos.size() + 1, 0);
  for (std::size_t i = 0; i < input.photos.size(); ++i) {
    const PhotoFeatures* features = input.photos[i].features;
    first_of[i + 1] = first_of[i] + (features ? static_cast<int>(features->keypoints.size()) : 0);
  }
  std::vector<std::size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return pairs[a].view.matches.size() > pairs[b].view.matches.size();
  });
  ElementSets sets(input, first_of);
  for (const std::size_t p : order) {
    const GraphPair& pair = pairs[p];
    for (const KeypointMatch& match : pair.view.matches) {
      sets.Join(first_of[static_cast<std::size_t>(pair.first)] + match.first,
                first_of[static_cast<std::size_t>(pair.second)] + match.second);
    }
  }
  SceneTracks scene;
  scene.of_photo.resize(input.photos.size());
  for (std::vector<TrackElement>& members : sets.members()) {
    if (members.size() < 2) continue;
    for (const TrackElement& element : members) {
      scene.of_photo[static_cast<std::size_t>(element.photo)].push_back(
          static_cast<int>(scene.tracks.size()));
    }
    scene.tracks.push_back(std::move(members));
  }
  return scene;
}

}  // namespace skyquilt::alignment
