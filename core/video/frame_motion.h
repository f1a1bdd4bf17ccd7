// FrameMotion: how far the camera has moved over the ground since a frame of a film, from what the frames
// show: corners are followed from each frame to the next (pyramidal Lucas-Kanade), and a similarity is fitted
// to them (RANSAC). Bouguet 2001, "Pyramidal implementation of the affine Lucas Kanade feature tracker".
// Deterministic. One thread at a time.
#pragma once

#include <memory>
#include <optional>

#include "core/video/video_file.h"

namespace skyquilt::video {

class FrameMotion {
 public:
  FrameMotion();
  ~FrameMotion();
  FrameMotion(const FrameMotion&) = delete;
  FrameMotion& operator=(const FrameMotion&) = delete;

  // The next frame, of the size of those before. Nothing: it does not fit to the one before (a cut, a blur,
  // water), so that the way since the reference is not known.
  std::optional<double> OverlapWithReference(const GrayFrame& frame);
  // The frame that was given last becomes the reference, or the marked one.
  void MakeReference();
  void Mark();
  void MakeMarkedReference();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Variance of the Laplacian: larger for a sharper picture of the same ground.
double Sharpness(const GrayFrame& frame);

}  // namespace skyquilt::video
