#include "core/bands/captures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <filesystem>
#include <limits>
#include <set>
#include <string_view>
#include <utility>

#include "core/bands/mend_sunlight.h"
#include "core/base/check.h"
#include "core/base/parallel_for.h"
#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "core/flight/aside/one_camera.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::bands {
namespace {

using flight::Flight;
using flight::Photo;

// The shutters of one capture, where no id ties them together.
constexpr std::chrono::milliseconds kOneCapture{500};

// Of a photo that names its band; nothing for others.
std::vector<std::optional<Result<BandFacts>>> ReadAllFacts(const std::vector<Photo>& photos, int threads) {
  std::vector<std::optional<Result<BandFacts>>> facts(photos.size());
  ParallelFor(photos.size(), threads, [&](std::size_t i) {
    if (photos[i].band_name.empty()) return;
    facts[i] = [&]() -> Result<BandFacts> {
      SKYQUILT_TRY_ASSIGN(auto source, flight::OpenFileBytes(photos[i].path));
      return ReadBandFacts(*source);
    }();
  });
  return facts;
}

// Where a photo came from: captures never mix cameras. The cameras of a rig may have models of their own.
std::string RigOf(const BandPhoto& photo) {
  return photo.photo.make + "|" + (photo.facts.rig.empty() ? photo.photo.model : photo.facts.rig);
}

// How much of two names is the same, from both ends: of "1/IMG_7.tif" and "2/IMG_7.tif" more than of the
// latter and "1/IMG_8.tif", of "IMG_7_1.tif" and "IMG_7_2.tif" more than of the latter and "IMG_8_1.tif".
std::size_t Likeness(const std::string& a, const std::string& b) {
  const auto front = std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin();
  const auto back = std::mismatch(a.rbegin(), a.rend(), b.rbegin(), b.rend()).first - a.rbegin();
  return static_cast<std::size_t>(front + back);
}

// Photos in the order of the flight to captures, by id, else by time: where clocks show whole seconds,
// several captures may be of one, and names tell which of them a photo belongs to.
std::vector<Capture> Grouped(std::vector<BandPhoto> photos) {
  struct Open {
    std::size_t capture = 0;
    std::optional<flight::UtcTime> since;
    std::set<std::string> bands;
    std::string name;  // of its first photo
  };
  constexpr std::size_t kMaxOpen = 64;  // of one second, however fast the camera
  std::vector<Capture> captures;
  std::map<std::string, std::deque<Open>> open_by_key;  // rig and id; the latest first
  for (BandPhoto& photo : photos) {
    const bool has_id = !photo.facts.capture_id.empty();
    std::deque<Open>& open = open_by_key[RigOf(photo) + "|" + photo.facts.capture_id];
    const auto is_of_its_time = [&](const Open& one) {
      const auto& at = photo.photo.captured_at;
      return has_id || (one.since && at && *at - *one.since <= kOneCapture);
    };
    Open* joined = nullptr;
    std::size_t most_alike = 0;
    for (Open& one : open) {
      if (one.bands.contains(photo.facts.name) || !is_of_its_time(one)) continue;
      const std::size_t likeness = Likeness(one.name, photo.photo.name);
      if (joined != nullptr && likeness <= most_alike) continue;
      joined = &one;
      most_alike = likeness;
    }
    if (joined == nullptr) {
      captures.emplace_back();
      open.push_front({captures.size() - 1, photo.photo.captured_at, {}, photo.photo.name});
      if (open.size() > kMaxOpen) open.pop_back();
      joined = &open.front();
    }
    joined->bands.insert(photo.facts.name);
    captures[joined->capture].photos.push_back(std::move(photo));
  }
  return captures;
}

std::string ReferenceBand(const std::vector<Capture>& captures) {
  std::map<std::string, int> counts;
  for (const Capture& capture : captures) {
    // Thermal pictures are coarse: others are placed by them only where there are no others.
    for (const BandPhoto& photo : capture.photos)
      counts[photo.facts.name] += photo.facts.name == kThermalBand ? 0 : 1;
  }
  std::string best;
  std::pair<int, int> best_rank{std::numeric_limits<int>::max(), 0};
  for (const auto& [name, count] : counts) {
    const std::pair rank{-count, AlignRank(name)};
    if (rank < best_rank) best = name, best_rank = rank;
  }
  return best;
}

// Where a band stands among the others; of known ones that do not say their wavelength by the usual one.
double OrderNm(const Band& band) {
  constexpr std::array<std::pair<std::string_view, double>, 6> kUsualNm = {{{"blue", 475.0},
                                                                            {"green", 560.0},
                                                                            {"red", 660.0},
                                                                            {"rededge", 720.0},
                                                                            {"nir", 840.0},
                                                                            {kThermalBand, 10'000.0}}};
  if (band.wavelength_nm) return *band.wavelength_nm;
  const auto* const usual = std::find_if(kUsualNm.begin(), kUsualNm.end(),
                                         [&](const auto& known) { return known.first == band.name; });
  return usual == kUsualNm.end() ? std::numeric_limits<double>::infinity() : usual->second;
}

std::vector<Band> BandsOf(const std::vector<Capture>& captures) {
  struct Seen {
    Band band;
    std::map<Calibration, std::pair<int, std::string>> calibrations;  // photos, and by what method
  };
  std::map<std::string, Seen> by_name;
  for (const Capture& capture : captures) {
    for (const BandPhoto& photo : capture.photos) {
      const BandFacts& facts = photo.facts;
      Seen& seen = by_name[facts.name];
      seen.band.name = facts.name;
      if (!seen.band.wavelength_nm) seen.band.wavelength_nm = facts.wavelength_nm;
      if (!seen.band.width_nm) seen.band.width_nm = facts.width_nm;
      auto& [count, method] = seen.calibrations[facts.radiometry.calibration];
      if (count++ == 0) method = facts.radiometry.method;
    }
  }
  std::vector<Band> bands;
  for (auto& [name, seen] : by_name) {
    int most = 0;
    for (const auto& [calibration, counted] : seen.calibrations) {
      if (counted.first < most) continue;
      most = counted.first;
      seen.band.calibration = calibration;
      seen.band.method = counted.second;
    }
    bands.push_back(std::move(seen.band));
  }
  std::stable_sort(bands.begin(), bands.end(),
                   [](const Band& a, const Band& b) { return OrderNm(a) < OrderNm(b); });
  return bands;
}

// Values of one band must mean the same in all of its photos. A reference is placed all the same.
void DropOddCalibrations(const std::vector<Band>& bands, std::vector<Capture>& captures, Flight& flight) {
  std::map<std::string, Calibration> usual;
  for (const Band& band : bands) usual[band.name] = band.calibration;
  std::size_t dropped = 0;
  for (Capture& capture : captures) {
    dropped += std::erase_if(capture.photos, [&](const BandPhoto& photo) {
      return photo.facts.radiometry.calibration != usual.at(photo.facts.name);
    });
  }
  if (dropped == 0) return;
  flight.warnings.push_back({flight::RemarkCode::kBandsOddlyCalibrated, {{"photos", dropped}}});
}

// Thermal levels that nobody can make temperatures of.
bool IsOfUnknownScale(const BandFacts& facts) {
  return facts.name == kThermalBand && facts.radiometry.calibration != Calibration::kKelvin;
}

// A thermal camera's JPEG without temperatures still is a picture: it stays in the flight as one, unless the
// map is made of visible pictures.
void KeepLooks(std::vector<std::optional<Result<BandFacts>>>& facts, Flight& flight) {
  std::size_t kept = 0;
  std::string reason;
  for (std::size_t i = 0; i < facts.size(); ++i) {
    auto& one = facts[i];
    if (!one || !one->ok() || !(**one).is_look_too || !IsOfUnknownScale(**one)) continue;
    if (kept++ == 0) reason = (**one).radiometry.method;
    flight.photos[i].band_name.clear();
    one.reset();
  }
  if (kept == 0) return;
  flight.warnings.push_back({flight::RemarkCode::kNoTemperatures, {{"photos", kept}, {"why_words", reason}}});
  std::map<std::filesystem::path, std::optional<Result<BandFacts>>> by_path;
  for (std::size_t i = 0; i < facts.size(); ++i) by_path[flight.photos[i].path] = std::move(facts[i]);
  flight::KeepOneCamera(flight);
  facts.clear();
  for (const Photo& photo : flight.photos) facts.push_back(std::move(by_path[photo.path]));
}

// What the names of a capture's pictures have in common before what names their bands: "SIM_0001" of
// SIM_0001_1.tif and SIM_0001_2.tif. Nothing where a band's number is the counter's last digit.
std::string NameOfCapture(const Capture& capture) {
  if (capture.photos.size() < 2) return "";
  std::string common = capture.photos.front().photo.name;
  for (const BandPhoto& photo : capture.photos) {
    const std::string& name = photo.photo.name;
    const auto apart = std::mismatch(common.begin(), common.end(), name.begin(), name.end()).first;
    common.erase(apart, common.end());
  }
  const std::size_t end = common.find_last_not_of(" -_.") + 1;
  return end < common.size() ? common.substr(0, end) : "";
}

// Lists may name any of a capture's pictures, or the capture.
std::vector<std::string> OtherNames(const Capture& capture) {
  std::vector<std::string> names;
  for (const BandPhoto& photo : capture.photos) {
    if (photo.photo.name != capture.reference) names.push_back(photo.photo.name);
  }
  if (std::string name = NameOfCapture(capture); !name.empty()) names.push_back(std::move(name));
  return names;
}

// Rows on panels whose photo is not here, by the names that FindPanelRow knows photos by.
void SayUnknownPanels(Flight& flight) {
  std::set<std::string, std::less<>> known;
  for (const Photo& photo : flight.photos) known.insert(LowerCase(photo.name));
  for (const flight::LeftOutPhoto& photo : flight.left_out) known.insert(LowerCase(photo.name));
  const auto is_known = [&](std::string_view path) {
    while (!known.contains(path)) {
      const std::size_t slash = path.find('/');
      if (slash == std::string_view::npos) return false;
      path.remove_prefix(slash + 1);
    }
    return true;
  };
  for (const flight::ReflectanceList& list : flight.reflectance_lists) {
    std::size_t rows = 0;
    std::string first;
    for (const flight::PanelInPhoto& panel : list.panels) {
      if (!is_known(LowerCase(panel.photo)) && rows++ == 0) first = panel.photo;
    }
    if (rows == 0) continue;
    flight.warnings.push_back({flight::RemarkCode::kPanelRowsNameNoPhoto,
                               {{"file", list.file_name}, {"rows", rows}, {"first", first}}});
  }
}

// Captures that show a calibration panel, as the camera or a list says of one of their pictures.
void SetMarkedPanelsApart(Captures& apart, Flight& flight) {
  std::vector<bool> shows_panel;
  for (const Capture& capture : apart.captures) {
    shows_panel.push_back(std::any_of(capture.photos.begin(), capture.photos.end(),
                                      [](const BandPhoto& photo) { return photo.facts.is_panel; }));
  }
  if (!SetPanelsApart(shows_panel, apart, flight)) {
    flight.warnings.push_back(
        {flight::RemarkCode::kEveryCaptureAPanel, {{"file", std::string(flight::kReflectanceListName)}}});
  }
}

double MiddleOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2.0;
}

}  // namespace

bool SetPanelsApart(const std::vector<bool>& shows_panel, Captures& apart, Flight& flight) {
  if (std::find(shows_panel.begin(), shows_panel.end(), false) == shows_panel.end())
    return shows_panel.empty();
  std::vector<Capture> ground;
  for (std::size_t i = 0; i < shows_panel.size(); ++i) {
    Capture& capture = apart.captures[i];
    if (!shows_panel[i]) {
      ground.push_back(std::move(capture));
      continue;
    }
    std::erase_if(flight.photos, [&](const Photo& photo) { return photo.name == capture.reference; });
    for (BandPhoto& photo : capture.photos) {
      flight.left_out.push_back(
          {photo.photo.name, ErrorCode::kUnprocessable, flight::RemarkCode::kLeftPanel});
      apart.panels.push_back(std::move(photo));
    }
  }
  apart.captures = std::move(ground);
  std::sort(flight.left_out.begin(), flight.left_out.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  return true;
}

Captures SetBandsApart(Flight& flight, int threads) {
  Captures apart;
  std::vector<std::optional<Result<BandFacts>>> facts = ReadAllFacts(flight.photos, threads);
  KeepLooks(facts, flight);
  std::set<std::string> names;
  for (const auto& one : facts) {
    if (one && one->ok() && !IsOfUnknownScale(**one)) names.insert((**one).name);
  }
  // A band alone is a grey picture, unless it has temperatures.
  if (names.size() < 2 && !names.contains(kThermalBand)) {
    for (const flight::ReflectanceList& list : flight.reflectance_lists)
      flight.warnings.push_back({flight::RemarkCode::kNoBandsForList, {{"file", list.file_name}}});
    return apart;
  }
  for (const flight::ReflectanceList& list : flight.reflectance_lists)
    apart.targets.insert(apart.targets.end(), list.targets.begin(), list.targets.end());
  SayUnknownPanels(flight);

  std::vector<BandPhoto> band_photos;
  std::vector<Photo> others;
  const auto leave_out = [&](const Photo& photo, ErrorCode code, flight::Remark reason) {
    flight.left_out.push_back({photo.name, code, std::move(reason)});
  };
  for (std::size_t i = 0; i < flight.photos.size(); ++i) {
    Photo& photo = flight.photos[i];
    if (!facts[i]) {
      others.push_back(std::move(photo));
    } else if (!facts[i]->ok()) {
      leave_out(photo, facts[i]->error().code, flight::WhyOf(facts[i]->error()));
    } else if (IsOfUnknownScale(**facts[i])) {
      leave_out(photo, ErrorCode::kUnsupportedFormat, flight::RemarkCode::kThermalOfUnknownScale);
    } else {
      band_photos.push_back({std::move(photo), **std::move(facts[i])});
      BandPhoto& taken = band_photos.back();
      taken.facts.is_panel |= flight::FindPanelRow(flight.reflectance_lists, taken.photo.name) != nullptr;
    }
  }
  apart.captures = Grouped(std::move(band_photos));
  SetMarkedPanelsApart(apart, flight);
  apart.reference_band = ReferenceBand(apart.captures);
  for (Capture& capture : apart.captures) {
    for (const BandPhoto& photo : capture.photos) {
      if (photo.facts.name == apart.reference_band) capture.reference = photo.photo.name;
    }
    if (!capture.reference.empty()) continue;
    for (const BandPhoto& photo : capture.photos) {
      leave_out(photo.photo, ErrorCode::kUnprocessable,
                {flight::RemarkCode::kCaptureWithoutReference, {{"band", apart.reference_band}}});
    }
  }
  std::erase_if(apart.captures, [](const Capture& capture) { return capture.reference.empty(); });
  apart.bands = BandsOf(apart.captures);
  std::map<std::string, std::size_t> place;
  for (std::size_t i = 0; i < apart.bands.size(); ++i) place[apart.bands[i].name] = i;
  flight.photos = std::move(others);
  for (Capture& capture : apart.captures) {
    std::stable_sort(capture.photos.begin(), capture.photos.end(),
                     [&](const BandPhoto& a, const BandPhoto& b) {
                       return place.at(a.facts.name) < place.at(b.facts.name);
                     });
    for (const BandPhoto& photo : capture.photos) {
      if (photo.photo.name != capture.reference) continue;
      flight.photos.push_back(photo.photo);
      flight.photos.back().other_names = OtherNames(capture);
    }
  }
  DropOddCalibrations(apart.bands, apart.captures, flight);
  MendSunlight(apart, flight.warnings);
  std::sort(flight.photos.begin(), flight.photos.end(), flight::ComesBefore);
  std::sort(flight.left_out.begin(), flight.left_out.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  return apart;
}

double ScaleBand(Captures& captures, const std::string& band, const WitnessedFactors& factors, HeldAgainst by,
                 const std::string& method, std::vector<flight::Remark>& warnings) {
  SKYQUILT_CHECK(!factors.by_group.empty(), "a band is scaled by what somebody says");
  std::map<std::string, double> by_group;
  std::vector<double> all;
  double apart = 0.0;
  for (const auto& [group, told] : factors.by_group) {
    const double factor = MiddleOf(told);
    const auto [least, most] = std::minmax_element(told.begin(), told.end());
    apart = std::max(apart, (*most - *least) / factor);
    by_group[group] = factor;
    all.insert(all.end(), told.begin(), told.end());
  }
  const double of_all = MiddleOf(std::move(all));
  constexpr double kDoubtedSpread = 0.1;
  if (apart > kDoubtedSpread) {
    warnings.push_back(
        {by == HeldAgainst::kPanel ? flight::RemarkCode::kPanelsApart : flight::RemarkCode::kTargetsApart,
         {{"band", band}, {"apart_percent", 100.0 * apart}}});
  }
  for (Capture& capture : captures.captures) {
    for (BandPhoto& photo : capture.photos) {
      if (photo.facts.name != band) continue;
      const auto own = by_group.find(factors.group_of ? factors.group_of(photo.photo) : std::string());
      photo.facts.radiometry.per_level *= own == by_group.end() ? of_all : own->second;
      photo.facts.radiometry.calibration = Calibration::kReflectance;
    }
  }
  for (Band& one : captures.bands) {
    if (one.name != band) continue;
    one.calibration = Calibration::kReflectance;
    one.method += (one.method.empty() ? "" : ", ") + method;
    one.held_against = by;
  }
  return of_all;
}

std::optional<flight::Remark> BandsHeldAgainstNothing(const Captures& captures) {
  std::vector<std::string> names;
  bool is_any_held = false;
  for (const Band& band : captures.bands) {
    if (band.calibration == Calibration::kKelvin) continue;
    if (band.held_against == HeldAgainst::kNothing) names.push_back(band.name);
    is_any_held |= band.held_against != HeldAgainst::kNothing;
  }
  if (names.empty() || !is_any_held) return std::nullopt;
  return flight::Remark(flight::RemarkCode::kBandsWithoutPanel,
                        {{"bands", fmt::format("{}", fmt::join(names, ", "))}});
}

std::optional<double> ReflectanceOf(const flight::KnownReflectance& known, const std::string& band) {
  for (const auto& [name, share] : known.bands) {
    if (BandNameOf(name) == band) return share;
  }
  return known.all;
}

}  // namespace skyquilt::bands
