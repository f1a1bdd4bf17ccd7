#include "core/flight/logs/autopilots/ulog_types.h"

#include <array>
#include <utility>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kLargestType = std::size_t{1} << 16;
constexpr std::size_t kMaxDefinitions = 2000;
constexpr std::size_t kMaxMembers = 1000;
constexpr std::size_t kMaxMembersInAll = 50'000;
constexpr int kDeepest = 8;
constexpr int kMaxSteps = 1'000'000;  // a log of PX4 takes some ten thousand

constexpr std::array kScalars = {
    UlogScalar{"int8_t", 1, NumberAt<std::int8_t>},   UlogScalar{"uint8_t", 1, NumberAt<std::uint8_t>},
    UlogScalar{"int16_t", 2, NumberAt<std::int16_t>}, UlogScalar{"uint16_t", 2, NumberAt<std::uint16_t>},
    UlogScalar{"int32_t", 4, NumberAt<std::int32_t>}, UlogScalar{"uint32_t", 4, NumberAt<std::uint32_t>},
    UlogScalar{"int64_t", 8, NumberAt<std::int64_t>}, UlogScalar{"uint64_t", 8, NumberAt<std::uint64_t>},
    UlogScalar{"float", 4, NumberAt<float>},          UlogScalar{"double", 8, NumberAt<double>},
    UlogScalar{"bool", 1, NumberAt<std::uint8_t>},    UlogScalar{"char", 1, NumberAt<std::uint8_t>}};

const UlogScalar* FindScalar(std::string_view name) {
  for (const UlogScalar& scalar : kScalars) {
    if (scalar.name == name) return &scalar;
  }
  return nullptr;
}

}  // namespace

bool UlogTypes::Define(std::string_view definition) {
  const std::size_t colon = definition.find(':');
  if (colon == std::string_view::npos || colon == 0 || colon > 256 || ++defined_ > kMaxDefinitions)
    return false;
  std::vector<Member> members;
  std::string_view rest = definition.substr(colon + 1);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    const std::string_view part = Trim(rest.substr(0, end));
    rest.remove_prefix(std::min(rest.size(), end + 1));
    if (part.empty()) continue;
    const std::size_t blank = part.find(' ');
    if (blank == std::string_view::npos || members.size() >= kMaxMembers || ++members_ > kMaxMembersInAll)
      return false;
    Member member;
    std::string_view type = part.substr(0, blank);
    const std::size_t bracket = type.find('[');
    if (bracket != std::string_view::npos) {
      const auto count = ParseInteger(type.substr(bracket + 1, type.find(']') - bracket - 1));
      if (!count || *count < 0 || *count > static_cast<std::int64_t>(kLargestType)) return false;
      member.count = static_cast<std::size_t>(*count);
      type = type.substr(0, bracket);
    }
    member.type = type;
    member.name = Trim(part.substr(blank + 1));
    members.push_back(std::move(member));
  }
  Definition& defined = definitions_[std::string(definition.substr(0, colon))];
  defined.members = std::move(members);
  // What was worked out may have lacked this one, or held another in its place.
  for (auto& [name, known] : definitions_) known.is_known = false;
  return true;
}

std::optional<std::size_t> UlogTypes::SizeOf(std::string_view type) { return SizeOf(type, 0); }

std::optional<std::size_t> UlogTypes::SizeOf(std::string_view type, int depth) {
  if (const UlogScalar* scalar = FindScalar(type)) return scalar->size;
  const auto found = definitions_.find(type);
  if (found == definitions_.end() || depth > kDeepest) return std::nullopt;
  if (!found->second.is_known) WorkOut(found->second, depth);
  return found->second.size;
}

void UlogTypes::WorkOut(Definition& definition, int depth) {
  // Before its members are looked at: a type that holds itself finds no size here.
  definition.is_known = true;
  definition.size.reset();
  definition.fields.clear();
  std::size_t size = 0;
  for (const Member& member : definition.members) {
    if (steps_ >= kMaxSteps) return;
    ++steps_;
    const auto member_size = SizeOf(member.type, depth + 1);
    if (!member_size) return;
    if (const UlogScalar* scalar = FindScalar(member.type); scalar != nullptr && member.count > 0) {
      definition.fields.try_emplace(member.name, UlogField{scalar, size, member.count});
    }
    size += *member_size * member.count;
    if (size > kLargestType) return;
  }
  definition.size = size;
}

std::optional<UlogField> UlogTypes::Find(std::string_view type, std::string_view field) {
  const auto found = definitions_.find(type);
  if (found == definitions_.end()) return std::nullopt;
  if (!found->second.is_known) WorkOut(found->second, 0);
  const auto place = found->second.fields.find(field);
  if (place == found->second.fields.end()) return std::nullopt;
  return place->second;
}

std::optional<double> UlogNumber(const UlogField& field, LogBytes payload, std::size_t index) {
  const std::size_t at = field.offset + index * field.type->size;
  if (index >= field.count || at + field.type->size > payload.size()) return std::nullopt;
  return field.type->number(payload.data() + at);
}

}  // namespace skyquilt::flight
