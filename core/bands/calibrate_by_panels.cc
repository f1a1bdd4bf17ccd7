#include "core/bands/calibrate_by_panels.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <ratio>
#include <utility>

#include "core/bands/band_facts.h"
#include "core/bands/find_panel.h"
#include "core/base/result.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::bands {
namespace {

using flight::Flight;
using flight::PhotoSource;
using flight::RemarkCode;

// Captures without a panel behind which no more are looked for: panels are held before and after a flight, in
// as many pictures as somebody likes.
constexpr std::size_t kWithoutPanel = 2;
constexpr double kMaxSpread = 0.25;  // a panel is even: more is grass, or its rim
constexpr double kFarH = 2.0;        // later, the sun stands elsewhere

struct Measured {
  double factor = 1.0;
  std::string panel;  // its serial number, or how it is known
  const flight::Photo* photo = nullptr;
};

PanelArea AreaOfBox(const std::array<double, 4>& box) {
  return {Eigen::Vector2d(box[0], box[1]), Eigen::Vector2d(box[2], box[1]), Eigen::Vector2d(box[2], box[3]),
          Eigen::Vector2d(box[0], box[3])};
}

PanelArea AreaOfTags(const std::array<double, 8>& corners) {
  PanelArea area{};
  for (std::size_t k = 0; k < area.size(); ++k) area[k] = {corners[2 * k], corners[2 * k + 1]};
  return area;
}

Error NotUsed(flight::Remark why) { return flight::Because(ErrorCode::kUnprocessable, std::move(why)); }

// `usual`: what values of the band mean in the photos of the ground.
Result<Measured> MeasurePanel(const BandPhoto& panel, Calibration usual, const flight::PanelInPhoto* row,
                              const PhotoSource& source) {
  const BandFacts& facts = panel.facts;
  if (facts.radiometry.calibration == Calibration::kLevels) return NotUsed(RemarkCode::kPanelNotExposed);
  if (facts.radiometry.calibration != usual) {
    return NotUsed({RemarkCode::kPanelOtherValues,
                    {{"values_words", CalibrationName(facts.radiometry.calibration)},
                     {"others_words", CalibrationName(usual)}}});
  }
  SKYQUILT_TRY_ASSIGN(const image::SampleImage picture, source.DecodeSamples(panel.photo));
  std::optional<PanelArea> area;
  std::optional<double> reflectance = facts.panel.reflectance;
  std::string name = facts.panel.serial.empty() ? "panel" : facts.panel.serial;
  if (facts.panel.area_px) area = AreaOfTags(*facts.panel.area_px);
  if (row != nullptr) {
    if (row->box_px) area = AreaOfBox(*row->box_px);
    if (const auto known = ReflectanceOf(row->reflectance, facts.name)) reflectance = known;
  }
  if (!area || !reflectance) {
    if (const std::optional<FoundPanel> found = FindPanel(picture)) {
      if (!area) area = found->area_px;
      name = found->code.serial;
      if (!reflectance && facts.wavelength_nm) reflectance = found->code.ReflectanceAt(*facts.wavelength_nm);
    }
  }
  if (!area) {
    return NotUsed({RemarkCode::kPanelWithoutCode, {{"list", flight::kReflectanceListName}}});
  }
  if (!reflectance) {
    return NotUsed({RemarkCode::kPanelUnknown, {{"panel", name}, {"list", flight::kReflectanceListName}}});
  }
  const std::optional<AreaLevels> levels = LevelsIn(picture, *area);
  if (!levels) return NotUsed(RemarkCode::kPanelTooSmall);
  if (levels->clipped_share > kMaxClippedShare) return NotUsed(RemarkCode::kPanelOverexposed);
  if (levels->spread > kMaxSpread) return NotUsed(RemarkCode::kPanelUneven);
  const std::optional<double> value = MedianIn(ValuesOf(picture, facts.radiometry), *area);
  if (!value || !(*value > 0.0)) return NotUsed(RemarkCode::kPanelBlack);
  return Measured{*reflectance / *value, name, &panel.photo};
}

// By the code in its reference's picture.
bool ShowsPanel(const Capture& capture, const PhotoSource& source) {
  const auto reference =
      std::find_if(capture.photos.begin(), capture.photos.end(),
                   [&](const BandPhoto& photo) { return photo.photo.name == capture.reference; });
  if (reference == capture.photos.end() || reference->facts.name == kThermalBand) return false;
  const Result<image::SampleImage> picture = source.DecodeSamples(reference->photo);
  return picture.ok() && FindPanel(*picture).has_value();  // damaged ones are told of when placed
}

// Captures at both ends of a flight that show a panel become pictures of panels.
void SearchPanels(Flight& flight, Captures& captures, const PhotoSource& source) {
  const std::size_t total = captures.captures.size();
  std::vector<bool> shows_panel(total, false), is_searched(total, false);
  for (const bool is_from_the_last : {false, true}) {
    std::size_t without = 0;
    for (std::size_t k = 0; k < total && without < kWithoutPanel; ++k) {
      const std::size_t i = is_from_the_last ? total - 1 - k : k;
      if (is_searched[i]) break;
      is_searched[i] = true;
      shows_panel[i] = ShowsPanel(captures.captures[i], source);
      without = shows_panel[i] ? 0 : without + 1;
    }
  }
  if (!SetPanelsApart(shows_panel, captures, flight)) {
    flight.warnings.push_back(RemarkCode::kAllShowPanels);
  }
}

std::vector<const flight::Photo*> PhotosOf(const Captures& captures, const std::string& band) {
  std::vector<const flight::Photo*> photos;
  for (const Capture& capture : captures.captures) {
    for (const BandPhoto& photo : capture.photos) {
      if (photo.facts.name == band) photos.push_back(&photo.photo);
    }
  }
  return photos;
}

// To the nearest of others; nothing where clocks do not tell.
std::optional<double> HoursToNearest(const flight::Photo& photo,
                                     const std::vector<const flight::Photo*>& others) {
  using Hours = std::chrono::duration<double, std::ratio<3600>>;
  std::optional<double> nearest_h;
  for (const flight::Photo* other : others) {
    if (!photo.captured_at || !other->captured_at ||
        photo.captured_at_is_local != other->captured_at_is_local)
      continue;
    const double apart_h = std::abs(Hours(*photo.captured_at - *other->captured_at).count());
    if (!nearest_h || apart_h < *nearest_h) nearest_h = apart_h;
  }
  return nearest_h;
}

// Pictures of another day than the photos of the ground go where there are some of theirs; says how many.
std::size_t DropOtherDays(const std::vector<const flight::Photo*>& ground, std::vector<Measured>& pictures) {
  constexpr double kOneDayH = 12.0;
  const auto is_of_another_day = [&](const Measured& picture) {
    return HoursToNearest(*picture.photo, ground).value_or(0.0) > kOneDayH;
  };
  if (std::all_of(pictures.begin(), pictures.end(), is_of_another_day)) return 0;
  return std::erase_if(pictures, is_of_another_day);
}

// Where the pictures of one day end and those of the next begin.
std::vector<flight::UtcTime> EndsOfDays(const std::vector<const flight::Photo*>& pictures) {
  constexpr std::chrono::hours kNight{12};
  std::vector<flight::UtcTime> times, ends;
  for (const flight::Photo* picture : pictures) {
    if (picture->captured_at) times.push_back(*picture->captured_at);
  }
  std::sort(times.begin(), times.end());
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k] - times[k - 1] > kNight) ends.push_back(times[k - 1] + (times[k] - times[k - 1]) / 2);
  }
  return ends;
}

// The camera, and the day among those of its panels; without a clock none of several.
std::string GroupOf(const flight::Photo& photo, const std::vector<flight::UtcTime>& ends) {
  if (!photo.captured_at) return photo.camera_key + (ends.empty() ? "|0" : "|");
  return fmt::format("{}|{}", photo.camera_key,
                     std::upper_bound(ends.begin(), ends.end(), *photo.captured_at) - ends.begin());
}

// What is doubtful in how photos of the ground are held against pictures of panels.
struct Doubts {
  double farthest_h = 0.0;
  std::size_t of_other_cameras = 0;
};

void ApplyPanels(std::vector<Measured> pictures, const std::string& band, Flight& flight, Captures& captures,
                 Doubts& doubts) {
  const std::vector<const flight::Photo*> ground = PhotosOf(captures, band);
  const std::size_t dropped = DropOtherDays(ground, pictures);
  WitnessedFactors factors;
  std::map<std::string, std::vector<const flight::Photo*>> by_camera;
  std::vector<const flight::Photo*> all;
  const auto values = std::find_if(captures.bands.begin(), captures.bands.end(),
                                   [&](const Band& one) { return one.name == band; });
  // It knows how the light changes.
  const bool has_light_sensor = values->calibration != Calibration::kRadiance;
  for (const Measured& picture : pictures) {
    by_camera[picture.photo->camera_key].push_back(picture.photo);
    all.push_back(picture.photo);
  }
  bool has_several_days = false;
  std::map<std::string, std::vector<flight::UtcTime>> ends_by_camera;
  for (const auto& [camera, of_camera] : by_camera) {
    const auto& ends = ends_by_camera[camera] = EndsOfDays(of_camera);
    has_several_days |= !ends.empty();
  }
  factors.group_of = [&](const flight::Photo& photo) {
    return GroupOf(photo, ends_by_camera[photo.camera_key]);
  };
  for (const Measured& picture : pictures)
    factors.by_group[factors.group_of(*picture.photo)].push_back(picture.factor);
  for (const flight::Photo* photo : ground) {
    const auto own = by_camera.find(photo->camera_key);
    const bool is_of_other = own == by_camera.end();
    if (is_of_other) ++doubts.of_other_cameras;
    if (has_light_sensor) continue;
    const auto nearest_h = HoursToNearest(*photo, is_of_other ? all : own->second);
    doubts.farthest_h = std::max(doubts.farthest_h, nearest_h.value_or(0.0));
  }
  std::string method = fmt::format("by {} picture{} of {}", pictures.size(), pictures.size() == 1 ? "" : "s",
                                   pictures.front().panel);
  if (dropped > 0) method += fmt::format(" without {} of another day", dropped);
  if (has_several_days) method += ", each day by its own";
  ScaleBand(captures, band, factors, HeldAgainst::kPanel, method, flight.warnings);
}

}  // namespace

void CalibrateByPanels(Flight& flight, Captures& captures, const PhotoSource& source) {
  if (captures.empty()) return;
  SearchPanels(flight, captures, source);  // a camera that marked one picture may have missed another
  if (captures.panels.empty()) return;
  std::map<std::string, std::vector<Measured>> by_band;
  std::size_t unused = 0;
  std::map<std::string, flight::RemarkValue> first_unused;
  for (const BandPhoto& panel : captures.panels) {
    const auto band = std::find_if(captures.bands.begin(), captures.bands.end(),
                                   [&](const Band& one) { return one.name == panel.facts.name; });
    // Kelvins need no panel, and of a band that the ground was not seen in there is nothing to scale.
    if (band == captures.bands.end() || band->calibration == Calibration::kKelvin) continue;
    Result<Measured> measured = MeasurePanel(
        panel, band->calibration, flight::FindPanelRow(flight.reflectance_lists, panel.photo.name), source);
    if (measured) {
      by_band[panel.facts.name].push_back(*std::move(measured));
    } else if (unused++ == 0) {
      first_unused = {{"photo", panel.photo.name}, {"why", flight::WhyOf(measured.error())}};
    }
  }
  if (unused > 0) {
    first_unused.emplace("pictures", unused);
    flight.warnings.push_back({RemarkCode::kPanelsUnused, first_unused});
  }
  Doubts doubts;
  for (const auto& [band, pictures] : by_band) ApplyPanels(pictures, band, flight, captures, doubts);
  if (doubts.of_other_cameras > 0) {
    flight.warnings.push_back({RemarkCode::kPanelOfOtherCamera, {{"photos", doubts.of_other_cameras}}});
  }
  if (doubts.farthest_h > kFarH) {
    flight.warnings.push_back({RemarkCode::kPanelFarInTime, {{"apart_h", doubts.farthest_h}}});
  }
}

}  // namespace skyquilt::bands
