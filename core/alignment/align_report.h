// AlignReport: what alignment found, doubted and refused, for people and for report.json. A value; any
// thread.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/alignment/aligned_flight.h"
#include "core/alignment/ground_control.h"
#include "core/camera/intrinsics.h"

namespace skyquilt::alignment {

struct AlignPhotoReport {
  std::string name;
  Placement placement = Placement::kPoseOnly;
  std::string reason;
  int features = 0;
  int links = 0;         // photos it is tied to
  int observations = 0;  // tie points it sees
  double residual_rms_px = 0.0;
  double moved_m = 0.0;  // how far the image centre moved on the ground against the recorded pose
  double turned_deg = 0.0;
  double error_radius_m = 0.0;
};

struct AlignPairReport {
  std::string first, second;
  int matches = 0;
  double rms_m = 0.0;
};

struct AlignLensReport {
  std::string camera_key;
  camera::Intrinsics recorded, adjusted;
  double sigma_focal_px = 0.0;
  bool focal_is_held = true;  // the images say no more of it than the record
};

struct AlignReport {
  int photos = 0;
  int aligned = 0;
  int pieces = 0;  // groups of aligned photos without ties between them
  int pairs_tried = 0;
  int pairs_linked = 0;
  int pairs_rejected = 0;   // linked by a few matches, contradicted by the rest
  int pairs_by_direct = 0;  // tied by comparing the pictures as a whole
  int tie_points = 0;
  int observations = 0;
  int observations_dropped = 0;
  double residual_rms_px = 0.0;
  double position_residual_m = 0.0;  // horizontal rms of adjusted against recorded camera positions
  double attitude_residual_deg = 0.0;
  std::string solver;
  int iterations = 0;
  double decode_s = 0.0, features_s = 0.0;                     // summed over photos
  double matching_s = 0.0, adjustment_s = 0.0, total_s = 0.0;  // wall
  std::vector<AlignLensReport> lenses;
  std::vector<AlignPhotoReport> photo_reports;
  std::vector<AlignPairReport> rejected_pairs;
  std::vector<ControlReport> control;
  Eigen::Vector3d position_bias_m = Eigen::Vector3d::Zero();  // of the recorded positions; known with control
  std::vector<std::string> corrections;                       // in words, a photo or a line each
};

std::string AlignReportJson(const AlignReport& report);

}  // namespace skyquilt::alignment
