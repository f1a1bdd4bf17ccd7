#include "core/alignment/matching/appearance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/alignment/estimators/sampler.h"
#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/base/vector_clones.h"

namespace skyquilt::alignment {
namespace {

constexpr int kWords = 64;
constexpr int kFeaturesAPhoto = 400;
constexpr int kLearntFrom = 16384;  // descriptors
constexpr int kRounds = 8;
constexpr float kFullScale = 127.0F;

using Word = std::array<float, kDescriptorSize>;

SKYQUILT_VECTOR_CLONES float SquaredDistance(const float* __restrict word,
                                             const std::uint8_t* __restrict descriptor) {
  // Eight sums side by side: the order of summing is written down, so that every machine has the same.
  float sums[8] = {};
  for (int k = 0; k < kDescriptorSize; k += 8) {
    for (int lane = 0; lane < 8; ++lane) {
      const float apart = word[k + lane] - static_cast<float>(descriptor[k + lane]);
      sums[lane] += apart * apart;
    }
  }
  return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
}

int NearestWord(const std::vector<Word>& words, const Descriptor& descriptor) {
  int nearest = 0;
  float least = std::numeric_limits<float>::max();
  for (std::size_t w = 0; w < words.size(); ++w) {
    const float distance = SquaredDistance(words[w].data(), descriptor.data());
    if (distance < least) {
      least = distance;
      nearest = static_cast<int>(w);
    }
  }
  return nearest;
}

std::vector<const Descriptor*> Sample(const std::vector<const PhotoFeatures*>& features) {
  std::vector<const Descriptor*> all;
  for (const PhotoFeatures* photo : features) {
    if (!photo) continue;
    const std::size_t count = std::min<std::size_t>(kFeaturesAPhoto, photo->descriptors.size());
    for (std::size_t k = 0; k < count; ++k) all.push_back(&photo->descriptors[k]);
  }
  if (all.size() <= kLearntFrom) return all;
  Sampler sampler(1);
  std::vector<const Descriptor*> chosen;
  for (int k = 0; k < kLearntFrom; ++k) {
    chosen.push_back(all[sampler.Below(static_cast<int>(all.size()))]);
  }
  return chosen;
}

// Lloyd's rounds from a random start.
std::vector<Word> LearnWords(const std::vector<const Descriptor*>& samples, int threads) {
  std::vector<Word> words(std::min<std::size_t>(kWords, samples.size()));
  Sampler sampler(2);
  for (Word& word : words) {
    const Descriptor& start = *samples[sampler.Below(static_cast<int>(samples.size()))];
    std::copy(start.begin(), start.end(), word.begin());
  }
  std::vector<int> nearest(samples.size());
  constexpr std::size_t kChunk = 1024;
  for (int round = 0; round < kRounds; ++round) {
    ParallelFor((samples.size() + kChunk - 1) / kChunk, threads, [&](std::size_t chunk) {
      const std::size_t last = std::min(samples.size(), (chunk + 1) * kChunk);
      for (std::size_t s = chunk * kChunk; s < last; ++s) nearest[s] = NearestWord(words, *samples[s]);
    });
    std::vector<std::array<std::int64_t, kDescriptorSize>> sums(words.size(),
                                                                std::array<std::int64_t, kDescriptorSize>{});
    std::vector<int> members(words.size(), 0);
    for (std::size_t s = 0; s < samples.size(); ++s) {
      const int w = nearest[s];
      ++members[w];
      for (std::size_t k = 0; k < kDescriptorSize; ++k) sums[w][k] += (*samples[s])[k];
    }
    for (std::size_t w = 0; w < words.size(); ++w) {
      if (members[w] == 0) continue;
      for (std::size_t k = 0; k < kDescriptorSize; ++k) {
        words[w][k] = static_cast<float>(static_cast<double>(sums[w][k]) / members[w]);
      }
    }
  }
  return words;
}

std::vector<std::int8_t> Describe(const std::vector<Word>& words, const PhotoFeatures& photo) {
  std::vector<double> sums(words.size() * kDescriptorSize, 0.0);
  const std::size_t count = std::min<std::size_t>(kFeaturesAPhoto, photo.descriptors.size());
  for (std::size_t f = 0; f < count; ++f) {
    const Descriptor& descriptor = photo.descriptors[f];
    const int w = NearestWord(words, descriptor);
    for (std::size_t k = 0; k < kDescriptorSize; ++k) {
      sums[w * kDescriptorSize + k] += static_cast<double>(descriptor[k]) - static_cast<double>(words[w][k]);
    }
  }
  // Each word weighs alike, however often its texture repeats in the picture.
  std::vector<std::int8_t> bytes(sums.size(), 0);
  double largest = 0.0;
  for (std::size_t w = 0; w < words.size(); ++w) {
    double square = 0.0;
    for (std::size_t k = 0; k < kDescriptorSize; ++k)
      square += sums[w * kDescriptorSize + k] * sums[w * kDescriptorSize + k];
    if (square <= 0.0) continue;
    const double shrink = 1.0 / std::sqrt(square);
    for (std::size_t k = 0; k < kDescriptorSize; ++k) {
      sums[w * kDescriptorSize + k] *= shrink;
      largest = std::max(largest, std::abs(sums[w * kDescriptorSize + k]));
    }
  }
  if (largest <= 0.0) return bytes;
  for (std::size_t k = 0; k < sums.size(); ++k) {
    bytes[k] = static_cast<std::int8_t>(std::lround(sums[k] / largest * kFullScale));
  }
  return bytes;
}

SKYQUILT_VECTOR_CLONES std::int32_t Dot(const std::int8_t* __restrict a, const std::int8_t* __restrict b,
                                        std::size_t count) {
  std::int32_t sum = 0;
  for (std::size_t k = 0; k < count; ++k)
    sum += static_cast<std::int16_t>(a[k]) * static_cast<std::int16_t>(b[k]);
  return sum;
}

}  // namespace

Appearance Appearance::Learn(const std::vector<const PhotoFeatures*>& features, int threads) {
  Appearance appearance;
  appearance.vectors_.resize(features.size());
  appearance.lengths_.assign(features.size(), 0.0);
  const std::vector<const Descriptor*> samples = Sample(features);
  if (samples.empty()) return appearance;
  const std::vector<Word> words = LearnWords(samples, threads);
  ParallelFor(features.size(), threads, [&](std::size_t i) {
    if (!features[i]) return;
    std::vector<std::int8_t>& vector = appearance.vectors_[i] = Describe(words, *features[i]);
    appearance.lengths_[i] = std::sqrt(static_cast<double>(Dot(vector.data(), vector.data(), vector.size())));
  });
  return appearance;
}

std::vector<std::vector<int>> Appearance::MostAlike(int most, int threads) const {
  const int count = static_cast<int>(vectors_.size());
  std::vector<std::vector<int>> alike(vectors_.size());
  ParallelFor(vectors_.size(), threads, [&](std::size_t i) {
    if (lengths_[i] <= 0.0) return;
    std::vector<std::pair<double, int>> ranked;
    for (int j = 0; j < count; ++j) {
      if (j == static_cast<int>(i) || lengths_[j] <= 0.0) continue;
      const std::int32_t dot = Dot(vectors_[i].data(), vectors_[j].data(), vectors_[i].size());
      ranked.emplace_back(-(dot / (lengths_[i] * lengths_[j])), j);
    }
    alike[i] = LeastFew(std::move(ranked), most);
  });
  return alike;
}

}  // namespace skyquilt::alignment
