#include "core/flight/aside/one_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "core/flight/aside/alike.h"
#include "core/flight/aside/aside.h"
#include "core/flight/aside/picture_name.h"
#include "core/geo/geodesic.h"

namespace skyquilt::flight {
namespace {

constexpr std::chrono::seconds kSameMoment{2};
constexpr double kSamePlaceM = 5.0;

// A camera of the flight, and its photos by index.
struct CameraOfFlight {
  Lens lens = Lens::kUnsaid;
  std::string mark;  // of the lens, in its photos' names
  std::string maker_and_model;
  std::optional<double> view;  // longer side by focal length
  double pixels = 0.0;
  std::string words;
  std::vector<std::size_t> photos;
};

// By the name only where nothing else tells.
Lens LensInUse(const Photo& photo, std::string_view mark) {
  if (photo.lens != Lens::kUnsaid) return photo.lens;
  if ((mark == "t" || mark == "ir") && PhotoPixels(photo) <= kMaxThermalPx) return Lens::kThermal;
  if (mark == "z") return Lens::kZoom;
  return mark == "w" || mark == "v" ? Lens::kWide : Lens::kUnsaid;
}

std::vector<CameraOfFlight> CamerasOf(const std::vector<Photo>& photos) {
  std::map<std::string, CameraOfFlight> cameras;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const Photo& photo = photos[i];
    if (!photo.band_name.empty()) continue;
    const std::string stem = PictureNameOf(photo.name).stem;
    const std::string mark(LensMark(stem));
    const Lens lens = LensInUse(photo, mark);
    const auto [shorter, longer] = std::minmax(photo.intrinsics.width_px, photo.intrinsics.height_px);
    // Calibrations of one model differ by some pixels.
    constexpr double kStep = 0.05;
    const bool is_known = photo.focal_source != FocalSource::kAssumed;
    const double view = longer / photo.intrinsics.MeanFocalPx();
    const std::string maker_and_model = photo.make + "|" + photo.model;
    CameraOfFlight& camera =
        cameras[fmt::format("{}|{}|{}|{}x{}|{}", maker_and_model, static_cast<int>(lens), mark, longer,
                            shorter, is_known ? std::lround(std::log(view) / kStep) : 0)];
    if (camera.photos.empty()) {
      camera.lens = lens;
      camera.mark = mark;
      camera.maker_and_model = maker_and_model;
      if (is_known) camera.view = view;
      camera.pixels = PhotoPixels(photo);
      camera.words = CameraInWords(photo, lens);
    }
    camera.photos.push_back(i);
  }
  std::vector<CameraOfFlight> all;
  for (auto& [key, camera] : cameras) all.push_back(std::move(camera));
  return all;
}

auto PreferenceOf(const CameraOfFlight& camera) {
  return std::tuple(camera.lens == Lens::kWide, camera.view.value_or(0.0), camera.pixels);
}

// However many cameras each kind is spread over.
bool IsOfThermalPictures(const std::vector<CameraOfFlight>& cameras) {
  std::size_t thermal = 0, visible = 0;
  for (const CameraOfFlight& camera : cameras)
    (camera.lens == Lens::kThermal ? thermal : visible) += camera.photos.size();
  return 9 * thermal > 10 * visible;
}

// The map's camera first, then those of its kind, of these those with most photos.
void PutInOrderOfUse(std::vector<CameraOfFlight>& cameras) {
  const bool is_thermal_map = IsOfThermalPictures(cameras);
  const auto is_of_kind = [&](const CameraOfFlight& camera) {
    return (camera.lens == Lens::kThermal) == is_thermal_map;
  };
  const auto use_of = [&](const CameraOfFlight& camera) {
    return std::tuple(is_of_kind(camera), camera.photos.size(), PreferenceOf(camera));
  };
  std::stable_sort(cameras.begin(), cameras.end(),
                   [&](const CameraOfFlight& a, const CameraOfFlight& b) { return use_of(a) > use_of(b); });
  const std::size_t most = cameras.front().photos.size();
  const auto rivals = std::find_if(cameras.begin(), cameras.end(), [&](const CameraOfFlight& camera) {
    return !is_of_kind(camera) || 10 * camera.photos.size() < 9 * most;
  });
  const auto best = std::max_element(
      cameras.begin(), rivals,
      [](const CameraOfFlight& a, const CameraOfFlight& b) { return PreferenceOf(a) < PreferenceOf(b); });
  std::rotate(cameras.begin(), best, best + 1);
}

// Cameras of a rig that are alike but for where they look stay together.
bool AreDifferent(const CameraOfFlight& a, const CameraOfFlight& b) {
  constexpr double kOtherView = 1.25, kOtherSize = 1.5;
  const auto differ = [](double one, double other, double factor) {
    return std::max(one, other) > factor * std::min(one, other);
  };
  return a.lens != b.lens || a.mark != b.mark || a.maker_and_model != b.maker_and_model ||
         (a.view && b.view && differ(*a.view, *b.view, kOtherView)) || differ(a.pixels, b.pixels, kOtherSize);
}

// False where both say where they look and it is not the same way.
bool LookTheSameWay(const Photo& a, const Photo& b) {
  if (!a.attitude || !b.attitude || a.attitude->kind != b.attitude->kind) return true;
  const auto axis = [](const RecordedAttitude& attitude) {
    return Eigen::Vector3d(std::cos(attitude.pitch_rad) * std::cos(attitude.yaw_rad),
                           std::cos(attitude.pitch_rad) * std::sin(attitude.yaw_rad),
                           std::sin(attitude.pitch_rad));
  };
  constexpr double kCosSameWay = 0.94;  // 20 degrees
  return axis(*a.attitude).dot(axis(*b.attitude)) >= kCosSameWay;
}

bool SaysWhereItLooks(const Photo& photo) {
  return photo.attitude && photo.attitude->kind == AttitudeKind::kGimbal;
}

// By all but the focal length one camera: of an oblique rig the one that looks down has another.
bool MayBeOfOneRig(const CameraOfFlight& a, const CameraOfFlight& b) {
  return a.lens == b.lens && a.mark == b.mark && a.maker_and_model == b.maker_and_model;
}

// The photos that stay, by moment and by name.
class StayingPhotos {
 public:
  StayingPhotos(const std::vector<Photo>& photos, const std::vector<CameraOfFlight>& cameras)
      : photos_(photos), cameras_(cameras) {}

  void Add(std::size_t camera) {
    for (const std::size_t i : cameras_[camera].photos) {
      if (photos_[i].captured_at) by_time_.emplace(*photos_[i].captured_at, std::pair(i, camera));
      by_stem_[WithoutLensMark(i, camera)].emplace_back(i, camera);
    }
  }

  // The camera that saw what most photos of `camera` show; nothing where most have a view of their own.
  std::optional<std::size_t> PartnerOf(std::size_t camera) const {
    std::map<std::size_t, std::size_t> shared;
    std::size_t all = 0, most = 0;
    std::optional<std::size_t> partner;
    for (const std::size_t i : cameras_[camera].photos) {
      const auto other = PartnerOfPhoto(i, camera);
      if (!other) continue;
      ++all;
      if (const std::size_t count = ++shared[*other]; count > most) most = count, partner = other;
    }
    return 2 * all > cameras_[camera].photos.size() ? partner : std::nullopt;
  }

 private:
  std::string WithoutLensMark(std::size_t photo, std::size_t camera) const {
    std::string stem = PictureNameOf(photos_[photo].name).stem;
    const std::string& mark = cameras_[camera].mark;
    if (!mark.empty()) stem.erase(stem.size() - mark.size() - 1);
    return stem;
  }

  std::optional<std::size_t> PartnerOfPhoto(std::size_t i, std::size_t camera) const {
    const Photo& photo = photos_[i];
    if (photo.captured_at) {
      std::size_t looked_at = 0;
      for (auto at = by_time_.lower_bound(*photo.captured_at - kSameMoment);
           at != by_time_.end() && at->first <= *photo.captured_at + kSameMoment && looked_at < kMaxLookedAt;
           ++at, ++looked_at) {
        const auto& [other, its_camera] = at->second;
        if (AreDifferent(cameras_[camera], cameras_[its_camera]) &&
            AreAtOnePlace(photo, camera, other, its_camera))
          return its_camera;
      }
    }
    const auto found = by_stem_.find(WithoutLensMark(i, camera));
    if (found == by_stem_.end()) return std::nullopt;
    for (std::size_t k = 0; k < std::min(found->second.size(), kMaxLookedAt); ++k) {
      const auto& [other, its_camera] = found->second[k];
      const std::string &mark = cameras_[camera].mark, &its_mark = cameras_[its_camera].mark;
      if (!mark.empty() && !its_mark.empty() && mark != its_mark && AreOfOneShutter(photo, photos_[other]))
        return its_camera;
    }
    return std::nullopt;
  }

  // Of one moment. Without positions only lenses that the maker tells apart are known to be of one aircraft.
  bool AreAtOnePlace(const Photo& photo, std::size_t camera, std::size_t other,
                     std::size_t its_camera) const {
    const Photo& staying = photos_[other];
    if (photo.captured_at_is_local != staying.captured_at_is_local || !LookTheSameWay(photo, staying))
      return false;
    if (MayBeOfOneRig(cameras_[camera], cameras_[its_camera]) &&
        !(SaysWhereItLooks(photo) && SaysWhereItLooks(staying)))
      return false;
    if (photo.position && staying.position)
      return geo::MetresApart(photo.position->position, staying.position->position) <= kSamePlaceM;
    return cameras_[camera].maker_and_model == cameras_[its_camera].maker_and_model &&
           photo.lens != Lens::kUnsaid && staying.lens != Lens::kUnsaid && photo.lens != staying.lens;
  }

  // Named alike but for the lens, and nothing says otherwise: numbers begin anew on each card.
  static bool AreOfOneShutter(const Photo& a, const Photo& b) {
    constexpr std::chrono::minutes kOneName{1};
    constexpr double kOneNameM = 100.0;
    if (!LookTheSameWay(a, b)) return false;
    if (a.captured_at && b.captured_at && a.captured_at_is_local == b.captured_at_is_local &&
        std::chrono::abs(*a.captured_at - *b.captured_at) > kOneName)
      return false;
    return !a.position || !b.position ||
           geo::MetresApart(a.position->position, b.position->position) <= kOneNameM;
  }

  const std::vector<Photo>& photos_;
  const std::vector<CameraOfFlight>& cameras_;
  std::multimap<UtcTime, std::pair<std::size_t, std::size_t>> by_time_;
  std::unordered_map<std::string, std::vector<std::pair<std::size_t, std::size_t>>> by_stem_;
};

}  // namespace

void KeepOneCamera(Flight& flight) {
  std::vector<CameraOfFlight> cameras = CamerasOf(flight.photos);
  if (cameras.size() < 2) return;
  PutInOrderOfUse(cameras);
  const bool is_thermal_map = cameras.front().lens == Lens::kThermal;
  StayingPhotos staying(flight.photos, cameras);
  staying.Add(0);
  std::vector<bool> lies_aside(flight.photos.size());
  std::map<std::tuple<Aside, std::string, std::string>, std::size_t> said;  // of how many pictures
  for (std::size_t k = 1; k < cameras.size(); ++k) {
    const bool is_thermal = cameras[k].lens == Lens::kThermal;
    const bool is_other_kind = is_thermal != is_thermal_map;
    const auto partner = is_other_kind ? std::optional<std::size_t>(0) : staying.PartnerOf(k);
    if (!partner) {
      staying.Add(k);
      continue;
    }
    const Aside why = !is_other_kind ? Aside::kOtherCamera : is_thermal ? Aside::kThermal : Aside::kVisible;
    const std::string& instead = cameras[*partner].words;
    for (const std::size_t i : cameras[k].photos) {
      lies_aside[i] = true;
      flight.left_out.push_back(LeftAside(flight.photos[i].name, why, cameras[k].words, instead));
    }
    said[{why, cameras[k].words, instead}] += cameras[k].photos.size();
  }
  if (said.empty()) return;
  constexpr std::size_t kMaxSaid = 5;
  std::size_t cameras_said = 0;
  for (const auto& [words, pictures] : said) {
    if (++cameras_said > kMaxSaid) break;
    const auto& [why, of, instead] = words;
    const RemarkCode code = why == Aside::kOtherCamera ? RemarkCode::kOtherCameraAside
                            : why == Aside::kThermal   ? RemarkCode::kThermalAside
                                                       : RemarkCode::kVisibleAside;
    flight.warnings.push_back({code, {{"pictures", pictures}, {"camera", of}, {"instead", instead}}});
  }
  std::size_t k = 0;
  std::erase_if(flight.photos, [&](const Photo&) { return lies_aside[k++]; });
  std::sort(flight.left_out.begin(), flight.left_out.end(),
            [](const LeftOutPhoto& a, const LeftOutPhoto& b) { return a.name < b.name; });
}

}  // namespace skyquilt::flight
