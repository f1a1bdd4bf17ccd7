#include "server/commands/maps/reckon_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "core/geo/lat_lon.h"

namespace skyquilt::server {
namespace {

constexpr double kWidthPx = 900.0;
constexpr double kPanelPx = 200.0;
constexpr double kLeftPx = 70.0;
constexpr double kRightPx = 20.0;
constexpr double kTitlePx = 50.0;
constexpr double kGapPx = 55.0;
constexpr int kTicks = 5;

struct Series {
  const char* name;
  const char* color;
  std::vector<std::pair<double, double>> points;
  bool is_line = false;
};

struct Panel {
  std::string title;
  std::string x_title;
  std::vector<Series> series;
};

std::string Escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&') {
      safe += "&amp;";
    } else if (c == '<') {
      safe += "&lt;";
    } else {
      safe += c;
    }
  }
  return safe;
}

// 1, 2 or 5 times a power of ten, so that about kTicks of them cover the range.
double TickStep(double range) {
  const double rough = range / kTicks;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10.0 * power;
}

std::string PanelSvg(const Panel& panel, double top_px) {
  double x_min = 0.0, x_max = 1.0, y_max = 1e-9;
  bool is_first = true;
  for (const Series& series : panel.series) {
    for (const auto& [x, y] : series.points) {
      x_min = is_first ? x : std::min(x_min, x);
      x_max = is_first ? x : std::max(x_max, x);
      y_max = std::max(y_max, y);
      is_first = false;
    }
  }
  if (x_max <= x_min) x_max = x_min + 1.0;
  y_max *= 1.05;
  const double plot_width = kWidthPx - kLeftPx - kRightPx;
  const auto x_px = [&](double x) { return kLeftPx + plot_width * (x - x_min) / (x_max - x_min); };
  const auto y_px = [&](double y) { return top_px + kPanelPx * (1.0 - y / y_max); };
  std::string svg = fmt::format(
      "<text x=\"{:.0f}\" y=\"{:.0f}\" font-weight=\"bold\">{}</text>\n"
      "<rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"{:.0f}\" height=\"{:.0f}\" fill=\"none\" stroke=\"#888\"/>\n",
      kLeftPx, top_px - 8.0, panel.title, kLeftPx, top_px, plot_width, kPanelPx);
  const double y_step = TickStep(y_max);
  for (double y = 0.0; y <= y_max; y += y_step) {
    svg += fmt::format(
        "<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#ddd\"/>"
        "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{:g}</text>\n",
        kLeftPx, kLeftPx + plot_width, y_px(y), y_px(y), kLeftPx - 6.0, y_px(y) + 4.0, y);
  }
  const double x_step = TickStep(x_max - x_min);
  for (double x = std::ceil(x_min / x_step) * x_step; x <= x_max; x += x_step) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:g}</text>\n", x_px(x),
                       top_px + kPanelPx + 16.0, x);
  }
  svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"end\">{}</text>\n", kWidthPx - kRightPx,
                     top_px + kPanelPx + 32.0, panel.x_title);
  double legend_px = kWidthPx - kRightPx;
  for (auto series = panel.series.rbegin(); series != panel.series.rend(); ++series) {
    if (series->is_line) {
      std::string path;
      for (const auto& [x, y] : series->points) path += fmt::format("{:.1f},{:.1f} ", x_px(x), y_px(y));
      svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\"/>\n", path, series->color);
    } else {
      for (const auto& [x, y] : series->points) {
        svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.5\" fill=\"{}\"/>\n", x_px(x), y_px(y),
                           series->color);
      }
    }
    svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"end\" fill=\"{}\">{}</text>\n",
                       legend_px, top_px - 8.0, series->color, series->name);
    legend_px -= 90.0;
  }
  return svg;
}

using ValueOf = std::function<double(const poses::ReckonedInterval&)>;

Series SeriesOf(const poses::Reckoning& reckoning, const char* name, const char* color, bool is_line,
                const ValueOf& value) {
  Series series{name, color, {}, is_line};
  const double start_s = reckoning.intervals.front().from_s;
  for (const poses::ReckonedInterval& interval : reckoning.intervals) {
    series.points.emplace_back(interval.to_s - start_s, value(interval));
  }
  return series;
}

constexpr const char* kRecordColor = "#555";
constexpr const char* kTrapezoidColor = "#06c";
constexpr const char* kSimpsonColor = "#d50";

}  // namespace

std::string ReckoningSvg(const poses::Reckoning& reckoning, const std::string& title) {
  using Interval = poses::ReckonedInterval;
  std::vector<Panel> panels;
  if (!reckoning.intervals.empty()) {
    const char* seconds = "seconds since the first capture";
    panels.push_back({"Displacement between captures, m",
                      seconds,
                      {SeriesOf(reckoning, "GNSS", kRecordColor, true,
                                [](const Interval& i) { return i.recorded_displacement_in_enu_m.norm(); }),
                       SeriesOf(reckoning, "trapezoid", kTrapezoidColor, false,
                                [](const Interval& i) { return i.trapezoid.displacement_in_enu_m.norm(); }),
                       SeriesOf(reckoning, "Simpson", kSimpsonColor, false,
                                [](const Interval& i) { return i.simpson.displacement_in_enu_m.norm(); })}});
    panels.push_back({"Rotation between captures, degrees",
                      seconds,
                      {SeriesOf(reckoning, "autopilot", kRecordColor, true,
                                [](const Interval& i) { return geo::RadToDeg(i.recorded_rotation_rad); }),
                       SeriesOf(reckoning, "trapezoid", kTrapezoidColor, false,
                                [](const Interval& i) { return geo::RadToDeg(i.trapezoid.rotation_rad); }),
                       SeriesOf(reckoning, "Simpson", kSimpsonColor, false,
                                [](const Interval& i) { return geo::RadToDeg(i.simpson.rotation_rad); })}});
    panels.push_back({"Drift from GNSS, m",
                      seconds,
                      {SeriesOf(reckoning, "trapezoid", kTrapezoidColor, false,
                                [](const Interval& i) { return i.trapezoid.drift_m; }),
                       SeriesOf(reckoning, "Simpson", kSimpsonColor, false,
                                [](const Interval& i) { return i.simpson.drift_m; })}});
  }
  if (!reckoning.drifts.empty()) {
    Series trapezoid{"trapezoid", kTrapezoidColor, {{0.0, 0.0}}, true};
    Series simpson{"Simpson", kSimpsonColor, {{0.0, 0.0}}, true};
    for (const poses::ReckonedDrift& drift : reckoning.drifts) {
      trapezoid.points.emplace_back(drift.length_s, drift.trapezoid_rms_m);
      simpson.points.emplace_back(drift.length_s, drift.simpson_rms_m);
    }
    panels.push_back({"Drift over windows in flight with the autopilot's attitude, m (RMS)",
                      "seconds without positions",
                      {std::move(trapezoid), std::move(simpson)}});
  }
  const double height_px = kTitlePx + static_cast<double>(panels.size()) * (kPanelPx + kGapPx) + 10.0;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
      "<text x=\"{2:.0f}\" y=\"22\" font-size=\"15\">{3}</text>\n",
      kWidthPx, height_px, kLeftPx, Escaped(title));
  double top_px = kTitlePx;
  for (const Panel& panel : panels) {
    svg += PanelSvg(panel, top_px);
    top_px += kPanelPx + kGapPx;
  }
  return svg + "</svg>\n";
}

}  // namespace skyquilt::server
