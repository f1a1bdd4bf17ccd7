// PoseReport: what the pose stage had, what it chose and how sure it is, for report and verdict. A value.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace skyquilt::poses {

struct PoseReport {
  std::string method;                   // how positions and angles were found, in words
  std::vector<std::string> logs;        // which file gave what
  std::vector<std::string> series;      // what the smoother took
  std::string time_match;               // how photos were tied to the log; empty without one
  std::optional<double> time_offset_s;  // log time of a photo minus its stamp since the first photo
  std::optional<double> time_sigma_s;
  std::optional<double> camera_ahead_of_utc_s;
  std::string convention;  // which reading of the recorded angles was taken, and why
  std::string height_rule;
  std::optional<bool> is_height_guessed;  // of photos without one, by their spacing
  // What the flight's heights count from; false: take-off. Nothing: no record, or an earlier version, tells.
  std::optional<bool> heights_above_ellipsoid;
  bool is_placed = true;  // false: nothing says where on Earth the flight was
  // How far lists that name part of the photos lie from the photos' own positions, by no shift in common and
  // by more than any receiver errs: where the map lies is not known better. Nothing: they do not contradict.
  std::optional<double> lists_contradict_m;
  int photos_by_log = 0;
  int photos_by_records = 0;
  int knots = 0;  // of the smoothed chain
  int iterations = 0;
  // Of the log's own positions, where it has any: the error that all share, one sigma a horizontal axis, and
  // whether they are corrected ones (common_error.h).
  std::optional<double> log_position_sigma_m;
  bool log_is_corrected = false;

  bool operator==(const PoseReport&) const = default;
};

}  // namespace skyquilt::poses
