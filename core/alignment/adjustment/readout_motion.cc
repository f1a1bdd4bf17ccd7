#include "core/alignment/adjustment/readout_motion.h"

namespace skyquilt::alignment {

Eigen::Vector3d ReadoutMotion(const poses::PosedPhoto& posed, int quarter_turns) {
  const flight::Photo& photo = posed.photo;
  if (!posed.velocity_in_enu_mps || !photo.readout_s) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d motion_m = *photo.readout_s * *posed.velocity_in_enu_mps;
  // A camera mounted sideways still reads its own rows; a viewer that turned the picture turned those.
  if (!photo.is_resaved_by_viewer || quarter_turns == 0) return motion_m;
  return quarter_turns == 2 ? Eigen::Vector3d(-motion_m) : Eigen::Vector3d::Zero();
}

}  // namespace skyquilt::alignment
