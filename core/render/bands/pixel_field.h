// PixelField: how far pixels of a camera's pictures lie from where its lens puts them: what a few numbers of
// distortion cannot say, smooth over the picture and the same in all pictures of the camera. Nodes on a grid,
// bilinear between them. A value; any thread.
//
// FitPixelField: one from misses. A node that few misses are near goes on straight from its neighbours and
// stays near zero. Method: weighted least squares with second differences, Huber's weights. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace skyquilt::render {

class PixelField {
 public:
  static constexpr int kColumns = 9, kRows = 7;  // of nodes; the outer ones lie on the picture's edge

  PixelField() = default;  // zero everywhere
  // Nodes by rows. Precondition: kColumns * kRows of them.
  PixelField(int width_px, int height_px, std::vector<Eigen::Vector2d> nodes);

  bool IsZero() const { return nodes_.empty(); }
  // Of a pixel of the full size; beyond the picture that of its edge.
  Eigen::Vector2d At(const Eigen::Vector2d& pixel) const;

  // The node before a place, and how far behind it the place is, 0..1.
  struct Cell {
    int column = 0, row = 0;
    double right = 0.0, down = 0.0;
  };
  static Cell CellOf(const Eigen::Vector2d& pixel, int width_px, int height_px);

 private:
  int width_px_ = 0, height_px_ = 0;
  std::vector<Eigen::Vector2d> nodes_;
};

struct PixelMiss {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();    // where the lens puts a point
  Eigen::Vector2d miss = Eigen::Vector2d::Zero();  // where it is, less that
};

// Zero where there are fewer than kFewestMisses.
inline constexpr std::size_t kFewestMisses = 60;
PixelField FitPixelField(int width_px, int height_px, const std::vector<PixelMiss>& misses);

}  // namespace skyquilt::render
