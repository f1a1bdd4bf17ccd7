#include "core/surface/views/census.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/base/vector_clones.h"

namespace skyquilt::surface {
namespace {

constexpr std::size_t kChunk = 512;  // cells whose distances stay in the nearest cache
constexpr int kMaxKept = 3;

using Chunk = std::array<std::uint8_t, kChunk>;

// One byte of bits: around[b] is the first of the neighbours that bit b stands for.
SKYQUILT_VECTOR_CLONES void CensusByte(const std::uint8_t* center, const std::uint8_t* const* around,
                                       int count, std::uint8_t* __restrict bits) {
  const std::uint8_t *a = around[0], *b = around[1], *c = around[2], *d = around[3], *e = around[4],
                     *f = around[5], *g = around[6], *h = around[7];
  for (int i = 0; i < count; ++i) {
    const std::uint8_t middle = center[i];
    std::uint8_t byte = a[i] > middle ? 1 : 0;
    byte |= b[i] > middle ? 2 : 0;
    byte |= c[i] > middle ? 4 : 0;
    byte |= d[i] > middle ? 8 : 0;
    byte |= e[i] > middle ? 16 : 0;
    byte |= f[i] > middle ? 32 : 0;
    byte |= g[i] > middle ? 64 : 0;
    byte |= h[i] > middle ? 128 : 0;
    bits[i] = byte;
  }
}

// Words of eight cells, so that shifts are those of whole words.
SKYQUILT_VECTOR_CLONES void CountDifferent(const std::uint8_t* a, const std::uint8_t* b,
                                           std::size_t plane_size, const std::uint8_t* unseen_a,
                                           const std::uint8_t* unseen_b, std::size_t words,
                                           std::uint8_t* __restrict distances) {
  constexpr std::uint64_t kPairs = 0x5555555555555555U, kFours = 0x3333333333333333U,
                          kEights = 0x0f0f0f0f0f0f0f0fU;
  const auto word_at = [](const std::uint8_t* from) {
    std::uint64_t word;
    std::memcpy(&word, from, sizeof(word));
    return word;
  };
  for (std::size_t i = 0; i < words; ++i) {
    const std::size_t at = 8 * i;
    std::uint64_t sum = 0;
    for (int half = 0; half < 2; ++half) {
      std::uint64_t fours = 0;  // up to 12 in four bits
      for (int plane = 0; plane < kCensusPlanes / 2; ++plane) {
        const std::size_t from = (half * (kCensusPlanes / 2) + plane) * plane_size + at;
        std::uint64_t bits = word_at(a + from) ^ word_at(b + from);
        bits -= (bits >> 1) & kPairs;
        fours += (bits & kFours) + ((bits >> 2) & kFours);
      }
      sum += (fours & kEights) + ((fours >> 4) & kEights);
    }
    sum |= word_at(unseen_a + at) | word_at(unseen_b + at);
    std::memcpy(distances + at, &sum, sizeof(sum));
  }
}

// Keeps the three smallest by cell, in order.
SKYQUILT_VECTOR_CLONES void KeepSmallest(const std::uint8_t* __restrict value, std::uint8_t* __restrict first,
                                         std::uint8_t* __restrict second, std::uint8_t* __restrict third) {
  for (std::size_t i = 0; i < kChunk; ++i) {
    std::uint8_t carried = value[i];
    const std::uint8_t a = std::min(first[i], carried);
    carried = std::max(first[i], carried);
    const std::uint8_t b = std::min(second[i], carried);
    carried = std::max(second[i], carried);
    first[i] = a;
    second[i] = b;
    third[i] = std::min(third[i], carried);
  }
}

// Twice the mean of the `kept` smallest; where fewer are there the last of them counts for the others.
SKYQUILT_VECTOR_CLONES void CostOfSmallest(const std::uint8_t* first, const std::uint8_t* second,
                                           const std::uint8_t* third, int kept, std::size_t count,
                                           std::uint8_t* __restrict costs) {
  const int of_second = kept > 1 ? 1 : 0, of_third = kept > 2 ? 1 : 0;
  const int scale = (2 * 256 + kept - 1) / kept;
  for (std::size_t i = 0; i < count; ++i) {
    const int a = first[i] == kNotCompared ? kCensusBits / 2 : first[i];
    const int b = second[i] == kNotCompared ? a : second[i];
    const int c = third[i] == kNotCompared ? b : third[i];
    costs[i] = static_cast<std::uint8_t>(((a + of_second * b + of_third * c) * scale) >> 8);
  }
}

SKYQUILT_VECTOR_CLONES void AddAgreeing(const std::uint8_t* __restrict distances, std::uint8_t most,
                                        std::size_t count, std::uint8_t* __restrict a,
                                        std::uint8_t* __restrict b) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t agree = distances[i] <= most ? 1 : 0;
    a[i] = static_cast<std::uint8_t>(a[i] + agree);
    b[i] = static_cast<std::uint8_t>(b[i] + agree);
  }
}

}  // namespace

void FillCensus(const std::uint8_t* own, const std::uint8_t* around, const CensusShape& shape,
                std::uint8_t* planes) {
  const std::ptrdiff_t stride = shape.PatchColumns(), first = kCensusRadius * stride + kCensusRadius;
  std::array<const std::uint8_t*, kCensusBits> neighbours;
  std::size_t next = 0;
  for (int y = -kCensusRadius; y <= kCensusRadius; ++y) {
    for (int x = -kCensusRadius; x <= kCensusRadius; ++x) {
      if (x != 0 || y != 0) neighbours[next++] = around + first + y * stride + x;
    }
  }
  for (std::size_t plane = 0; plane < kCensusPlanes; ++plane) {
    CensusByte(own + first, neighbours.data() + 8 * plane, static_cast<int>(shape.Used()),
               planes + plane * shape.PlaneSize());
  }
}

void FillDistances(const CensusView& a, const CensusView& b, std::size_t plane_size, std::size_t first,
                   std::size_t count, std::uint8_t* distances) {
  CountDifferent(a.planes + first, b.planes + first, plane_size, a.unseen + first, b.unseen + first,
                 count / 8, distances);
}

BetterHalf::BetterHalf(int views) : kept_(std::clamp(views - 2, 1, kMaxKept)) {}

void BetterHalf::Fill(const std::vector<CensusView>& views, std::size_t plane_size,
                      std::uint8_t* costs) const {
  std::array<Chunk, kMaxKept> smallest;
  Chunk distances;
  for (std::size_t first = 0; first < plane_size; first += kChunk) {
    const std::size_t count = std::min(kChunk, plane_size - first);
    for (Chunk& chunk : smallest) chunk.fill(kNotCompared);
    if (count < kChunk) distances.fill(kNotCompared);
    for (std::size_t a = 0; a < views.size(); ++a) {
      for (std::size_t b = a + 1; b < views.size(); ++b) {
        FillDistances(views[a], views[b], plane_size, first, count, distances.data());
        KeepSmallest(distances.data(), smallest[0].data(), smallest[1].data(), smallest[2].data());
      }
    }
    CostOfSmallest(smallest[0].data(), smallest[1].data(), smallest[2].data(), kept_, count, costs + first);
  }
}

void CountAgreeing(const std::vector<CensusView>& views, std::size_t plane_size, std::uint8_t most_distance,
                   std::uint8_t* agreeing) {
  std::vector<std::vector<std::uint8_t>> with(views.size(), std::vector<std::uint8_t>(plane_size, 0));
  std::vector<std::uint8_t> distances(plane_size);
  for (std::size_t a = 0; a < views.size(); ++a) {
    for (std::size_t b = a + 1; b < views.size(); ++b) {
      FillDistances(views[a], views[b], plane_size, 0, plane_size, distances.data());
      AddAgreeing(distances.data(), most_distance, plane_size, with[a].data(), with[b].data());
    }
  }
  for (std::size_t i = 0; i < plane_size; ++i) {
    std::uint8_t most = 0;
    for (const std::vector<std::uint8_t>& view : with) most = std::max(most, view[i]);
    agreeing[i] = static_cast<std::uint8_t>(most > 0 ? most + 1 : 0);
  }
}

}  // namespace skyquilt::surface
