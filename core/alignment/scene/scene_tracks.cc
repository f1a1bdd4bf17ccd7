#include "core/alignment/scene/scene_tracks.h"

#include <algorithm>
#include <numeric>

#include "core/alignment/scene/keypoint_sets.h"

namespace skyquilt::alignment {
namespace {

// Sets that know their members, each photo at most once.
class MemberSets {
 public:
  explicit MemberSets(const std::vector<const PhotoFeatures*>& features)
      : features_(features), sets_(features), members_(sets_.size()) {
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (!features[i]) continue;
      for (int k = 0; k < static_cast<int>(features[i]->keypoints.size()); ++k)
        Members(sets_.NumberOf(i, k)) = {{static_cast<int>(i), k}};
    }
  }

  void Join(const TrackElement& first, const TrackElement& second) {
    const int a = Find(first), b = Find(second);
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
        const PhotoFeatures& features = *features_[next_a->photo];
        if (!IsOnePlace(features, next_a->keypoint, next_b->keypoint)) return;
        merged.push_back(*next_a++);
        ++next_b;
      }
    }
    sets_.Join(a, b);
    Members(std::max(a, b)) = {};
    Members(std::min(a, b)) = std::move(merged);
  }

  std::vector<std::vector<TrackElement>>& members() { return members_; }

 private:
  int Find(const TrackElement& one) { return sets_.Find(sets_.NumberOf(one.photo, one.keypoint)); }
  std::vector<TrackElement>& Members(int set) { return members_[set]; }

  const std::vector<const PhotoFeatures*>& features_;
  KeypointSets sets_;
  std::vector<std::vector<TrackElement>> members_;
};

}  // namespace

SceneTracks JoinMatches(const RegistrationInput& input, const std::vector<GraphPair>& pairs) {
  std::vector<const PhotoFeatures*> features;
  for (const RegistrationPhoto& photo : input.photos) features.push_back(photo.features);
  std::vector<std::size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return pairs[a].view.matches.size() > pairs[b].view.matches.size();
  });
  MemberSets sets(features);
  for (const std::size_t p : order) {
    const GraphPair& pair = pairs[p];
    for (const KeypointMatch& match : pair.view.matches) {
      sets.Join({pair.first, match.first}, {pair.second, match.second});
    }
  }
  SceneTracks scene;
  scene.of_photo.resize(input.photos.size());
  for (std::vector<TrackElement>& members : sets.members()) {
    if (members.size() < 2) continue;
    for (const TrackElement& element : members) {
      scene.of_photo[element.photo].push_back(static_cast<int>(scene.tracks.size()));
    }
    scene.tracks.push_back(std::move(members));
  }
  return scene;
}

}  // namespace skyquilt::alignment
