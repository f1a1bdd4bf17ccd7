// BestPartners: of the photos that one may be compared with, as they come in any order, those that it is: the
// most overlapping ones, the best in each direction, and a few of unlike scale. Keeps no others, so that a
// flight that hovers, all of whose photos overlap, takes no more memory than any. A value; any thread.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace skyquilt::alignment {

class BestPartners {
 public:
  static constexpr std::size_t kBest = 6;  // by overlap alone; plus the best of each direction
  static constexpr std::size_t kBestOfUnlike = 3;
  static constexpr int kDirections = 8;
  // Minus the overlap, with which photo: of equals the lesser photo is the better.
  using Partner = std::pair<double, int>;

  void Add(const Partner& partner, int direction) {
    Keep(partner, kBest, best_);
    std::optional<Partner>& there = of_direction_[direction];
    if (!there || partner < *there) there = partner;
  }
  void AddUnlike(const Partner& partner) { Keep(partner, kBestOfUnlike, unlike_); }

  // Whether it would be kept; where not, one of less overlap would not be either.
  bool Wants(const Partner& partner, int direction) const {
    const std::optional<Partner>& there = of_direction_[direction];
    return HasPlace(partner, kBest, best_) || !there || partner < *there;
  }
  bool WantsUnlike(const Partner& partner) const { return HasPlace(partner, kBestOfUnlike, unlike_); }

  // Each once, the best first.
  std::vector<Partner> Chosen() const {
    std::vector<Partner> chosen = best_;
    chosen.insert(chosen.end(), unlike_.begin(), unlike_.end());
    for (const std::optional<Partner>& one : of_direction_) {
      if (one) chosen.push_back(*one);
    }
    std::sort(chosen.begin(), chosen.end());
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    return chosen;
  }

 private:
  static bool HasPlace(const Partner& partner, std::size_t most, const std::vector<Partner>& kept) {
    return kept.size() < most || !(kept.back() < partner);
  }
  static void Keep(const Partner& partner, std::size_t most, std::vector<Partner>& kept) {
    if (!HasPlace(partner, most, kept)) return;
    kept.insert(std::upper_bound(kept.begin(), kept.end(), partner), partner);
    if (kept.size() > most) kept.pop_back();
  }

  std::vector<Partner> best_, unlike_;  // sorted
  std::array<std::optional<Partner>, kDirections> of_direction_;
};

}  // namespace skyquilt::alignment
