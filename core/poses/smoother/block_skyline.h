// BlockSkyline: a symmetric positive definite system of 22 x 22 blocks whose row j reaches left no further
// than column first[j]. A chain has first[j] = j - 1; a link between two photos makes one row longer; a
// border is a last row that reaches column 0. Cholesky fills only inside that outline, and so does the part
// of the inverse that SelectedInverse computes, exactly. Work and memory grow with the number of blocks
// inside the outline: linear in the knots of a chain. One thread; deterministic. Sources: A. George and J.
// Liu, Computer Solution of Large Sparse Positive Definite Systems (1981), chapter 4 (envelope method); K.
// Takahashi et al., Formation of a sparse bus impedance matrix (1973) for the inverse.
#pragma once

#include <cstddef>
#include <vector>

#include "core/poses/smoother/chain_state.h"

namespace skyquilt::poses {

class BlockSkyline {
 public:
  // first[j] <= j for every row.
  explicit BlockSkyline(std::vector<int> first);

  int size() const { return static_cast<int>(first_.size()); }
  int First(int row) const { return first_[static_cast<std::size_t>(row)]; }
  void SetZero();
  // The block of row >= column, inside the outline.
  Matrix22& At(int row, int column) { return blocks_[Index(row, column)]; }
  const Matrix22& At(int row, int column) const { return blocks_[Index(row, column)]; }

  // Replaces the matrix by its Cholesky factor. False where it is not positive definite.
  bool Factor();
  // After Factor: replaces the right-hand side by the solution.
  void Solve(std::vector<Vector22>& right_hand_side) const;
  // After Factor: replaces the factor by the blocks of the inverse inside the outline.
  void SelectedInverse();

 private:
  std::size_t Index(int row, int column) const {
    return start_[static_cast<std::size_t>(row)] + static_cast<std::size_t>(column - First(row));
  }
  std::vector<int> first_;
  std::vector<std::size_t> start_;       // where each row's blocks begin
  std::vector<std::vector<int>> below_;  // rows under each column's diagonal that reach it
  std::vector<Matrix22> blocks_;
};

}  // namespace skyquilt::poses
