#include "core/render/exposure/estimate_exposure.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/render/exposure/exposure_samples.h"
#include "core/render/exposure/hot_spot.h"
#include "core/render/exposure/light_equations.h"

namespace skyquilt::render {
namespace {

constexpr double kMaxLogGain = 1.2;
constexpr std::size_t kFewSpots = 8;  // say nothing of an added photo's gain
// Cameras of fewer photos have no terms of their own, and only the ones with the most photos have: a folder
// of photos from everywhere must not make the equations large.
constexpr std::size_t kMinPhotos = 2, kMaxCameras = 16;
// Directions are trusted as far out as most samples look.
constexpr double kSamplesWithin = 0.99;
// Four times the light and a quarter of it: what photos show of it, their tone curve decides no longer.
constexpr double kMaxLogExposure = 1.4;
constexpr double kWidestLook = 1.7;  // 60 degrees
// Fields are wider than this share of a flight's height.
constexpr double kSpotReachOfHeight = 0.6;

// Each photo's recorded exposure against the usual one of its camera, as a natural logarithm; 0: not
// recorded.
std::vector<double> ExposuresOf(const alignment::AlignedFlight& flight) {
  std::map<std::string, std::vector<double>> of_camera;
  for (const auto& photo : flight.photos)
    if (photo.photo.exposure_log2) of_camera[photo.photo.camera_key].push_back(*photo.photo.exposure_log2);
  std::map<std::string, double> usual;
  for (auto& [key, exposures] : of_camera) usual.emplace(key, Median(std::move(exposures)));
  std::vector<double> exposures;
  for (const auto& photo : flight.photos) {
    const double log =
        photo.photo.exposure_log2
            ? std::numbers::ln2 * (*photo.photo.exposure_log2 - usual.at(photo.photo.camera_key))
            : 0.0;
    exposures.push_back(std::clamp(log, -kMaxLogExposure, kMaxLogExposure));
  }
  return exposures;
}

LightTerms TermsOf(const alignment::AlignedFlight& flight, const std::vector<ExposureSample>& samples) {
  LightTerms terms;
  terms.exposure_of_photo = ExposuresOf(flight);
  std::map<std::string, std::size_t> photos_of;
  for (const auto& photo : flight.photos) ++photos_of[photo.photo.camera_key];
  std::vector<std::pair<std::size_t, std::string>> cameras;
  for (const auto& [key, count] : photos_of) {
    if (count >= kMinPhotos) cameras.emplace_back(count, key);
  }
  std::stable_sort(cameras.begin(), cameras.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  cameras.resize(std::min(cameras.size(), kMaxCameras));
  std::map<std::string, std::size_t> number_of;
  for (const auto& [count, key] : cameras) {
    number_of.emplace(key, terms.cameras.size());
    terms.cameras.push_back(key);
  }
  for (const auto& photo : flight.photos) {
    const auto at = number_of.find(photo.photo.camera_key);
    terms.camera_of_photo.push_back(at == number_of.end() ? LightTerms::kNone : at->second);
  }
  std::vector<double> looks;
  looks.reserve(samples.size());
  for (const ExposureSample& sample : samples) looks.push_back(std::hypot(sample.look[0], sample.look[1]));
  const auto nth = looks.begin() + static_cast<std::ptrdiff_t>(kSamplesWithin * (looks.size() - 1.0));
  std::nth_element(looks.begin(), nth, looks.end());
  terms.directions.widest_look = std::clamp(*nth, 0.05, kWidestLook);
  return terms;
}

SpotsOnGround SpotsOf(const alignment::AlignedFlight& flight, const Eigen::Vector2d& look) {
  SpotsOnGround spots;
  std::vector<double> heights_m;
  for (const auto& photo : flight.photos) {
    const Eigen::Vector2d below_m = photo.cam_from_enu.TargetOriginInSource().head<2>();
    spots.middles_m.push_back(below_m + photo.height_above_ground_m * look);
    heights_m.push_back(photo.height_above_ground_m);
  }
  spots.reach_m = kSpotReachOfHeight * Median(std::move(heights_m));
  return spots;
}

}  // namespace

ExposureModel EstimateExposure(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                               const std::vector<Thumbnail>& thumbnails) {
  ExposureModel model = ExposureModel::Even(flight.photos.size());
  const std::vector<ExposureSample> samples = SampleExposure(flight, ground, thumbnails);
  if (samples.empty()) return model;
  LightTerms terms = TermsOf(flight, samples);
  constexpr std::size_t kGreen = 1;
  terms.directions.hot_spot =
      FindHotSpot(samples, MisfitsOf(samples, kGreen, terms, SolveLight(samples, kGreen, terms)),
                  terms.directions.widest_look);
  const SpotsOnGround spots =
      terms.directions.hot_spot ? SpotsOf(flight, *terms.directions.hot_spot) : SpotsOnGround();
  bool is_spot_settled = false;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    SolvedLight solved = SolveLight(samples, channel, terms);
    if (terms.directions.hot_spot) {
      const std::vector<double> shares = SettleHotSpot(samples, channel, terms, spots, solved);
      for (std::size_t i = 0; i < shares.size(); ++i) model.photos[i].hot_spot[channel] = shares[i];
      is_spot_settled |= !solved.terms.segment<kSpotTerms>(kSmoothDirectionTerms).isZero(0.0);
    }
    const Eigen::VectorXd log_gains =
        solved.log_gains -
        solved.terms[LightTerms::kExposure] *
            Eigen::Map<const Eigen::VectorXd>(terms.exposure_of_photo.data(), solved.log_gains.size());
    const double mean = log_gains.mean();
    for (std::size_t i = 0; i < flight.photos.size(); ++i) {
      model.photos[i].gain[channel] =
          std::exp(std::clamp(log_gains[static_cast<Eigen::Index>(i)] - mean, -kMaxLogGain, kMaxLogGain));
    }
    std::copy_n(solved.terms.data(), kDirectionTerms, model.light.of_directions[channel].begin());
    for (std::size_t camera = 0; camera < terms.cameras.size(); ++camera) {
      std::copy_n(solved.terms.data() + LightTerms::OfCamera(camera), kCameraTerms,
                  model.light.cameras[terms.cameras[camera]][channel].begin());
    }
  }
  model.light.directions = terms.directions;
  if (!is_spot_settled) model.light.directions.hot_spot.reset();
  for (std::size_t i = 0; i < flight.photos.size(); ++i)
    model.tones[i] = ToneOf(model.light, model.photos[i], flight.photos[i]);
  return model;
}

namespace {

// What the map shows of a sample under a tone, as a logarithm.
double Shown(const ExposureSample& sample, const PhotoTone& tone, std::size_t channel) {
  return static_cast<double>(sample.log_value[channel]) + std::log(tone.gain[channel]) +
         std::log(tone.shade.At(static_cast<double>(sample.place[0]),
                                static_cast<double>(sample.place[1]))[channel]);
}

// By photo after the first `finished` ones, where the spots begin among the samples that it shows.
using SpotsOfAdded = std::vector<std::vector<std::size_t>>;

SpotsOfAdded SpotsShown(const std::vector<ExposureSample>& samples, std::size_t finished,
                        std::size_t photos) {
  SpotsOfAdded spots_of(photos - finished);
  for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
    end = EndOfSpot(samples, begin);
    for (std::size_t i = begin; i < end; ++i) {
      if (samples[i].photo >= finished) spots_of[samples[i].photo - finished].push_back(begin);
    }
  }
  return spots_of;
}

// The one next that shares most spots with the finished ones and those before it: whatever the order in which
// they were flown, their light follows from the map's.
std::vector<std::size_t> OrderOfAdded(const std::vector<ExposureSample>& samples, std::size_t finished,
                                      const SpotsOfAdded& spots_of) {
  std::vector<std::size_t> shared(spots_of.size(), 0), order;
  std::vector<bool> is_told(samples.size(), false), is_taken(spots_of.size(), false);
  const auto tell = [&](std::size_t begin) {
    if (is_told[begin]) return;
    is_told[begin] = true;
    for (std::size_t i = begin, end = EndOfSpot(samples, begin); i < end; ++i) {
      if (samples[i].photo >= finished) ++shared[samples[i].photo - finished];
    }
  };
  for (std::size_t begin = 0; begin < samples.size(); begin = EndOfSpot(samples, begin)) {
    if (samples[begin].photo < finished) tell(begin);
  }
  while (order.size() < spots_of.size()) {
    std::optional<std::size_t> next;
    for (std::size_t i = 0; i < spots_of.size(); ++i) {
      if (!is_taken[i] && (!next || shared[i] > shared[*next])) next = i;
    }
    is_taken[*next] = true;
    order.push_back(*next);
    for (const std::size_t begin : spots_of[*next]) tell(begin);
  }
  return order;
}

}  // namespace

ExposureModel ExtendExposure(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                             const std::vector<Thumbnail>& thumbnails, const KnownExposure& known) {
  ExposureModel model{known.light, known.photos, {}};
  const std::size_t finished = known.photos.size();
  model.photos.resize(flight.photos.size());
  for (std::size_t i = 0; i < flight.photos.size(); ++i)
    model.tones.push_back(ToneOf(known.light, model.photos[i], flight.photos[i]));
  if (finished == flight.photos.size()) return model;
  const std::vector<ExposureSample> samples = SampleExposure(flight, ground, thumbnails);
  const SpotsOfAdded spots_of = SpotsShown(samples, finished, flight.photos.size());
  std::vector<bool> is_evened(flight.photos.size(), false);
  std::fill_n(is_evened.begin(), finished, true);
  for (const std::size_t next : OrderOfAdded(samples, finished, spots_of)) {
    const std::size_t added = finished + next;
    PhotoTone& tone = model.tones[added];
    for (std::size_t channel = 0; channel < 3; ++channel) {
      std::vector<double> brighter;  // the others' spots than this photo's
      for (const std::size_t begin : spots_of[next]) {
        const ExposureSample* of_added = nullptr;
        std::vector<double> shown;
        for (std::size_t i = begin, end = EndOfSpot(samples, begin); i < end; ++i) {
          if (samples[i].photo == added) of_added = &samples[i];
          if (is_evened[samples[i].photo])
            shown.push_back(Shown(samples[i], model.tones[samples[i].photo], channel));
        }
        if (of_added != nullptr && !shown.empty())
          brighter.push_back(Median(shown) - Shown(*of_added, tone, channel));
      }
      if (brighter.size() < kFewSpots) continue;
      tone.gain[channel] = std::exp(std::clamp(Median(std::move(brighter)), -kMaxLogGain, kMaxLogGain));
    }
    model.photos[added].gain = tone.gain;
    is_evened[added] = true;
  }
  return model;
}

}  // namespace skyquilt::render
