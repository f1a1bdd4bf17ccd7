#include "core/geo/solvers/dense_solvers.h"

#include <Eigen/Dense>

namespace skyquilt::geo {

Eigen::MatrixXd SolveSymmetric(const DenseMatrix& normal, const DenseMatrix& right) {
  return Eigen::LDLT<Eigen::MatrixXd>(normal).solve(right);
}

std::optional<Eigen::MatrixXd> SolveSquare(const DenseMatrix& square, const DenseMatrix& right) {
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(square);
  if (!lu.isInvertible()) return std::nullopt;
  return lu.solve(right);
}

Eigen::MatrixXd SolveLeastSquares(const DenseMatrix& columns, const DenseMatrix& right) {
  return Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(columns).solve(right);
}

Eigen::MatrixXd OrthonormalBasis(const DenseMatrix& columns) {
  return Eigen::FullPivHouseholderQR<Eigen::MatrixXd>(columns).matrixQ();
}

SymmetricEigen EigenOfSymmetric(const DenseMatrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  if (solver.info() != Eigen::Success) return {};
  return {true, solver.eigenvalues(), solver.eigenvectors()};
}

ComplexEigen EigenOfSquare(const DenseMatrix& square, bool with_vectors) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(square, with_vectors);
  if (solver.info() != Eigen::Success) return {};
  if (!with_vectors) return {true, solver.eigenvalues(), {}};
  return {true, solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace skyquilt::geo
