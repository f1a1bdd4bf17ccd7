// The stages' reports with every figure other than it is by default, of those that report.json tells. Any
// thread.
#pragma once

#include <limits>

#include "core/alignment/scene/align_report.h"
#include "core/ground/model_ground_report.h"
#include "core/poses/pose_report.h"

namespace skyquilt::pipeline {

inline poses::PoseReport FullPoseReport() {
  poses::PoseReport report;
  report.method = "by the log";
  report.logs = {"flight.bin: positions", "flight.bin: angles"};
  report.series = {"gnss"};
  report.time_match = "by events";
  report.time_offset_s = -1.0 / 3.0;
  report.time_sigma_s = 1e-9;
  report.camera_ahead_of_utc_s = 7200.25;
  report.convention = "gimbal";
  report.height_rule = "barometer";
  report.is_placed = false;
  report.photos_by_log = 17;
  report.photos_by_records = 3;
  report.knots = std::numeric_limits<int>::max();
  report.iterations = 5;
  report.log_position_sigma_m = 1.0 / 7.0;
  report.log_is_corrected = true;
  return report;
}

inline ground::ModelGroundReport FullGroundReport() {
  ground::ModelGroundReport report;
  report.model = "grid";
  report.reason = "held-back points lie nearer";
  report.points_given = 900;
  report.points_used = 870;
  report.plane_error_m = 1.0 / 3.0;
  report.grid_error_m = 0.05;
  report.dem_error_m = 0.7;
  report.dem_shift_m = -512.125;
  report.cell_m = 2.5;
  report.lowest_m = -3.0;
  report.highest_m = 4.0;
  report.mean_m = -0.1;
  report.seconds = 1e-3;
  return report;
}

inline alignment::AlignPhotoReport FullPhotoReport() {
  alignment::AlignPhotoReport photo;
  photo.name = "DJI_1.JPG";
  photo.placement = alignment::Placement::kAligned;
  photo.remarks = {flight::RemarkCode::kByPoseAlone, flight::RemarkCode::kDoubtBlurred};
  photo.features = 4000;
  photo.links = 6;
  photo.observations = 321;
  photo.residual_rms_px = 0.6;
  photo.moved_m = 1.0 / 3.0;
  photo.turned_deg = -2.5;
  photo.is_by_images = true;
  photo.faults = {alignment::kAllPhotoFaults.begin(), alignment::kAllPhotoFaults.end()};
  return photo;
}

inline alignment::AlignPairReport FullPairReport() {
  alignment::AlignPairReport pair;
  pair.first = "DJI_1.JPG";
  pair.second = "DJI_2.JPG";
  pair.matches = 88;
  pair.rms_m = 0.02;
  pair.rms_px = 0.9;
  pair.is_by_direct = true;
  return pair;
}

inline alignment::AlignReport FullAlignReport() {
  alignment::AlignReport report;
  report.photos = 20;
  report.aligned = 19;
  report.components = 2;
  report.pairs_tried = 190;
  report.pairs_linked = 80;
  report.pairs_rejected = 4;
  report.pairs_by_direct = 1;
  report.tie_points = 5000;
  report.observations = 15000;
  report.observations_dropped = 30;
  report.residual_rms_px = 2.0 / 3.0;
  report.position_residual_m = 1.5;
  report.attitude_residual_deg = 0.25;
  report.solver = "sparse";
  report.iterations = 12;
  report.decode_s = 1.25;
  report.features_s = 2.25;
  report.matching_s = 3.25;
  report.adjustment_s = 4.25;
  report.total_s = 5.25;
  report.lenses = {
      {"key", {800, 600, 700.1, 700.2, 399.5, 299.5, 0.1, -0.2, 0.3, 1e-4, -2e-4}, {}, 0.4, false}};
  report.lenses[0].adjusted = report.lenses[0].recorded;
  report.lenses[0].adjusted.focal_x_px = 698.5;
  report.photo_reports = {FullPhotoReport()};
  report.pairs = {FullPairReport(), FullPairReport()};
  report.rejected_pairs = {FullPairReport()};
  report.rejected_pairs[0].rms_px = 0.0;  // which is of pairs in use alone, as is the next
  report.rejected_pairs[0].is_by_direct = false;
  report.control = {{"point1",
                     geo::LatLon{46.8, 7.1},
                     3,
                     true,
                     true,
                     flight::RemarkCode::kPointMarksApart,
                     0.1,
                     -0.2,
                     0.3,
                     1.5,
                     std::nullopt,
                     alignment::ControlPrediction{0.4, -0.5, 0.6},
                     {}}};
  report.position_bias_m = {0.1, -0.2, 0.3};
  report.corrections = {"DJI_1.JPG was stored turned"};
  report.by_images.why = flight::Remark(flight::RemarkCode::kRecordsNoPoint);
  report.by_images.outcome = flight::Remark(flight::RemarkCode::kImagesOnControl);
  report.by_images.registered = 18;
  report.by_images.groups = 2;
  report.by_images.pairs_compared = 100;
  report.by_images.pairs_verified = 60;
  report.by_images.pairs_refused = 9;
  report.by_images.residual_rms_px = 0.8;
  report.by_images.total_s = 33.0;
  report.by_images.is_taken = true;
  report.gyros = {{"key", 10, 900, 800, 500, -0.01, false}};
  return report;
}

}  // namespace skyquilt::pipeline
