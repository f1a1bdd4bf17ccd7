// Linear algebra of a few unknowns: systems and eigenvalues of dense matrices whose size is known when the
// program runs. Eigen writes each decomposition anew for each fixed size and each source (5 to 20 seconds of
// the compiler's time each); here each is compiled once. Any shapes that fit each other, column-major;
// nothing is scaled. Values; any thread. What has no solution comes back as numbers that are not finite, as
// nullopt or with `converged` false.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace skyquilt::geo {

using DenseMatrix = Eigen::Ref<const Eigen::MatrixXd>;

// x of normal x = right by Cholesky's L D L' with pivots; normal symmetric, right with one column or more.
Eigen::MatrixXd SolveSymmetric(const DenseMatrix& normal, const DenseMatrix& right);

// x of square x = right by a fully pivoted LU; nullopt where square has no inverse.
std::optional<Eigen::MatrixXd> SolveSquare(const DenseMatrix& square, const DenseMatrix& right);

// x that makes columns x - right shortest, by Householder's QR with pivots; columns with more rows than
// columns.
Eigen::MatrixXd SolveLeastSquares(const DenseMatrix& columns, const DenseMatrix& right);

// An orthonormal basis of n dimensions whose first columns span those of `columns` (n rows, no more columns
// than rows).
Eigen::MatrixXd OrthonormalBasis(const DenseMatrix& columns);

struct SymmetricEigen {
  bool converged = false;
  Eigen::VectorXd values;   // rising
  Eigen::MatrixXd vectors;  // a column each, of length 1
};
SymmetricEigen EigenOfSymmetric(const DenseMatrix& symmetric);

struct ComplexEigen {
  bool converged = false;
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;  // a column each; empty where only the values are wanted
};
ComplexEigen EigenOfSquare(const DenseMatrix& square, bool with_vectors);

}  // namespace skyquilt::geo
