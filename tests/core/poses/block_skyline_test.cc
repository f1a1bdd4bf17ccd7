#include "core/poses/smoother/block_skyline.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>

namespace skyquilt::poses {
namespace {

struct System {
  BlockSkyline sparse;
  Eigen::MatrixXd dense;
};

// A random positive definite matrix inside the outline.
System RandomSystem(std::vector<int> first, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const int n = static_cast<int>(first.size());
  System system{BlockSkyline(first), Eigen::MatrixXd::Zero(n * kStateSize, n * kStateSize)};
  for (int j = 0; j < n; ++j) {
    for (int i = first[static_cast<std::size_t>(j)]; i <= j; ++i) {
      Matrix22 block = Matrix22::NullaryExpr([&] { return normal(random); });
      if (i == j) block = (block * block.transpose() + 400.0 * Matrix22::Identity()).eval();
      system.sparse.At(j, i) = block;
      system.dense.block<kStateSize, kStateSize>(j * kStateSize, i * kStateSize) = block;
      system.dense.block<kStateSize, kStateSize>(i * kStateSize, j * kStateSize) = block.transpose();
    }
  }
  return system;
}

const std::vector<std::vector<int>> kOutlines = {
    {0},
    {0, 0, 1, 2, 3},              // chain
    {0, 0, 1, 2, 0, 4, 5, 3},     // chain with links
    {0, 0, 1, 2, 3, 4, 0},        // chain with border
    {0, 0, 1, 2, 0, 4, 5, 3, 0},  // all of it
};

TEST(BlockSkyline, SolvesLikeADenseSolver) {
  for (const std::vector<int>& outline : kOutlines) {
    System system = RandomSystem(outline, outline.size());
    std::vector<Vector22> x(outline.size());
    Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(system.dense.rows(), -1.0, 2.0);
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = b.segment<kStateSize>(static_cast<int>(k) * kStateSize);
    ASSERT_TRUE(system.sparse.Factor());
    system.sparse.Solve(x);
    const Eigen::VectorXd expected = system.dense.ldlt().solve(b);
    for (std::size_t k = 0; k < x.size(); ++k) {
      EXPECT_LT((x[k] - expected.segment<kStateSize>(static_cast<int>(k) * kStateSize)).norm(), 1e-12);
    }
  }
}

TEST(BlockSkyline, GivesTheBlocksOfTheDenseInverse) {
  for (const std::vector<int>& outline : kOutlines) {
    System system = RandomSystem(outline, 7 + outline.size());
    const Eigen::MatrixXd expected = system.dense.inverse();
    ASSERT_TRUE(system.sparse.Factor());
    system.sparse.SelectedInverse();
    for (int j = 0; j < system.sparse.size(); ++j) {
      for (int i = system.sparse.First(j); i <= j; ++i) {
        const Matrix22 block = expected.block<kStateSize, kStateSize>(j * kStateSize, i * kStateSize);
        EXPECT_LT((system.sparse.At(j, i) - block).norm(), 1e-12) << j << "," << i;
      }
    }
  }
}

TEST(BlockSkyline, RefusesAMatrixThatIsNotPositiveDefinite) {
  System system = RandomSystem({0, 0, 1}, 3);
  system.sparse.At(1, 1)(4, 4) = -1.0;
  EXPECT_FALSE(system.sparse.Factor());
  System not_a_number = RandomSystem({0, 0, 1}, 3);
  not_a_number.sparse.At(2, 1)(0, 0) = std::nan("");
  EXPECT_FALSE(not_a_number.sparse.Factor());
}

}  // namespace
}  // namespace skyquilt::poses
