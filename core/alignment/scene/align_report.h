// AlignReport: what alignment found, doubted and refused, for people and for report.json (its names there:
// core/pipeline/report/report_fields.h). A value; any thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/alignment/scene/ground_control.h"
#include "core/alignment/scene/matches.h"
#include "core/camera/intrinsics.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::alignment {

// What is wrong with a photo or its record, found by comparing it with the others. Below in the same order.
enum class PhotoFault {
  kPositionWrong,  // recorded far off
  kYawWrong,       // by something else than quarter turns
  kStoredTurned,   // by quarter turns against its recorded yaw
  kCopy,           // of an earlier photo
  kBlurred,
  kOtherPlace,  // nothing in common with the photos around its recorded place
  kFarAway,     // left out: kilometres from the others
};
inline constexpr std::array kAllPhotoFaults = {
    PhotoFault::kPositionWrong, PhotoFault::kYawWrong,   PhotoFault::kStoredTurned, PhotoFault::kCopy,
    PhotoFault::kBlurred,       PhotoFault::kOtherPlace, PhotoFault::kFarAway};
inline std::string_view FaultName(PhotoFault fault) {
  constexpr std::array<std::string_view, kAllPhotoFaults.size()> kNames = {
      "position_wrong", "yaw_wrong", "stored_turned", "copy", "blurred", "other_place", "far_away"};
  return kNames[static_cast<int>(fault)];
}

struct AlignPhotoReport {
  std::string name;
  Placement placement = Placement::kPoseOnly;
  std::vector<flight::Remark> remarks;  // as AlignedPhoto has them
  int features = 0;
  int links = 0;         // photos it is tied to
  int observations = 0;  // tie points it sees
  double residual_rms_px = 0.0;
  double moved_m = 0.0;  // how far the image centre moved on the ground against the recorded pose
  double turned_deg = 0.0;
  bool is_by_images = false;  // its place started from what it shows, not from its record
  std::vector<PhotoFault> faults;

  bool operator==(const AlignPhotoReport&) const = default;
};

struct AlignPairReport {
  std::string first, second;
  int matches = 0;
  double rms_m = 0.0;
  double rms_px = 0.0;        // of pairs in use
  bool is_by_direct = false;  // tied by the pictures as a whole
  // Pixels of the matches in use, spread over all of them; for who asked for the alignment, told nowhere.
  std::vector<RayPair> some;

  bool operator==(const AlignPairReport&) const = default;
};

struct AlignLensReport {
  std::string camera_key;
  camera::Intrinsics recorded, adjusted;
  double sigma_focal_px = 0.0;
  bool focal_is_held = true;  // the images say no more of it than the record

  bool operator==(const AlignLensReport&) const = default;
};

// Photos placed by what they show, without their recorded poses.
struct ByImagesReport {
  std::optional<flight::Remark> why;  // the records were doubted; nothing: they held, and nothing was tried
  std::optional<flight::Remark> outcome;
  int registered = 0;  // photos in the largest group
  int groups = 0;
  int pairs_compared = 0, pairs_verified = 0, pairs_refused = 0;
  double residual_rms_px = 0.0;
  double total_s = 0.0;  // wall
  bool is_taken = false;
  bool is_placed = false;  // on Earth, by positions or surveyed points; for who asked, told nowhere
  bool is_adrift = false;  // nothing says how the largest group lies to the records; told nowhere either
  bool ignores_surveyed_heights = false;  // they would tip the largest group over; told by its outcome
  std::optional<bool> is_scale_guessed;   // nothing recorded says how large the largest group is
  std::optional<bool> is_north_guessed;   // nor how it is turned

  bool operator==(const ByImagesReport&) const = default;
};

// A camera's gyro against what its photos show.
struct GyroReport {
  std::string camera_key;
  int pairs = 0, matches = 0;            // of photos that were compared
  int fitting = 0, fitting_without = 0;  // matches that fit one motion of the ground, with and without it
  double lag_s = 0.0;                    // by which its records come after the rows that they belong to
  bool is_used = true;                   // false: the photos contradict it

  bool operator==(const GyroReport&) const = default;
};

struct AlignReport {
  int photos = 0;
  int aligned = 0;
  int components = 0;  // groups of aligned photos without ties between them
  int pairs_tried = 0;
  int pairs_linked = 0;
  int pairs_rejected = 0;   // linked by a few matches, contradicted by the rest
  int pairs_by_direct = 0;  // tied by comparing the pictures as a whole
  int tie_points = 0;
  int tie_points_of_new = 0;  // of them, seen by photos beside those of a map that stays; told nowhere
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
  std::vector<AlignPairReport> pairs;  // that hold the map together in the end
  std::vector<AlignPairReport> rejected_pairs;
  std::vector<ControlReport> control;
  Eigen::Vector3d position_bias_m = Eigen::Vector3d::Zero();  // of the recorded positions; known with control
  // What must be added to the map's heights to count as the surveyed points that place it do; nothing without
  // such points, or where they have no heights.
  std::optional<double> survey_above_records_m;
  std::vector<flight::Remark> corrections;  // of a photo or a line each
  ByImagesReport by_images;
  std::vector<GyroReport> gyros;

  bool operator==(const AlignReport&) const = default;
};

}  // namespace skyquilt::alignment
