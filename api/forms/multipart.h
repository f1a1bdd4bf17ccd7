// MultipartParser: multipart/form-data (RFC 7578, RFC 2046) pushed in pieces of any size. Part bodies are
// handed on as they come and never kept; memory is one slice plus one part header. The outcome does not
// depend on where the pieces were cut. One thread at a time. Errors: kInvalidArgument (not multipart, broken
// headers, cut off), kTooLarge (header or number of parts), and whatever the receiver answers, which stops
// the parser.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::api {

struct PartHeader {
  std::string field;                     // the form's name for it
  std::optional<std::string> file_name;  // as sent, unchecked
};

class PartReceiver {
 public:
  virtual ~PartReceiver() = default;
  virtual Result<void> BeginPart(const PartHeader& header) = 0;
  virtual Result<void> PartBytes(std::span<const std::uint8_t> bytes) = 0;
  virtual Result<void> EndPart() = 0;
};

inline constexpr std::size_t kMaxPartHeaderBytes = 8192;
inline constexpr int kMaxParts = 20'000;

// The boundary out of a Content-Type. Errors: kUnsupportedFormat (another type), kInvalidArgument (no good
// boundary).
Result<std::string> MultipartBoundary(std::string_view content_type);

class MultipartParser {
 public:
  MultipartParser(std::string_view boundary, PartReceiver& receiver);
  Result<void> Push(std::span<const std::uint8_t> bytes);
  // After the last piece: fails when the closing delimiter never came.
  Result<void> Finish();

 private:
  enum class State { kPreamble, kHeader, kBody, kEpilogue };
  enum class Delimiter { kUndecided, kPart, kEnd, kNone };
  // What stands behind a delimiter that begins at `at` in the buffer; `end` is the first byte after it.
  Delimiter Classify(std::size_t at, std::size_t* end) const;
  Result<bool> Step();  // true: something was consumed, go on
  Result<bool> StepHeader();
  Result<bool> StepBody();
  Result<void> Emit(std::size_t count);

  std::string delimiter_;  // CR LF -- boundary
  PartReceiver& receiver_;
  State state_ = State::kPreamble;
  std::string buffer_;
  int parts_ = 0;
};

// Of the lines between the delimiter and the empty line, each ended by CR LF but the last. Errors:
// kInvalidArgument.
Result<PartHeader> ParsePartHeader(std::string_view block);

}  // namespace skyquilt::api
