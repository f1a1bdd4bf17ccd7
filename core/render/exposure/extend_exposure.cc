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
  return static_cast<double>(sample.log_value[channel]) + std::log(tone.gain[channel]) +
         std::log(tone.shade.At(static_cast<double>(sample.place[0]),
                                static_cast<double>(sample.place[1]))[channel]);
}

}  // namespace

ExposureModel ExtendExposure(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                             const std::vector<Thumbnail>& thumbnails, const KnownExposure& known) {
  ExposureModel model{known.light, known.photos, {}};
  for (std::size_t i = 0; i < known.photos.size(); ++i)
    model.tones.push_back(ToneOf(known.light, known.photos[i], flight.photos[i]));
  if (known.photos.size() == flight.photos.size()) return model;
  const std::vector<ExposureSample> samples = SampleExposure(flight, ground, thumbnails);
  for (std::size_t added = known.photos.size(); added < flight.photos.size(); ++added) {
    PhotoLight own;
    PhotoTone tone = ToneOf(known.light, own, flight.photos[added]);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      std::vector<double> brighter;  // the others' spots than this photo's
      for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
        const ExposureSample* of_added = nullptr;
        std::vector<double> shown;
        for (end = begin; end < samples.size() && samples[end].spot == samples[begin].spot; ++end) {
          if (samples[end].photo == added) of_added = &samples[end];
          if (samples[end].photo < added) {
            shown.push_back(Shown(samples[end], model.tones[samples[end].photo], channel));
          }
        }
        if (of_added != nullptr && !shown.empty())
          brighter.push_back(Median(shown) - Shown(*of_added, tone, channel));
      }
      if (brighter.size() < kFewSpots) continue;
      tone.gain[channel] = std::exp(std::clamp(Median(std::move(brighter)), -kMaxLogGain, kMaxLogGain));
    }
    own.gain = tone.gain;
    model.photos.push_back(own);
    model.tones.push_back(tone);
  }
  return model;
}

}  // namespace skyquilt::render
