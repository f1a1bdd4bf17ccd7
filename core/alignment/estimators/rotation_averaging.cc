#include "core/alignment/estimators/rotation_averaging.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

#include "core/geo/rigid3.h"
#include "core/geo/solvers/sparse_cholesky.h"

namespace skyquilt::alignment {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int kAbsoluteRounds = 12;
constexpr int kReweightedRounds = 20;
constexpr double kMinResidualRad = 1e-4;
constexpr double kWidthRad = 0.087;  // 5 degrees: beyond it a pair loses its say
constexpr double kStillRad = 1e-5;

const Quaterniond& RotationOf(const PhotoPair& pair) { return pair.poses.front().rotation; }

// How well the pair is supported.
double Weight(const PhotoPair& pair) {
  return std::min(1.0, static_cast<double>(pair.matches.size()) / 100.0);
}

Vector3d Residual(const PhotoPair& pair, const std::vector<Quaterniond>& rotations) {
  const Quaterniond expected = rotations[pair.second] * rotations[pair.first].conjugate();
  // In the world's axes: R_second' (R12 R1 R2') R_second
  const Quaterniond apart = RotationOf(pair) * expected.conjugate();
  const Quaterniond& second = rotations[pair.second];
  return second.conjugate() * geo::VectorFromRotation(apart.normalized());
}

// Best supported pairs first, from the photo that most hang on.
void FollowTree(int photos, const std::vector<PhotoPair>& pairs, AveragedRotations& averaged) {
  std::vector<std::vector<int>> of_photo(photos);
  std::vector<double> support(photos, 0.0);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    for (const int end : {pairs[p].first, pairs[p].second}) {
      of_photo[end].push_back(static_cast<int>(p));
      support[end] += Weight(pairs[p]);
    }
  }
  std::vector<int> order(photos);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return support[a] > support[b]; });
  PhotoSet reached(photos);
  for (const int root : order) {
    if (reached.Has(root) || of_photo[root].empty()) continue;
    reached.Add(root);
    FollowStrongest(pairs, of_photo, {root}, &Weight, [&](const PhotoPair& pair, int from, int to) {
      const Quaterniond to_from = from == pair.first ? RotationOf(pair) : RotationOf(pair).conjugate();
      averaged.cam_from_world[to] = (to_from * averaged.cam_from_world[from]).normalized();
      reached.Add(to);
    });
  }
}

// One weighted step of all rotations; the largest turn. Every photo is held a little where it is, which fixes
// what no pair tells.
double Step(const std::vector<PhotoPair>& pairs, const std::vector<double>& weights,
            std::vector<Quaterniond>& rotations) {
  const auto count = static_cast<Eigen::Index>(rotations.size());
  std::vector<Eigen::Triplet<double>> terms;
  Eigen::Matrix<double, Eigen::Dynamic, 3> right = Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) terms.emplace_back(i, i, 1e-9);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const PhotoPair& pair = pairs[p];
    const double weight = weights[p];
    // Rotations turn as R <- R Exp(w): the residual becomes residual - (w2 - w1).
    const Eigen::RowVector3d residual = Residual(pair, rotations).transpose();
    terms.emplace_back(pair.first, pair.first, weight);
    terms.emplace_back(pair.second, pair.second, weight);
    terms.emplace_back(pair.first, pair.second, -weight);
    terms.emplace_back(pair.second, pair.first, -weight);
    right.row(pair.second) += weight * residual;
    right.row(pair.first) -= weight * residual;
  }
  Eigen::SparseMatrix<double> normal(count, count);
  normal.setFromTriplets(terms.begin(), terms.end());
  const geo::SparseCholesky solver(normal);
  if (!solver.is_factored()) return 0.0;
  const Eigen::Matrix<double, Eigen::Dynamic, 3> turns = solver.Solve(right);
  double largest = 0.0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3d turn = turns.row(i).transpose();
    largest = std::max(largest, turn.norm());
    Quaterniond& rotation = rotations[i];
    rotation = (rotation * geo::RotationFromVector(turn)).normalized();
  }
  return largest;
}

}  // namespace

AveragedRotations AverageRotations(int photos, const std::vector<PhotoPair>& pairs) {
  AveragedRotations averaged;
  averaged.cam_from_world.assign(photos, Quaterniond::Identity());
  FollowTree(photos, pairs, averaged);
  std::vector<double> weights(pairs.size());
  const auto weigh = [&](auto&& of_residual) {
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      weights[p] = Weight(pairs[p]) * of_residual(Residual(pairs[p], averaged.cam_from_world).norm());
    }
  };
  for (int round = 0; round < kAbsoluteRounds && !pairs.empty(); ++round) {
    weigh([](double residual) { return 1.0 / std::max(kMinResidualRad, residual); });
    if (Step(pairs, weights, averaged.cam_from_world) < kStillRad) break;
  }
  for (int round = 0; round < kReweightedRounds && !pairs.empty(); ++round) {
    weigh([](double residual) {
      const double scaled = 1.0 + (residual / kWidthRad) * (residual / kWidthRad);
      return 1.0 / (scaled * scaled);  // Geman and McClure
    });
    if (Step(pairs, weights, averaged.cam_from_world) < kStillRad) break;
  }
  for (const PhotoPair& pair : pairs)
    averaged.residual_rad.push_back(Residual(pair, averaged.cam_from_world).norm());
  return averaged;
}

}  // namespace skyquilt::alignment
