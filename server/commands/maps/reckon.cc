#include "server/commands/maps/reckon.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/printable.h"
#include "core/flight/read_flight.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/lat_lon.h"
#include "core/poses/reckoning/reckon.h"
#include "core/poses/time/join_logs.h"
#include "core/poses/time/tie_to_log.h"
#include "server/commands/maps/reckon_plot.h"
#include "server/terminal/fail.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

struct ReckonArguments {
  std::vector<fs::path> inputs;
  fs::path plot;
  fs::path table;
  double every_s = 2.0;
};

// When the photos were taken, on the log's clock; without photos, the log's own camera events; without these,
// moments `every_s` apart.
std::vector<poses::Capture> CapturesOf(const flight::FlightLog& log, const flight::Flight& flight,
                                       double every_s) {
  std::vector<poses::Capture> captures;
  if (!flight.photos.empty()) {
    const poses::LogTie tie = poses::TieToLog(log, flight.photos);
    for (const std::string& warning : flight::InWords(tie.warnings))
      fmt::print(stderr, "Warning: {}\n", warning);
    for (const poses::TiedPhoto& photo : tie.tied)
      captures.push_back({photo.t_s, tie.photos[photo.photo].name});
    return captures;
  }
  for (const flight::CameraEvent& event : log.events) {
    if (!event.has_time) continue;
    captures.push_back({event.t_s, event.image_name.value_or(fmt::format("event {}", captures.size() + 1))});
  }
  std::sort(captures.begin(), captures.end(),
            [](const poses::Capture& a, const poses::Capture& b) { return a.t_s < b.t_s; });
  if (!captures.empty() || log.imu.empty()) return captures;
  fmt::print("No photos and no camera events: steps of {:g} s.\n", every_s);
  const double start_s = log.imu.front().t_s;
  for (int i = 0; start_s + i * every_s <= log.imu.back().t_s; ++i) {
    captures.push_back({start_s + i * every_s, fmt::format("{:.1f} s", i * every_s)});
  }
  return captures;
}

std::string TableText(const poses::Reckoning& reckoning) {
  std::string text;
  if (!reckoning.intervals.empty()) {
    text +=
        fmt::format("{:>24} {:>8} | {:>9} {:>9} {:>9} | {:>8} {:>8} {:>8} | {:>8} {:>8}\n", "to", "s",
                    "moved m", "trapez.", "Simpson", "turn deg", "trapez.", "Simpson", "drift m", "Simpson");
  }
  for (const poses::ReckonedInterval& i : reckoning.intervals) {
    text += fmt::format(
        "{:>24} {:>8.2f} | {:>9.2f} {:>9.2f} {:>9.2f} | {:>8.2f} {:>8.2f} {:>8.2f} | {:>8.3f} {:>8.3f}\n",
        i.to_name, i.to_s - i.from_s, i.recorded_displacement_in_enu_m.norm(),
        i.trapezoid.displacement_in_enu_m.norm(), i.simpson.displacement_in_enu_m.norm(),
        geo::RadToDeg(i.recorded_rotation_rad), geo::RadToDeg(i.trapezoid.rotation_rad),
        geo::RadToDeg(i.simpson.rotation_rad), i.trapezoid.drift_m, i.simpson.drift_m);
  }
  if (reckoning.intervals_without_record > 0) {
    text += fmt::format("{} intervals are left out: the log has no fix, no attitude or a gap there.\n",
                        reckoning.intervals_without_record);
  }
  for (const poses::ReckonedDrift& drift : reckoning.drifts) {
    text += fmt::format(
        "Drift after {:>2.0f} s: {:.1f} m by trapezoid, {:.1f} m by Simpson (RMS of {} windows).\n",
        drift.length_s, drift.trapezoid_rms_m, drift.simpson_rms_m, drift.windows);
  }
  return text;
}

std::string Csv(const poses::Reckoning& reckoning) {
  std::string text =
      "from,to,from_s,to_s,gnss_e_m,gnss_n_m,gnss_u_m,trapezoid_e_m,trapezoid_n_m,trapezoid_u_m,simpson_e_m,simpson_n_m,"
      "simpson_u_m,attitude_turn_deg,trapezoid_turn_deg,simpson_turn_deg,trapezoid_drift_m,simpson_drift_m\n";
  const auto vector = [](const Eigen::Vector3d& v) {
    return fmt::format("{:.4f},{:.4f},{:.4f}", v.x(), v.y(), v.z());
  };
  for (const poses::ReckonedInterval& i : reckoning.intervals) {
    text += fmt::format("{},{},{:.4f},{:.4f},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}\n", i.from_name,
                        i.to_name, i.from_s, i.to_s, vector(i.recorded_displacement_in_enu_m),
                        vector(i.trapezoid.displacement_in_enu_m), vector(i.simpson.displacement_in_enu_m),
                        geo::RadToDeg(i.recorded_rotation_rad), geo::RadToDeg(i.trapezoid.rotation_rad),
                        geo::RadToDeg(i.simpson.rotation_rad), i.trapezoid.drift_m, i.simpson.drift_m);
  }
  return text;
}

void Write(const fs::path& path, const std::string& text) {
  if (const Result<void> written = storage::WriteFileAtomically(path, text); !written)
    Fail("skyquilt reckon", written.error());
  fmt::print("{}\n", path.string());
}

void Run(const ReckonArguments& arguments) {
  const auto files = flight::ListInputFiles(arguments.inputs);
  if (!files) Fail("skyquilt reckon", files.error());
  SilentProgress progress;
  const auto flight = flight::ReadFlight(*files, {}, progress);
  if (!flight) Fail("skyquilt reckon", flight.error());
  for (const std::string& warning : flight::InWords(flight->warnings))
    fmt::print(stderr, "Warning: {}\n", warning);
  const auto joined = poses::JoinLogs(flight->logs, flight->photos);
  if (!joined) {
    Fail("skyquilt reckon",
         {ErrorCode::kUnprocessable,
          "None of the files is a flight log. Give a DataFlash, ULog or telemetry log.", ""});
  }
  const std::vector<poses::Capture> captures = CapturesOf(joined->log, *flight, arguments.every_s);
  const auto reckoning = poses::ReckonBetween(joined->log, captures);
  if (!reckoning) Fail("skyquilt reckon", reckoning.error());
  fmt::print("{}: {}, {}\n{}", joined->log.file_name, Counted(joined->log.imu.size(), "inertial sample"),
             captures.size(), TableText(*reckoning));
  if (!arguments.table.empty()) Write(arguments.table, Csv(*reckoning));
  if (!arguments.plot.empty()) Write(arguments.plot, ReckoningSvg(*reckoning, joined->log.file_name));
}

}  // namespace

void AddReckonCommand(CLI::App& app) {
  auto arguments = std::make_shared<ReckonArguments>();
  CLI::App* command = app.add_subcommand(
      "reckon", "Displacement and rotation between captures from a log's raw inertial samples");
  command
      ->add_option("IN", arguments->inputs, "A flight log, and the photos if there are any; files or folders")
      ->required()
      ->check(CLI::ExistingPath);
  command->add_option("--plot", arguments->plot, "Write a plot (SVG) to this file");
  command->add_option("--table", arguments->table, "Write the table (CSV) to this file");
  command
      ->add_option("--every", arguments->every_s,
                   "Seconds between the moments taken where there are no captures")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  command->footer(
      "The step from which Iz and Unel place pictures, with gravity, attitude and true sample times: integrated by the\n"
      "trapezoid and by Simpson's rule, beside what GNSS and the autopilot recorded. Drift: horizontal distance from the\n"
      "recorded displacement; over 10, 30 and 60 s in flight with the autopilot's attitude.\n"
      "Example:\n  skyquilt reckon flight.BIN DCIM --plot reckon.svg");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace skyquilt::server
