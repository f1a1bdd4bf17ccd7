#include "core/flight/lists/duplicates.h"

#include <xxhash.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "core/base/digest.h"
#include "core/flight/bytes/byte_source.h"

namespace skyquilt::flight {
namespace {

using Fingerprint = std::pair<std::uint64_t, std::uint64_t>;  // size, hash of the start

std::optional<Fingerprint> FingerprintOf(const std::filesystem::path& path) {
  constexpr std::size_t kStart = 1 << 16;  // holds the time of capture and the position
  auto source = OpenFileBytes(path);
  if (!source) return std::nullopt;
  const auto start = (*source)->ReadUpTo(0, kStart);
  if (start.empty()) return std::nullopt;
  return Fingerprint{(*source)->size(), XXH3_64bits(start.data(), start.size())};
}

bool HaveSameBytes(const std::filesystem::path& first, const std::filesystem::path& second) {
  auto a = OpenFileBytes(first);
  auto b = OpenFileBytes(second);
  if (!a || !b || (*a)->size() != (*b)->size()) return false;
  constexpr std::size_t kBlock = 1 << 20;
  for (std::uint64_t offset = 0; offset < (*a)->size(); offset += kBlock) {
    const auto block = (*a)->ReadUpTo(offset, kBlock);
    if (block.empty() || block != (*b)->ReadUpTo(offset, kBlock)) return false;
  }
  return true;
}

}  // namespace

std::vector<std::optional<std::size_t>> FindDuplicates(const std::vector<InputFile>& files) {
  std::vector<std::optional<std::size_t>> duplicate_of(files.size());
  std::map<std::uint64_t, std::vector<std::size_t>> by_size;
  for (std::size_t i = 0; i < files.size(); ++i) {
    std::error_code error;
    const auto size = std::filesystem::file_size(files[i].path, error);
    if (!error) by_size[size].push_back(i);
  }
  for (const auto& [size, same_size] : by_size) {
    if (same_size.size() < 2) continue;
    std::map<Fingerprint, std::vector<std::size_t>> alike;
    for (const std::size_t i : same_size) {
      if (const auto fingerprint = FingerprintOf(files[i].path)) alike[*fingerprint].push_back(i);
    }
    for (const auto& [fingerprint, candidates] : alike) {
      if (candidates.size() < 2) continue;
      // Each is read once for its digest, however many are alike, and once more beside the first of its
      // digest.
      std::map<Digest, std::size_t> firsts;
      for (const std::size_t i : candidates) {
        const Result<Digest> digest = DigestOfFile(files[i].path);
        if (!digest) continue;
        const auto [first, is_new] = firsts.try_emplace(*digest, i);
        if (!is_new && HaveSameBytes(files[first->second].path, files[i].path))
          duplicate_of[i] = first->second;
      }
    }
  }
  return duplicate_of;
}

}  // namespace skyquilt::flight
