#include "storage/db/ids.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <mutex>
#include <stdexcept>

namespace skyquilt::storage {
namespace {

constexpr std::string_view kAlphabet = "0123456789abcdefghjkmnpqrstvwxyz";
constexpr std::size_t kTimeChars = 10;
constexpr std::size_t kRandomChars = 16;
constexpr std::size_t kOrderedChars = 18;  // that put ids of one millisecond in order

struct LastId {
  std::mutex mutex;
  std::string id;
};

LastId& LastMade() {
  static LastId last;
  return last;
}

}  // namespace

void FillWithRandom(std::span<std::uint8_t> bytes) {
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw std::runtime_error("the kernel gave no random bytes");
  }
}

std::string NewId() {
  std::array<std::uint8_t, kRandomChars> random{};
  FillWithRandom(random);
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  auto ms = static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
  std::string id(kTimeChars + kRandomChars, '0');
  for (std::size_t i = kTimeChars; i-- > 0; ms >>= 5) id[i] = kAlphabet[ms & 31];
  for (std::size_t i = 0; i < kRandomChars; ++i) id[kTimeChars + i] = kAlphabet[random[i] & 31];

  LastId& last = LastMade();
  const std::lock_guard lock(last.mutex);
  if (id.compare(0, kTimeChars, last.id, 0, kTimeChars) <= 0) {
    // The same millisecond, or the clock was set back: the next number after the last one, its end random.
    std::copy_n(last.id.begin(), kOrderedChars, id.begin());
    for (std::size_t i = kOrderedChars; i-- > 0;) {
      const std::size_t digit = kAlphabet.find(id[i]);
      id[i] = kAlphabet[(digit + 1) % kAlphabet.size()];
      if (digit + 1 < kAlphabet.size()) break;
    }
  }
  last.id = id;
  return id;
}

void MakeIdsAfter(const std::string& id) {
  if (!IsId(id)) return;
  LastId& last = LastMade();
  const std::lock_guard lock(last.mutex);
  last.id = std::max(last.id, id);
}

bool IsId(std::string_view text) {
  return text.size() == kTimeChars + kRandomChars &&
         text.find_first_not_of(kAlphabet) == std::string_view::npos;
}

}  // namespace skyquilt::storage
