// Names and lines that the node and its clients tell each other. Pure, but for new UUIDs.
#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "api/nodeodm/nodeodm.h"

namespace skyquilt::api {

std::string NewNodeUuid() {
  std::array<std::uint8_t, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw std::runtime_error("the kernel gave no random bytes");
  }
  bytes[6] = static_cast<std::uint8_t>((bytes[6] & 0x0f) | 0x40);
  bytes[8] = static_cast<std::uint8_t>((bytes[8] & 0x3f) | 0x80);
  std::string uuid;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) uuid += '-';
    uuid += fmt::format("{:02x}", bytes[i]);
  }
  return uuid;
}

bool IsNodeEngine(std::string_view name) {
  constexpr std::size_t kMaxLength = 32;
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  return !name.empty() && name.size() <= kMaxLength && std::all_of(name.begin(), name.end(), fits);
}

std::string NodeNote(std::string text) {
  constexpr std::size_t kMaxBytes = 500;
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c >= 0 && c < ' '; }, ' ');
  if (text.size() > kMaxBytes) text = text.substr(0, kMaxBytes) + "...";
  return text;
}

std::vector<std::string> NodeNotes(const std::vector<std::string>& unknown_options) {
  std::vector<std::string> notes;
  for (const std::string& name : unknown_options)
    notes.push_back(NodeNote(fmt::format("The option {} is not known here and has no effect.", name)));
  return notes;
}

}  // namespace skyquilt::api
