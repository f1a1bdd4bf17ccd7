#include "core/geo/solvers/sparse_cholesky.h"

#include <Eigen/SparseCholesky>

namespace skyquilt::geo {

struct SparseCholesky::Factors {
  explicit Factors(const Eigen::SparseMatrix<double>& normal) : of(normal) {}
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> of;  // is not to be moved
};

SparseCholesky::SparseCholesky(const Eigen::SparseMatrix<double>& normal)
    : factors_(std::make_unique<Factors>(normal)) {}

SparseCholesky::~SparseCholesky() = default;

bool SparseCholesky::is_factored() const { return factors_->of.info() == Eigen::Success; }

Eigen::MatrixXd SparseCholesky::Solve(const DenseMatrix& right) const { return factors_->of.solve(right); }

}  // namespace skyquilt::geo
