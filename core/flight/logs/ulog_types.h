// The type system of a ULog file: definitions "name:type field;type[n] field;..." with nested types, and
// where a field lies in a message. Sizes and depths are bounded. One thread.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/flight/logs/log_bytes.h"

namespace skyquilt::flight {

enum class UlogScalar {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat,
  kDouble,
  kBool,
  kChar
};

// Where one scalar field (or the first of an array) lies from the start of the message's payload.
struct UlogField {
  UlogScalar type = UlogScalar::kUint8;
  std::size_t offset = 0;
  std::size_t count = 1;
};

class UlogTypes {
 public:
  // One definition message; false where it is malformed.
  bool Define(std::string_view definition);
  bool Knows(std::string_view type) const { return definitions_.find(type) != definitions_.end(); }
  // Bytes of a type with all its nested ones; nothing where one is unknown, recursive or larger than 64 KiB.
  std::optional<std::size_t> SizeOf(std::string_view type) const;
  // A top-level field of a message type.
  std::optional<UlogField> Find(std::string_view type, std::string_view field) const;

 private:
  std::optional<std::size_t> SizeOf(std::string_view type, int depth, int& steps_left) const;
  struct Member {
    std::string type;
    std::string name;
    std::size_t count = 1;
  };
  std::map<std::string, std::vector<Member>, std::less<>> definitions_;
};

// The number at an index of a field; nothing when the payload ends before it (trailing padding is not
// written).
std::optional<double> UlogNumber(const UlogField& field, LogBytes payload, std::size_t index = 0);
std::optional<std::uint64_t> UlogUnsigned(const UlogField& field, LogBytes payload);

}  // namespace skyquilt::flight
