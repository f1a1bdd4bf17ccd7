#include "core/render/exposure/extend_exposure.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/median.h"
#include "core/render/exposure/exposure_samples.h"

namespace skyquilt::render {
namespace {

constexpr std::size_t kFewSpots = 8;  // say nothing of a gain
constexpr double kMaxLogGain = 1.2;

// What the map shows of a sample under a tone, as a logarithm.
double Shown(const ExposureSample& sample, const PhotoTone& tone, std::size_t channel) {
  return sample.log_value[channel] + std::log(tone.gain[channel]) -
         std::log(tone.vignetting.Falloff(sample.radius_squared));
}

}  // namespace

ExposureModel ExtendExposure(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                             const std::vector<Thumbnail>& thumbnails, const std::vector<PhotoTone>& known) {
  ExposureModel model{known};
  if (known.size() == flight.photos.size()) return model;
  const std::vector<ExposureSample> samples = SampleExposure(flight, ground, thumbnails);
  for (std::size_t added = known.size(); added < flight.photos.size(); ++added) {
    PhotoTone tone;
    for (std::size_t other = 0; other < known.size(); ++other) {
      if (flight.photos[other].photo.camera_key != flight.photos[added].photo.camera_key) continue;
      tone.vignetting = known[other].vignetting;
      break;
    }
    for (std::size_t channel = 0; channel < 3; ++channel) {
      std::vector<double> brighter;  // the others' spots than this photo's
      for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
        const ExposureSample* own = nullptr;
        std::vector<double> shown;
        for (end = begin; end < samples.size() && samples[end].spot == samples[begin].spot; ++end) {
          if (samples[end].photo == added) own = &samples[end];
          if (samples[end].photo < added) {
            shown.push_back(Shown(samples[end], model.photos[samples[end].photo], channel));
          }
        }
        if (own != nullptr && !shown.empty()) brighter.push_back(Median(shown) - Shown(*own, tone, channel));
      }
      if (brighter.size() < kFewSpots) continue;
      tone.gain[channel] = std::exp(std::clamp(Median(std::move(brighter)), -kMaxLogGain, kMaxLogGain));
    }
    model.photos.push_back(tone);
  }
  return model;
}

}  // namespace skyquilt::render
