#include "core/poses/smoother/block_skyline.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "core/base/check.h"

namespace skyquilt::poses {

BlockSkyline::BlockSkyline(std::vector<int> first) : first_(std::move(first)), below_(first_.size()) {
  std::size_t count = 0;
  for (int j = 0; j < size(); ++j) {
    SKYQUILT_CHECK(First(j) >= 0 && First(j) <= j, "a row of the outline begins right of its diagonal");
    start_.push_back(count);
    count += static_cast<std::size_t>(j - First(j) + 1);
    for (int i = First(j); i < j; ++i) below_[static_cast<std::size_t>(i)].push_back(j);
  }
  blocks_.assign(count, Matrix22::Zero());
}

void BlockSkyline::SetZero() { std::fill(blocks_.begin(), blocks_.end(), Matrix22::Zero()); }

bool BlockSkyline::Factor() {
  for (int j = 0; j < size(); ++j) {
    for (int i = First(j); i <= j; ++i) {
      Matrix22& block = At(j, i);
      for (int k = std::max(First(i), First(j)); k < i; ++k)
        block.noalias() -= At(j, k) * At(i, k).transpose();
      if (i < j) {
        At(i, i).triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(block);
      } else {
        const Eigen::LLT<Matrix22> cholesky(block);
        if (cholesky.info() != Eigen::Success || !block.allFinite()) return false;
        block = cholesky.matrixL();
      }
    }
  }
  return true;
}

void BlockSkyline::Solve(std::vector<Vector22>& x) const {
  SKYQUILT_CHECK(x.size() == first_.size(), "the right-hand side has another size than the system");
  for (int j = 0; j < size(); ++j) {
    Vector22& xj = x[static_cast<std::size_t>(j)];
    for (int i = First(j); i < j; ++i) xj.noalias() -= At(j, i) * x[static_cast<std::size_t>(i)];
    At(j, j).triangularView<Eigen::Lower>().solveInPlace(xj);
  }
  for (int j = size() - 1; j >= 0; --j) {
    Vector22& xj = x[static_cast<std::size_t>(j)];
    At(j, j).triangularView<Eigen::Lower>().transpose().solveInPlace(xj);
    for (int i = First(j); i < j; ++i) x[static_cast<std::size_t>(i)].noalias() -= At(j, i).transpose() * xj;
  }
}

void BlockSkyline::SelectedInverse() {
  std::vector<Matrix22> scaled;
  for (int i = size() - 1; i >= 0; --i) {
    const std::vector<int>& rows = below_[static_cast<std::size_t>(i)];
    const Matrix22 inverse_diagonal =
        At(i, i).triangularView<Eigen::Lower>().solve(Matrix22::Identity());  // L_ii^-1
    scaled.resize(rows.size());
    for (std::size_t a = 0; a < rows.size(); ++a) scaled[a].noalias() = At(rows[a], i) * inverse_diagonal;
    for (std::size_t a = 0; a < rows.size(); ++a) {
      Matrix22 block = Matrix22::Zero();
      for (std::size_t b = 0; b < rows.size(); ++b) {
        if (rows[a] >= rows[b]) {
          block.noalias() -= At(rows[a], rows[b]) * scaled[b];
        } else {
          block.noalias() -= At(rows[b], rows[a]).transpose() * scaled[b];
        }
      }
      At(rows[a], i) = block;
    }
    Matrix22 diagonal = inverse_diagonal.transpose() * inverse_diagonal;
    for (std::size_t a = 0; a < rows.size(); ++a)
      diagonal.noalias() -= scaled[a].transpose() * At(rows[a], i);
    At(i, i) = 0.5 * (diagonal + diagonal.transpose());
  }
}

}  // namespace skyquilt::poses
