#include "core/poses/smoother/chain_factors.h"

#include <algorithm>
#include <cmath>

#include "core/geo/lat_lon.h"
#include "core/poses/so3.h"

namespace skyquilt::poses {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Rows by (rotation, velocity, position) at a time, carried to the knots.
template <int M>
void Chain(const Eigen::Matrix<double, M, 9>& local, const StateBetween& s, Linear<M>& out) {
  out.by_first.noalias() += local * s.by_first;
  if (s.weight != 0.0) out.by_second.noalias() += local * s.by_second;
}

template <int M, int N>
void ByBias(int at, const Eigen::Matrix<double, M, N>& rows, const StateBetween& s, Linear<M>& out) {
  out.by_first.template middleCols<N>(at) += (1.0 - s.weight) * rows;
  out.by_second.template middleCols<N>(at) += s.weight * rows;
}

template <int M>
void Scale(const Eigen::Matrix<double, M, 1>& inverse_sigma, Linear<M>& out) {
  out.residual = inverse_sigma.cwiseProduct(out.residual);
  out.by_first = inverse_sigma.asDiagonal() * out.by_first;
  out.by_second = inverse_sigma.asDiagonal() * out.by_second;
  out.by_border = inverse_sigma.asDiagonal() * out.by_border;
}

double Widened(double sigma, double variance) { return std::sqrt(sigma * sigma + variance); }
Vector3d Widened(const Vector3d& sigma, double variance) {
  return (sigma.array().square() + variance).sqrt().matrix();
}

// Heading, clockwise from north, of a direction in enu, and its derivative by the direction.
double Heading(const Vector3d& direction, Eigen::RowVector3d& by_direction) {
  const double square = std::max(1e-12, direction.head<2>().squaredNorm());
  by_direction << direction.y() / square, -direction.x() / square, 0.0;
  return std::atan2(direction.x(), direction.y());
}

}  // namespace

Linear<3> PositionFactor(const StateBetween& s, const BorderState& border, const Vector3d& measured,
                         const Vector3d& sigma) {
  const Matrix3d r = s.state.enu_from_body.toRotationMatrix();
  const Vector3d lever = border.LeverGnss();
  const double tau = border.TauGnss();
  Linear<3> out;
  out.residual = s.state.position_in_enu_m + tau * s.state.velocity_in_enu_mps +
                 0.5 * tau * tau * s.acceleration_mps2 + r * lever + s.state.gnss_bias_in_enu_m - measured;
  Eigen::Matrix<double, 3, 9> local;
  local << -r * Skew(lever), tau * Matrix3d::Identity(), Matrix3d::Identity();
  Chain<3>(local, s, out);
  ByBias<3, 3>(kAtGnssBias, Matrix3d::Identity(), s, out);
  out.by_border.col(kAtTauGnss) = s.state.velocity_in_enu_mps + tau * s.acceleration_mps2;
  out.by_border.middleCols<3>(kAtLeverGnss) = r;
  Scale<3>(Widened(sigma, s.position_variance).cwiseInverse(), out);
  return out;
}

Linear<3> VelocityFactor(const StateBetween& s, const BorderState& border, const Vector3d& measured,
                         const Vector3d& sigma) {
  const Matrix3d r = s.state.enu_from_body.toRotationMatrix();
  const Vector3d swing = s.rate_radps.cross(border.LeverGnss());
  Linear<3> out;
  out.residual = s.state.velocity_in_enu_mps + border.TauGnss() * s.acceleration_mps2 + r * swing - measured;
  Eigen::Matrix<double, 3, 9> local;
  local << -r * Skew(swing), Matrix3d::Identity(), Matrix3d::Zero();
  Chain<3>(local, s, out);
  out.by_border.col(kAtTauGnss) = s.acceleration_mps2;
  out.by_border.middleCols<3>(kAtLeverGnss) = r * Skew(s.rate_radps);
  Scale<3>(Widened(sigma, s.velocity_variance).cwiseInverse(), out);
  return out;
}

// The level axes (nose, right, down) that turn with a body's heading, as columns in enu.
Matrix3d LevelAxes(const Eigen::Quaterniond& enu_from_body) {
  Vector3d nose = enu_from_body * Vector3d::UnitX();
  nose.z() = 0.0;
  nose = nose.norm() > 1e-6 ? nose.normalized() : Vector3d::UnitY();
  Matrix3d axes;
  axes << nose, Vector3d(nose.y(), -nose.x(), 0.0), -Vector3d::UnitZ();
  return axes;
}

Linear<3> AttitudeFactor(const StateBetween& s, const Eigen::Quaterniond& measured, double sigma_tilt,
                         double sigma_yaw) {
  const Matrix3d axes = LevelAxes(measured);
  const Vector3d turned = axes * s.state.attitude_bias_rad;
  const Vector3d up_in_body = measured.conjugate() * Vector3d::UnitZ();
  const Matrix3d along = up_in_body * up_in_body.transpose();
  const Matrix3d whiten = (Matrix3d::Identity() - along) / Widened(sigma_tilt, s.rotation_variance) +
                          along / Widened(sigma_yaw, s.rotation_variance);
  Linear<3> out;
  const Vector3d r = LogSo3(s.state.enu_from_body.conjugate() * geo::RotationFromVector(-turned) * measured);
  out.residual = whiten * r;
  Eigen::Matrix<double, 3, 9> local = Eigen::Matrix<double, 3, 9>::Zero();
  local.leftCols<3>() = -whiten * LeftJacobianInverse(r);
  Chain<3>(local, s, out);
  const Matrix3d by_bias = -whiten * RightJacobianInverse(r) * measured.toRotationMatrix().transpose() *
                           LeftJacobian(turned) * axes;
  ByBias<3, 3>(kAtAttitudeBias, by_bias, s, out);
  return out;
}

Linear<2> LevelFactor(const StateBetween& s, double sigma) {
  const Vector3d& bias = s.state.attitude_bias_rad;
  const Matrix3d bias_back = ExpSo3(-bias);
  const Vector3d up_in_body = s.state.enu_from_body.conjugate() * Vector3d::UnitZ();
  const Vector3d up = bias_back * up_in_body;
  Linear<2> out;
  out.residual = up.head<2>();
  Eigen::Matrix<double, 2, 9> local = Eigen::Matrix<double, 2, 9>::Zero();
  local.leftCols<3>() = (bias_back * Skew(up_in_body)).topRows<2>();
  Chain<2>(local, s, out);
  const Eigen::Matrix<double, 2, 3> by_bias = (Skew(up) * RightJacobian(bias)).topRows<2>();
  ByBias<2, 3>(kAtAttitudeBias, by_bias, s, out);
  Scale<2>(Eigen::Vector2d::Constant(1.0 / sigma), out);
  return out;
}

Linear<1> CourseFactor(const StateBetween& s, double sigma) {
  const Matrix3d r = s.state.enu_from_body.toRotationMatrix();
  const Vector3d& bias = s.state.attitude_bias_rad;
  const Matrix3d bias_rotation = ExpSo3(bias);
  const Vector3d nose_in_body = bias_rotation.col(0);
  Eigen::RowVector3d by_nose, by_velocity;
  const double yaw = Heading(r * nose_in_body, by_nose);
  const double course = Heading(s.state.velocity_in_enu_mps, by_velocity);
  Linear<1> out;
  out.residual(0) = geo::WrapRad(yaw - course);
  Eigen::Matrix<double, 1, 9> local = Eigen::Matrix<double, 1, 9>::Zero();
  local.leftCols<3>() = -by_nose * r * Skew(nose_in_body);
  local.middleCols<3>(3) = -by_velocity;
  Chain<1>(local, s, out);
  const Eigen::RowVector3d by_bias =
      -by_nose * r * bias_rotation * Skew(Vector3d::UnitX()) * RightJacobian(bias);
  ByBias<1, 3>(kAtAttitudeBias, by_bias, s, out);
  Scale<1>(Eigen::Matrix<double, 1, 1>::Constant(1.0 / sigma), out);
  return out;
}

Linear<1> HeightFactor(const StateBetween& s, double measured_z, double sigma) {
  Linear<1> out;
  out.residual(0) = s.state.position_in_enu_m.z() + s.state.baro_bias_m - measured_z;
  Eigen::Matrix<double, 1, 9> local = Eigen::Matrix<double, 1, 9>::Zero();
  local(8) = 1.0;
  Chain<1>(local, s, out);
  out.by_first(kAtBaroBias) += 1.0 - s.weight;
  out.by_second(kAtBaroBias) += s.weight;
  Scale<1>(Eigen::Matrix<double, 1, 1>::Constant(1.0 / Widened(sigma, s.position_variance)), out);
  return out;
}

Linear<1> RangeFactor(const StateBetween& s, double measured_distance, double ground_z, double sigma) {
  const Matrix3d r = s.state.enu_from_body.toRotationMatrix();
  const double cosine = std::max(0.2, -r(2, 2));
  const double height = s.state.position_in_enu_m.z() - ground_z;
  Linear<1> out;
  out.residual(0) = height / cosine - measured_distance;
  Eigen::Matrix<double, 1, 9> local = Eigen::Matrix<double, 1, 9>::Zero();
  const Eigen::RowVector3d cosine_by_rotation = (r * Skew(Vector3d::UnitZ())).row(2);
  local.leftCols<3>() = -height / (cosine * cosine) * cosine_by_rotation;
  local(8) = 1.0 / cosine;
  Chain<1>(local, s, out);
  Scale<1>(Eigen::Matrix<double, 1, 1>::Constant(1.0 / Widened(sigma, s.position_variance)), out);
  return out;
}

Linear<3> StillVelocityFactor(const KnotState& knot, double sigma) {
  Linear<3> out;
  out.residual = knot.velocity_in_enu_mps / sigma;
  out.by_first.middleCols<3>(kAtVelocity) = Matrix3d::Identity() / sigma;
  return out;
}

Linear<3> StillRotationFactor(const KnotState& first, const KnotState& second, double sigma) {
  Linear<3> out;
  const Vector3d turn = LogSo3(first.enu_from_body.conjugate() * second.enu_from_body);
  out.residual = turn / sigma;
  out.by_first.middleCols<3>(kAtRotation) = -LeftJacobianInverse(turn) / sigma;
  out.by_second.middleCols<3>(kAtRotation) = RightJacobianInverse(turn) / sigma;
  return out;
}

Linear<3> MarkerFactor(const StateBetween& s, const Vector3d& measured, double sigma) {
  Linear<3> out;
  out.residual = s.state.position_in_enu_m - measured;
  Eigen::Matrix<double, 3, 9> local = Eigen::Matrix<double, 3, 9>::Zero();
  local.rightCols<3>() = Matrix3d::Identity();
  Chain<3>(local, s, out);
  Scale<3>(Vector3d::Constant(1.0 / Widened(sigma, s.position_variance)), out);
  return out;
}

Linear<1> YawFactor(const StateBetween& s, double yaw_rad, double sigma) {
  const Matrix3d r = s.state.enu_from_body.toRotationMatrix();
  Eigen::RowVector3d by_nose;
  Linear<1> out;
  out.residual(0) = geo::WrapRad(Heading(r.col(0), by_nose) - yaw_rad);
  Eigen::Matrix<double, 1, 9> local = Eigen::Matrix<double, 1, 9>::Zero();
  local.leftCols<3>() = -by_nose * r * Skew(Vector3d::UnitX());
  Chain<1>(local, s, out);
  Scale<1>(Eigen::Matrix<double, 1, 1>::Constant(1.0 / Widened(sigma, s.rotation_variance)), out);
  return out;
}

}  // namespace skyquilt::poses
