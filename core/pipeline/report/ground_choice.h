// GroundChoice: what speaks for showing a flight upright, and what against. Values; any thread.
#pragma once

namespace skyquilt::pipeline {

struct GroundChoice {
  // Of the points that tie photos together: those that would lie more than two pixels off in the photo
  // nearest to them, if that is laid on the smooth ground.
  double leaning_share = 0.0;
  double seen_share = 0.0;  // of the ground that a photo shows: what three show, so that heights are sure

  bool operator==(const GroundChoice&) const = default;
};

// What leans is worth it, and three photos see enough of the ground to tell how high it stands.
inline bool IsUpright(const GroundChoice& choice) {
  constexpr double kMinLeaningShare = 0.05, kMinSeenShare = 0.5;
  return choice.leaning_share >= kMinLeaningShare && choice.seen_share >= kMinSeenShare;
}

}  // namespace skyquilt::pipeline
