#include "storage/ids.h"

#include <sys/random.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <stdexcept>

namespace skyquilt::storage {
namespace {

constexpr std::string_view kAlphabet = "0123456789abcdefghjkmnpqrstvwxyz";
constexpr std::size_t kTimeChars = 10;
constexpr std::size_t kRandomChars = 16;

}  // namespace

std::string NewId() {
  std::array<std::uint8_t, kRandomChars> random{};
  if (getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size())) {
    throw std::runtime_error("the kernel gave no random bytes");
  }
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  auto ms = static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
  std::string id(kTimeChars + kRandomChars, '0');
  for (std::size_t i = kTimeChars; i-- > 0; ms >>= 5) id[i] = kAlphabet[ms & 31];
  for (std::size_t i = 0; i < kRandomChars; ++i) id[kTimeChars + i] = kAlphabet[random[i] & 31];
  return id;
}

bool IsId(std::string_view text) {
  return text.size() == kTimeChars + kRandomChars &&
         text.find_first_not_of(kAlphabet) == std::string_view::npos;
}

}  // namespace skyquilt::storage
