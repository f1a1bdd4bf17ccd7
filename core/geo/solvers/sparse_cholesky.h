// SparseCholesky: systems of many unknowns few of which share an equation, by a sparse L D L' with
// fill-reducing order, compiled once as the dense ones are (dense_solvers.h). The matrix is square and
// symmetric; of it the lower triangle is read. Nothing is scaled. A value; any thread. Where the matrix has
// no such factors is_factored() is false, and Solve must not be called.
#pragma once

#include <Eigen/SparseCore>
#include <memory>

#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::geo {

class SparseCholesky {
 public:
  explicit SparseCholesky(const Eigen::SparseMatrix<double>& normal);
  ~SparseCholesky();

  bool is_factored() const;
  // x of normal x = right, a column each.
  Eigen::MatrixXd Solve(const DenseMatrix& right) const;

 private:
  struct Factors;
  std::unique_ptr<const Factors> factors_;
};

}  // namespace skyquilt::geo
