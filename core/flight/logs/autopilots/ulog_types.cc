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

struct ScalarName {
  std::string_view name;
  UlogScalar type;
  std::size_t size;
};
constexpr std::array kScalars = {
    ScalarName{"int8_t", UlogScalar::kInt8, 1},   ScalarName{"uint8_t", UlogScalar::kUint8, 1},
    ScalarName{"int16_t", UlogScalar::kInt16, 2}, ScalarName{"uint16_t", UlogScalar::kUint16, 2},
    ScalarName{"int32_t", UlogScalar::kInt32, 4}, ScalarName{"uint32_t", UlogScalar::kUint32, 4},
    ScalarName{"int64_t", UlogScalar::kInt64, 8}, ScalarName{"uint64_t", UlogScalar::kUint64, 8},
    ScalarName{"float", UlogScalar::kFloat, 4},   ScalarName{"double", UlogScalar::kDouble, 8},
    ScalarName{"bool", UlogScalar::kBool, 1},     ScalarName{"char", UlogScalar::kChar, 1}};

const ScalarName* FindScalar(std::string_view name) {
  for (const ScalarName& scalar : kScalars) {
    if (scalar.name == name) return &scalar;
  }
  return nullptr;
}

std::size_t SizeOfScalar(UlogScalar type) {
  for (const ScalarName& scalar : kScalars) {
    if (scalar.type == type) return scalar.size;
  }
  return 1;
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
  if (const ScalarName* scalar = FindScalar(type)) return scalar->size;
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
    if (const ScalarName* scalar = FindScalar(member.type); scalar != nullptr && member.count > 0) {
      definition.fields.try_emplace(member.name, UlogField{scalar->type, size, member.count});
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
  const std::size_t size = SizeOfScalar(field.type);
  const std::size_t at = field.offset + index * size;
  if (index >= field.count || at + size > payload.size()) return std::nullopt;
  const std::uint8_t* from = payload.data() + at;
  switch (field.type) {
    case UlogScalar::kInt8:
      return LoadLittle<std::int8_t>(from);
    case UlogScalar::kInt16:
      return LoadLittle<std::int16_t>(from);
    case UlogScalar::kUint16:
      return LoadLittle<std::uint16_t>(from);
    case UlogScalar::kInt32:
      return LoadLittle<std::int32_t>(from);
    case UlogScalar::kUint32:
      return LoadLittle<std::uint32_t>(from);
    case UlogScalar::kInt64:
      return static_cast<double>(LoadLittle<std::int64_t>(from));
    case UlogScalar::kUint64:
      return static_cast<double>(LoadLittle<std::uint64_t>(from));
    case UlogScalar::kFloat:
      return LoadLittle<float>(from);
    case UlogScalar::kDouble:
      return LoadLittle<double>(from);
    case UlogScalar::kUint8:
    case UlogScalar::kBool:
    case UlogScalar::kChar:
      return *from;
  }
  return std::nullopt;
}

}  // namespace skyquilt::flight
