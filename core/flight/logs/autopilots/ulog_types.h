// The type system of a ULog file: definitions "name:type field;type[n] field;..." with nested types, and
// where a field lies in a message. Each definition is worked out once, whoever asks; bounded are the
// definitions (2000, of 50 000 members in all), how deep they nest (8) and the members that are looked at in
// all (a million), so that a file made of definitions takes no longer than one of data. One thread.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/flight/bytes/log_bytes.h"

namespace skyquilt::flight {

struct UlogScalar {
  std::string_view name;
  std::size_t size = 0;
  double (*number)(const std::uint8_t* from) = nullptr;
};

// Where one scalar field (or the first of an array) lies from the start of the message's payload.
struct UlogField {
  const UlogScalar* type = nullptr;
  std::size_t offset = 0;
  std::size_t count = 1;
};

class UlogTypes {
 public:
  // One definition message; false where it is malformed.
  bool Define(std::string_view definition);
  bool Knows(std::string_view type) const { return definitions_.find(type) != definitions_.end(); }
  // Bytes of a type with all its nested ones; nothing where one is unknown, recursive or larger than 64 KiB.
  std::optional<std::size_t> SizeOf(std::string_view type);
  // A top-level field of a message type.
  std::optional<UlogField> Find(std::string_view type, std::string_view field);
  // How many members were looked at so far.
  int steps() const { return steps_; }

 private:
  struct Member {
    std::string type;
    std::string name;
    std::size_t count = 1;
  };
  struct Definition {
    std::vector<Member> members;
    bool is_known = false;  // what follows was worked out
    std::optional<std::size_t> size;
    std::map<std::string, UlogField, std::less<>> fields;  // those before the first whose size is not known
  };
  std::optional<std::size_t> SizeOf(std::string_view type, int depth);
  void WorkOut(Definition& definition, int depth);

  std::map<std::string, Definition, std::less<>> definitions_;
  std::size_t defined_ = 0;
  std::size_t members_ = 0;
  int steps_ = 0;
};

// The number at an index of a field; nothing beyond the payload (padding at its end is not written).
std::optional<double> UlogNumber(const UlogField& field, LogBytes payload, std::size_t index = 0);

}  // namespace skyquilt::flight
