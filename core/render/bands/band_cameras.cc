#include "core/render/bands/band_cameras.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>

#include "core/base/check.h"
#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::render {
namespace {

constexpr int kFieldNodes = PixelField::kColumns * PixelField::kRows;
constexpr double kMissSigmaPx = 0.3;
constexpr double kBendSigmaPx = 0.3;  // of a node from the middle of two neighbours
constexpr double kNodeSigmaPx = 1.5;  // of a node from zero
constexpr double kUsualMissPx = 0.5;  // beyond it a miss counts less
constexpr int kFieldRounds = 8;

std::array<std::pair<int, double>, 4> NodesAround(const PixelField::Cell& cell) {
  const int nw = cell.row * PixelField::kColumns + cell.column;
  return {{{nw, (1.0 - cell.right) * (1.0 - cell.down)},
           {nw + 1, cell.right * (1.0 - cell.down)},
           {nw + PixelField::kColumns, (1.0 - cell.right) * cell.down},
           {nw + PixelField::kColumns + 1, cell.right * cell.down}}};
}

// What is known of the nodes before any miss.
Eigen::MatrixXd FieldStiffness() {
  const double of_node = kMissSigmaPx * kMissSigmaPx / (kNodeSigmaPx * kNodeSigmaPx);
  const double of_bend = kMissSigmaPx * kMissSigmaPx / (kBendSigmaPx * kBendSigmaPx);
  Eigen::MatrixXd stiffness = of_node * Eigen::MatrixXd::Identity(kFieldNodes, kFieldNodes);
  const auto bend = [&](int before, int at, int behind) {
    Eigen::VectorXd difference = Eigen::VectorXd::Zero(kFieldNodes);
    difference[before] = difference[behind] = 1.0;
    difference[at] = -2.0;
    stiffness += of_bend * difference * difference.transpose();
  };
  for (int row = 0; row < PixelField::kRows; ++row) {
    for (int column = 0; column < PixelField::kColumns; ++column) {
      const int at = row * PixelField::kColumns + column;
      if (column > 0 && column + 1 < PixelField::kColumns) bend(at - 1, at, at + 1);
      if (row > 0 && row + 1 < PixelField::kRows)
        bend(at - PixelField::kColumns, at, at + PixelField::kColumns);
    }
  }
  return stiffness;
}

}  // namespace

PixelField::PixelField(int width_px, int height_px, std::vector<Eigen::Vector2d> nodes)
    : width_px_(width_px), height_px_(height_px), nodes_(std::move(nodes)) {
  SKYQUILT_CHECK(nodes_.size() == kFieldNodes, "a field of another number of nodes");
}

PixelField::Cell PixelField::CellOf(const Eigen::Vector2d& pixel, int width_px, int height_px) {
  const double x = std::clamp((pixel.x() + 0.5) / width_px, 0.0, 1.0) * (kColumns - 1);
  const double y = std::clamp((pixel.y() + 0.5) / height_px, 0.0, 1.0) * (kRows - 1);
  Cell cell;
  cell.column = std::min(static_cast<int>(x), kColumns - 2);
  cell.row = std::min(static_cast<int>(y), kRows - 2);
  cell.right = x - cell.column;
  cell.down = y - cell.row;
  return cell;
}

Eigen::Vector2d PixelField::At(const Eigen::Vector2d& pixel) const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  if (IsZero() || !pixel.allFinite()) return sum;
  for (const auto& [node, share] : NodesAround(CellOf(pixel, width_px_, height_px_)))
    sum += share * nodes_[static_cast<std::size_t>(node)];
  return sum;
}

PixelField FitPixelField(int width_px, int height_px, const std::vector<PixelMiss>& misses) {
  if (misses.size() < kFewestMisses) return {};
  const Eigen::MatrixXd stiffness = FieldStiffness();
  Eigen::MatrixX2d nodes = Eigen::MatrixX2d::Zero(kFieldNodes, 2);
  for (int round = 0; round < kFieldRounds; ++round) {
    Eigen::MatrixXd normal = stiffness;
    Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(kFieldNodes, 2);
    for (const PixelMiss& miss : misses) {
      const auto around = NodesAround(PixelField::CellOf(miss.at, width_px, height_px));
      Eigen::RowVector2d now = Eigen::RowVector2d::Zero();
      for (const auto& [node, share] : around) now += share * nodes.row(node);
      const double left_px = (miss.miss.transpose() - now).norm();
      const double weight = left_px <= kUsualMissPx ? 1.0 : kUsualMissPx / left_px;
      for (const auto& [node, share] : around) {
        right.row(node) += weight * share * miss.miss.transpose();
        for (const auto& [other, other_share] : around) normal(node, other) += weight * share * other_share;
      }
    }
    nodes = geo::SolveSymmetric(normal, right);
  }
  std::vector<Eigen::Vector2d> fitted;
  for (int node = 0; node < kFieldNodes; ++node) fitted.emplace_back(nodes.row(node).transpose());
  return {width_px, height_px, std::move(fitted)};
}

}  // namespace skyquilt::render
