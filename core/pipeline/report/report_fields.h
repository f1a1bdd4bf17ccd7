// VisitFields: what report.json and mosaic.state say of each stage's report, every figure with its name
// there: one list a report, from which it is written and read again (report_codec.h). Not listed is what only
// the run itself needs: AlignPairReport::some, AlignReport::tie_points_of_new and ByImagesReport::is_placed.
// Seams are written only. Any thread.
//
// What `visit` does: `visit(name, value)` takes a figure; `IfAny` a list that is left out while it is empty;
// `Remarked` what is remarked, in English and as codes; `OneOf` a flag that is told as one of two words;
// `Group` figures that have an object of their own; `Each` a list of which the given figures are told.
#pragma once

#include <concepts>
#include <type_traits>

#include "core/alignment/scene/align_report.h"
#include "core/camera/intrinsics.h"
#include "core/ground/model_ground_report.h"
#include "core/poses/pose_report.h"
#include "core/render/seams/seam_shift.h"

namespace skyquilt::pipeline {

template <typename Value, typename Plain>
concept IsA = std::same_as<std::remove_const_t<Value>, Plain>;

template <IsA<poses::PoseReport> Report, typename Visit>
void VisitFields(Report& report, Visit& visit) {
  visit("method", report.method);
  visit("is_placed", report.is_placed);
  visit("logs", report.logs);
  visit("series", report.series);
  visit("time_match", report.time_match);
  visit("time_offset_s", report.time_offset_s);
  visit("time_sigma_s", report.time_sigma_s);
  visit("camera_ahead_of_utc_s", report.camera_ahead_of_utc_s);
  visit("convention", report.convention);
  visit("height_rule", report.height_rule);
  visit.IfKnown("is_height_guessed", report.is_height_guessed);
  visit.IfKnown("heights_above_ellipsoid", report.heights_above_ellipsoid);
  visit.IfKnown("lists_contradict_m", report.lists_contradict_m);
  visit("photos_by_log", report.photos_by_log);
  visit("photos_by_records", report.photos_by_records);
  visit("knots", report.knots);
  visit("iterations", report.iterations);
  visit("log_position_sigma_m", report.log_position_sigma_m);
  visit.OneOf("log_positions", report.log_is_corrected, "corrected", "plain");
}

template <IsA<ground::ModelGroundReport> Report, typename Visit>
void VisitFields(Report& report, Visit& visit) {
  visit("model", report.model);
  visit("reason", report.reason);
  visit("points_given", report.points_given);
  visit("points_used", report.points_used);
  visit("plane_error_m", report.plane_error_m);
  visit("grid_error_m", report.grid_error_m);
  visit("elevation_model_error_m", report.dem_error_m);
  visit("elevation_model_shift_m", report.dem_shift_m);
  visit("cell_m", report.cell_m);
  visit("lowest_m", report.lowest_m);
  visit("highest_m", report.highest_m);
  visit("mean_m", report.mean_m);
  visit("seconds", report.seconds);
}

template <typename Visit>
void VisitFields(const render::SeamShift& shift, Visit& visit) {
  const double gsd_m = shift.gsd_m > 0.0 ? shift.gsd_m : 1.0;
  visit("patches", shift.patches);
  visit("reliable", shift.reliable);
  visit("median_m", shift.median_m);
  visit("p90_m", shift.p90_m);
  visit("median_gsd", shift.median_m / gsd_m);
  visit("p90_gsd", shift.p90_m / gsd_m);
}

template <IsA<camera::Intrinsics> Lens, typename Visit>
void VisitFields(Lens& lens, Visit& visit) {
  camera::VisitLensFields(lens, [&](const char* name, auto& value) { visit(name, value); });
}

template <IsA<alignment::GyroReport> Gyro, typename Visit>
void VisitFields(Gyro& gyro, Visit& visit) {
  visit("camera_key", gyro.camera_key);
  visit("pairs", gyro.pairs);
  visit("matches", gyro.matches);
  visit("fitting", gyro.fitting);
  visit("fitting_without", gyro.fitting_without);
  visit("lag_s", gyro.lag_s);
  visit("is_used", gyro.is_used);
}

template <IsA<alignment::AlignLensReport> Lens, typename Visit>
void VisitFields(Lens& lens, Visit& visit) {
  visit("camera_key", lens.camera_key);
  visit("recorded", lens.recorded);
  visit("adjusted", lens.adjusted);
  visit("sigma_focal_px", lens.sigma_focal_px);
  visit("focal_is_held", lens.focal_is_held);
}

template <typename Visit>
void VisitPlacedBy(auto& is_by_images, Visit& visit) {
  visit.OneOf("placed_by", is_by_images, "images", "records");
}

template <IsA<alignment::AlignPhotoReport> Photo, typename Visit>
void VisitFields(Photo& photo, Visit& visit) {
  visit("name", photo.name);
  visit("placement", photo.placement);
  visit.Remarked("reason", "remarks", photo.remarks);
  visit("features", photo.features);
  visit("links", photo.links);
  visit("observations", photo.observations);
  visit("residual_rms_px", photo.residual_rms_px);
  visit("moved_m", photo.moved_m);
  visit("turned_deg", photo.turned_deg);
  VisitPlacedBy(photo.is_by_images, visit);
  visit("faults", photo.faults);
}

// Of a pair whether it is in use or was rejected.
template <IsA<alignment::AlignPairReport> Pair, typename Visit>
void VisitComparison(Pair& pair, Visit& visit) {
  visit("first", pair.first);
  visit("second", pair.second);
  visit("matches", pair.matches);
  visit("rms_m", pair.rms_m);
}

template <IsA<alignment::AlignPairReport> Pair, typename Visit>
void VisitFields(Pair& pair, Visit& visit) {
  VisitComparison(pair, visit);
  visit("rms_px", pair.rms_px);
  visit("by_direct", pair.is_by_direct);
}

template <IsA<alignment::ControlMarkReport> Mark, typename Visit>
void VisitFields(Mark& mark, Visit& visit) {
  visit("photo", mark.photo);
  visit("residual_px", mark.residual_px);
  visit("residual_m", mark.residual_m);
  visit("is_used", mark.is_used);
}

template <IsA<alignment::ControlPrediction> Prediction, typename Visit>
void VisitFields(Prediction& left_out, Visit& visit) {
  visit("miss_east_m", left_out.miss_east_m);
  visit("miss_north_m", left_out.miss_north_m);
  visit("miss_up_m", left_out.miss_up_m);
}

template <IsA<alignment::ControlReport> Point, typename Visit>
void VisitFields(Point& point, Visit& visit) {
  visit("name", point.name);
  visit("lat", point.surveyed.lat_deg);
  visit("lon", point.surveyed.lon_deg);
  visit("sightings", point.sightings);
  visit("is_used", point.is_used);
  visit("is_check", point.is_check);
  visit.Remarked("reason", "remark", point.reason);
  visit("miss_east_m", point.miss_east_m);
  visit("miss_north_m", point.miss_north_m);
  visit("miss_up_m", point.miss_up_m);
  visit("residual_px", point.residual_px);
  visit.IfKnown("system_error_m", point.system_error_m);
  visit.IfKnown("left_out", point.left_out);
  visit.IfAny("marks", point.marks);
}

template <IsA<alignment::ByImagesReport> Attempt, typename Visit>
void VisitFields(Attempt& attempt, Visit& visit) {
  visit.Remarked("why", "why_remark", attempt.why);
  visit.Remarked("outcome", "outcome_remark", attempt.outcome);
  visit("is_taken", attempt.is_taken);
  visit.IfKnown("is_scale_guessed", attempt.is_scale_guessed);
  visit.IfKnown("is_north_guessed", attempt.is_north_guessed);
  visit("registered", attempt.registered);
  visit("groups", attempt.groups);
  visit("pairs_compared", attempt.pairs_compared);
  visit("pairs_verified", attempt.pairs_verified);
  visit("pairs_refused", attempt.pairs_refused);
  visit("residual_rms_px", attempt.residual_rms_px);
  visit("total_wall_s", attempt.total_s);
}

template <IsA<alignment::AlignReport> Report, typename Visit>
void VisitFields(Report& report, Visit& visit) {
  visit("photos", report.photos);
  visit("aligned", report.aligned);
  visit("pieces", report.components);
  visit("pairs_tried", report.pairs_tried);
  visit("pairs_linked", report.pairs_linked);
  visit("pairs_rejected", report.pairs_rejected);
  visit("pairs_by_direct", report.pairs_by_direct);
  visit("tie_points", report.tie_points);
  visit("observations", report.observations);
  visit("observations_dropped", report.observations_dropped);
  visit("residual_rms_px", report.residual_rms_px);
  visit("position_residual_m", report.position_residual_m);
  visit("attitude_residual_deg", report.attitude_residual_deg);
  visit("solver", report.solver);
  visit("iterations", report.iterations);
  visit("corrections", report.corrections);
  visit.IfAny("gyros", report.gyros);
  visit.Group("timings_s", [&](auto& timings) {
    timings("decode", report.decode_s);
    timings("features", report.features_s);
    timings("matching_wall", report.matching_s);
    timings("adjustment_wall", report.adjustment_s);
    timings("total_wall", report.total_s);
  });
  visit("cameras", report.lenses);
  visit("photo_reports", report.photo_reports);
  visit("pairs", report.pairs);
  visit.Each("rejected_pairs", report.rejected_pairs,
             [](auto& pair, auto& fields) { VisitComparison(pair, fields); });
  visit("ground_control", report.control);
  visit("position_bias_m", report.position_bias_m);
  visit.IfKnown("survey_above_records_m", report.survey_above_records_m);
  VisitPlacedBy(report.by_images.is_taken, visit);
  visit("second_leg", report.by_images);
}

}  // namespace skyquilt::pipeline
