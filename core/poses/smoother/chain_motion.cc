// The part of chain_factors.h that ties neighbouring knots and carries them to times between them.
#include <cmath>

#include "core/poses/smoother/chain_factors.h"
#include "core/poses/so3.h"

namespace skyquilt::poses {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void MixBiases(const KnotState& first, const KnotState& second, double w, KnotState& out) {
  out.gyro_bias_radps = (1.0 - w) * first.gyro_bias_radps + w * second.gyro_bias_radps;
  out.accel_bias_mps2 = (1.0 - w) * first.accel_bias_mps2 + w * second.accel_bias_mps2;
  out.gnss_bias_in_enu_m = (1.0 - w) * first.gnss_bias_in_enu_m + w * second.gnss_bias_in_enu_m;
  out.attitude_bias_rad = (1.0 - w) * first.attitude_bias_rad + w * second.attitude_bias_rad;
  out.baro_bias_m = (1.0 - w) * first.baro_bias_m + w * second.baro_bias_m;
}

}  // namespace

StateBetween StateAtKnot(const KnotState& knot) {
  StateBetween s;
  s.state = knot;
  s.by_first.leftCols<9>().setIdentity();
  return s;
}

StateBetween StateByImu(const KnotState& first, const KnotState& second, double weight, const ImuDelta& d,
                        double gravity_mps2) {
  StateBetween s;
  s.weight = weight;
  s.state = d.Predict(first, gravity_mps2);
  MixBiases(first, second, weight, s.state);
  s.rate_radps = d.end_rate_radps - first.gyro_bias_radps;
  s.acceleration_mps2 = s.state.enu_from_body * (d.end_force_mps2 - first.accel_bias_mps2);
  s.acceleration_mps2.z() -= gravity_mps2;
  const Matrix3d r = first.enu_from_body.toRotationMatrix();
  const Vector3d bias_step = d.rotation_by_gyro_bias * (first.gyro_bias_radps - d.gyro_bias);
  s.by_first.block<3, 3>(0, kAtRotation) = d.CorrectedRotation(first.gyro_bias_radps).transpose();
  s.by_first.block<3, 3>(0, kAtGyroBias) = RightJacobian(bias_step) * d.rotation_by_gyro_bias;
  s.by_first.block<3, 3>(3, kAtRotation) = -r * Skew(d.CorrectedVelocity(first));
  s.by_first.block<3, 3>(3, kAtVelocity).setIdentity();
  s.by_first.block<3, 3>(3, kAtGyroBias) = r * d.velocity_by_gyro_bias;
  s.by_first.block<3, 3>(3, kAtAccelBias) = r * d.velocity_by_accel_bias;
  s.by_first.block<3, 3>(6, kAtRotation) = -r * Skew(d.CorrectedPosition(first));
  s.by_first.block<3, 3>(6, kAtVelocity) = d.duration_s * Matrix3d::Identity();
  s.by_first.block<3, 3>(6, kAtPosition).setIdentity();
  s.by_first.block<3, 3>(6, kAtGyroBias) = r * d.position_by_gyro_bias;
  s.by_first.block<3, 3>(6, kAtAccelBias) = r * d.position_by_accel_bias;
  return s;
}

StateBetween StateByMotionPrior(const KnotState& first, const KnotState& second, double w, double duration_s,
                                double density, double walk) {
  StateBetween s;
  s.weight = w;
  // Variances of the bridges between knots: Brownian for rotation, integrated Brownian for position.
  const double u = w * (1.0 - w);
  s.rotation_variance = walk * walk * duration_s * u;
  s.velocity_variance = density * duration_s * u * (1.0 - 3.0 * u);
  s.position_variance = density * duration_s * duration_s * duration_s * u * u * u / 3.0;
  MixBiases(first, second, w, s.state);
  const Vector3d turn = LogSo3(first.enu_from_body.conjugate() * second.enu_from_body);
  const Matrix3d part = ExpSo3(w * turn);
  s.state.enu_from_body = (first.enu_from_body * geo::RotationFromVector(w * turn)).normalized();
  s.rate_radps = turn / duration_s;
  const Matrix3d by_turn = w * RightJacobian(w * turn);
  s.by_first.block<3, 3>(0, kAtRotation) = part.transpose() - by_turn * LeftJacobianInverse(turn);
  s.by_second.block<3, 3>(0, kAtRotation) = by_turn * RightJacobianInverse(turn);

  // The cubic through both positions and velocities: value, slope and bend by (p0, v0, p1, v1).
  const double w2 = w * w, w3 = w2 * w;
  const Eigen::Vector4d value(2 * w3 - 3 * w2 + 1, duration_s * (w3 - 2 * w2 + w), -2 * w3 + 3 * w2,
                              duration_s * (w3 - w2));
  const Eigen::Vector4d slope((6 * w2 - 6 * w) / duration_s, 3 * w2 - 4 * w + 1,
                              (-6 * w2 + 6 * w) / duration_s, 3 * w2 - 2 * w);
  const Eigen::Vector4d bend((12 * w - 6) / (duration_s * duration_s), (6 * w - 4) / duration_s,
                             (-12 * w + 6) / (duration_s * duration_s), (6 * w - 2) / duration_s);
  Eigen::Matrix<double, 3, 4> ends;
  ends << first.position_in_enu_m, first.velocity_in_enu_mps, second.position_in_enu_m,
      second.velocity_in_enu_mps;
  s.state.position_in_enu_m = ends * value;
  s.state.velocity_in_enu_mps = ends * slope;
  s.acceleration_mps2 = ends * bend;
  for (int k = 0; k < 3; ++k) {
    s.by_first(3 + k, kAtPosition + k) = slope(0);
    s.by_first(3 + k, kAtVelocity + k) = slope(1);
    s.by_second(3 + k, kAtPosition + k) = slope(2);
    s.by_second(3 + k, kAtVelocity + k) = slope(3);
    s.by_first(6 + k, kAtPosition + k) = value(0);
    s.by_first(6 + k, kAtVelocity + k) = value(1);
    s.by_second(6 + k, kAtPosition + k) = value(2);
    s.by_second(6 + k, kAtVelocity + k) = value(3);
  }
  return s;
}

Linear<9> ImuFactor(const KnotState& first, const KnotState& second, const ImuDelta& d,
                    const Matrix9d& whiten, double gravity_mps2) {
  const Vector3d gravity(0.0, 0.0, -gravity_mps2);
  const double duration_s = d.duration_s;
  const Matrix3d back = first.enu_from_body.toRotationMatrix().transpose();
  const Vector3d dv = back * (second.velocity_in_enu_mps - first.velocity_in_enu_mps - duration_s * gravity);
  const Vector3d dp =
      back * (second.position_in_enu_m - first.position_in_enu_m - duration_s * first.velocity_in_enu_mps -
              0.5 * duration_s * duration_s * gravity);
  const Vector3d bias_step = d.rotation_by_gyro_bias * (first.gyro_bias_radps - d.gyro_bias);
  const Eigen::Quaterniond measured(d.CorrectedRotation(first.gyro_bias_radps));
  const Eigen::Quaterniond between = first.enu_from_body.conjugate() * second.enu_from_body;
  const Vector3d turn = LogSo3(measured.conjugate() * between);
  const Matrix3d right_inverse = RightJacobianInverse(turn);
  Eigen::Matrix<double, 9, 1> r;
  r << turn, dv - d.CorrectedVelocity(first), dp - d.CorrectedPosition(first);
  Matrix9x22 a = Matrix9x22::Zero();
  Matrix9x22 b = Matrix9x22::Zero();
  a.block<3, 3>(0, kAtRotation) = -right_inverse * between.toRotationMatrix().transpose();
  a.block<3, 3>(0, kAtGyroBias) =
      -LeftJacobianInverse(turn) * RightJacobian(bias_step) * d.rotation_by_gyro_bias;
  a.block<3, 3>(3, kAtRotation) = Skew(dv);
  a.block<3, 3>(3, kAtVelocity) = -back;
  a.block<3, 3>(3, kAtGyroBias) = -d.velocity_by_gyro_bias;
  a.block<3, 3>(3, kAtAccelBias) = -d.velocity_by_accel_bias;
  a.block<3, 3>(6, kAtRotation) = Skew(dp);
  a.block<3, 3>(6, kAtVelocity) = -duration_s * back;
  a.block<3, 3>(6, kAtPosition) = -back;
  a.block<3, 3>(6, kAtGyroBias) = -d.position_by_gyro_bias;
  a.block<3, 3>(6, kAtAccelBias) = -d.position_by_accel_bias;
  b.block<3, 3>(0, kAtRotation) = right_inverse;
  b.block<3, 3>(3, kAtVelocity) = back;
  b.block<3, 3>(6, kAtPosition) = back;
  Linear<9> out;
  out.residual = whiten * r;
  out.by_first.noalias() = whiten * a;
  out.by_second.noalias() = whiten * b;
  return out;
}

Linear<9> MotionPriorFactor(const KnotState& first, const KnotState& second, double duration_s,
                            double density, double walk) {
  Linear<9> out;
  const Vector3d turn = LogSo3(first.enu_from_body.conjugate() * second.enu_from_body);
  const double turn_weight = 1.0 / (walk * std::sqrt(duration_s));
  out.residual.head<3>() = turn_weight * turn;
  out.by_first.block<3, 3>(0, kAtRotation) = -turn_weight * LeftJacobianInverse(turn);
  out.by_second.block<3, 3>(0, kAtRotation) = turn_weight * RightJacobianInverse(turn);
  // White acceleration: the covariance of (velocity, position) has the Cholesky factor used backwards here.
  const double v = 1.0 / std::sqrt(density * duration_s);
  const double p = std::sqrt(12.0 / (density * duration_s * duration_s * duration_s));
  const Vector3d rv = second.velocity_in_enu_mps - first.velocity_in_enu_mps;
  const Vector3d rp = second.position_in_enu_m - first.position_in_enu_m -
                      0.5 * duration_s * (first.velocity_in_enu_mps + second.velocity_in_enu_mps);
  out.residual.segment<3>(3) = v * rv;
  out.residual.tail<3>() = p * rp;
  for (int k = 0; k < 3; ++k) {
    out.by_first(3 + k, kAtVelocity + k) = -v;
    out.by_second(3 + k, kAtVelocity + k) = v;
    out.by_first(6 + k, kAtPosition + k) = -p;
    out.by_second(6 + k, kAtPosition + k) = p;
    out.by_first(6 + k, kAtVelocity + k) = -0.5 * duration_s * p;
    out.by_second(6 + k, kAtVelocity + k) = -0.5 * duration_s * p;
  }
  return out;
}

Linear<13> BiasWalkFactor(const KnotState& first, const KnotState& second, const BiasWalk& walk) {
  Linear<13> out;
  const auto tie = [&](int row, int at, double sigma, double keep, double a, double b) {
    out.residual(row) = (b - keep * a) / sigma;
    out.by_first(row, at) = -keep / sigma;
    out.by_second(row, at) = 1.0 / sigma;
  };
  for (int k = 0; k < 3; ++k) {
    tie(k, kAtGyroBias + k, walk.gyro, 1.0, first.gyro_bias_radps(k), second.gyro_bias_radps(k));
    tie(3 + k, kAtAccelBias + k, walk.accel, 1.0, first.accel_bias_mps2(k), second.accel_bias_mps2(k));
    tie(6 + k, kAtGnssBias + k, walk.gnss(k), walk.gnss_keep, first.gnss_bias_in_enu_m(k),
        second.gnss_bias_in_enu_m(k));
    tie(9 + k, kAtAttitudeBias + k, walk.attitude(k), walk.attitude_keep, first.attitude_bias_rad(k),
        second.attitude_bias_rad(k));
  }
  tie(12, kAtBaroBias, walk.baro, 1.0, first.baro_bias_m, second.baro_bias_m);
  return out;
}

}  // namespace skyquilt::poses
