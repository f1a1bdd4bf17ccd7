// A cost function's value, and its derivatives against its own differences.
#pragma once

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

namespace skyquilt::alignment {

using CostValues = std::vector<std::vector<double>>;  // by block

inline std::vector<const double*> BlocksOf(const CostValues& values) {
  std::vector<const double*> blocks;
  for (const std::vector<double>& block : values) blocks.push_back(block.data());
  return blocks;
}

inline Eigen::Vector2d ResidualAt(const ceres::CostFunction& cost, const CostValues& values) {
  Eigen::Vector2d residual;
  EXPECT_TRUE(cost.Evaluate(BlocksOf(values).data(), residual.data(), nullptr));
  return residual;
}

// `off`: how far a derivative near zero may be off.
inline void ExpectOwnDerivatives(const ceres::CostFunction& cost, CostValues values, double off = 1e-5) {
  constexpr double kStep = 1e-6;
  CostValues derivatives;
  std::vector<double*> out;
  for (const std::vector<double>& block : values) derivatives.emplace_back(2 * block.size());
  for (std::vector<double>& block : derivatives) out.push_back(block.data());
  Eigen::Vector2d residual;
  ASSERT_TRUE(cost.Evaluate(BlocksOf(values).data(), residual.data(), out.data()));
  for (std::size_t block = 0; block < values.size(); ++block) {
    for (std::size_t k = 0; k < values[block].size(); ++k) {
      const double was = values[block][k];
      values[block][k] = was + kStep;
      const Eigen::Vector2d more = ResidualAt(cost, values);
      values[block][k] = was - kStep;
      const Eigen::Vector2d change = (more - ResidualAt(cost, values)) / (2.0 * kStep);
      values[block][k] = was;
      for (int row = 0; row < 2; ++row) {
        const double said = derivatives[block][static_cast<std::size_t>(row) * values[block].size() + k];
        EXPECT_NEAR(said, change[row], off + 1e-5 * std::abs(change[row]))
            << "block " << block << ", number " << k;
      }
    }
  }
}

}  // namespace skyquilt::alignment
