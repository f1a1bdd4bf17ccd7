// Reading text logs: their bytes as UTF-8 (LogText), then lines, fields and numbers, which copies nothing.
// Never throws, every length bounded. Any thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/base/text/plain_text.h"
#include "core/flight/bytes/log_bytes.h"

namespace skyquilt::flight {

// Characters of a photo's or a point's name in a list; the rest is cut off.
inline constexpr std::size_t kMaxNameLength = 512;

using skyquilt::LowerCase;
using skyquilt::Trim;
bool StartsWithIgnoringCase(std::string_view text, std::string_view start);

// Is `word` one of these, does `text` start with one of them, and does it hold one?
template <typename Words = std::initializer_list<std::string_view>>
bool IsOneOf(std::string_view word, const Words& words) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}
template <typename Words = std::initializer_list<std::string_view>>
bool StartsWithOneOf(std::string_view text, const Words& words) {
  return std::any_of(std::begin(words), std::end(words),
                     [&](std::string_view word) { return text.starts_with(word); });
}
template <typename Words = std::initializer_list<std::string_view>>
bool HoldsOneOf(std::string_view text, const Words& words) {
  return std::any_of(std::begin(words), std::end(words),
                     [&](std::string_view word) { return text.find(word) != std::string_view::npos; });
}

// The whole trimmed text as a finite number ("+1.5" too); nothing otherwise.
std::optional<double> ParseNumber(std::string_view text);
std::optional<std::int64_t> ParseInteger(std::string_view text);

// How many digits stand after the decimal point.
int DecimalPlaces(std::string_view text);

// Walks the lines of a text ("\n", "\r\n", "\r"), without their ends; skips a byte-order mark at the start.
class LineReader {
 public:
  explicit LineReader(std::string_view text);
  // False at the end. A line longer than 1 MiB is cut there; the rest counts as the next line.
  bool Next(std::string_view& line);
  std::size_t offset() const { return at_; }
  std::size_t line_number() const { return number_; }
  // True when the last line given had no line end: the file may be cut there.
  bool last_line_is_open() const { return open_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t number_ = 0;
  bool open_ = false;
};

// Is one of the first `most` lines of a text what `is_meant` says?
template <typename IsMeant>
bool HasLine(std::string_view text, int most, IsMeant is_meant) {
  LineReader lines(text);
  std::string_view line;
  while (most-- > 0 && lines.Next(line)) {
    if (is_meant(line)) return true;
  }
  return false;
}

// A line of a table without a row.
inline bool IsBlankOrComment(std::string_view line) { return Trim(line).empty() || line.front() == '#'; }

// The next line that is not blank; says to `steps` how far the reading has come.
inline bool NextFilledLine(LineReader& lines, ConsumedSteps& steps, std::string_view& line) {
  while (lines.Next(line)) {
    steps.At(lines.offset());
    if (!Trim(line).empty()) return true;
  }
  return false;
}

// Trimmed, without the double quotes around it and the blanks within these.
std::string_view Unquote(std::string_view field);
// Cuts at `separator`; fields that begin and end with double quotes may hold it (a quote elsewhere is a
// letter: 33.4"). A blank as separator: at runs of blanks. At most 1024 fields; fields are trimmed.
void SplitFields(std::string_view line, char separator, std::vector<std::string_view>& fields);
// Cuts at runs of `blanks`, of whatever characters these are.
void SplitBlanks(std::string_view line, std::vector<std::string_view>& fields,
                 std::string_view blanks = " \t\r\n");
// The cells of the next line that is neither blank nor a comment; false at the end. Looks at no line that
// begins at `end` or behind it.
bool NextRow(LineReader& lines, char separator, std::vector<std::string_view>& cells,
             std::size_t end = std::string_view::npos);
// The separator that a header line uses: ',', ';', '|' or tab.
char GuessSeparator(std::string_view header);

// What a file holds as it may stand in a sentence: printable, between quotes, of `longest` bytes at most and
// without the half of a letter at its end.
std::string Quoted(std::string_view text, std::size_t longest = 40);

// A character as UTF-8.
void AppendUtf8(std::uint32_t code, std::string& text);

// True where the first bytes look like text rather than a binary file.
bool LooksLikeText(std::string_view head);

// The bytes of a text log as UTF-8, whatever it was saved as. UTF-16 of either order is decoded, by
// its byte-order mark or, without one, where every second byte of its beginning is zero; all other bytes,
// binary logs too, are passed on as they are, but for a byte-order mark of UTF-8. A decoded log is held in
// memory: 64 MiB of UTF-16 at most (96 MiB decoded), a longer one is refused with advice. Half of a pair
// becomes U+FFFD. The bytes given must outlive it.
class LogText {
 public:
  // Error: kUnsupportedFormat for UTF-16 beyond the bound.
  static Result<LogText> Of(std::string_view name, LogBytes bytes);

  LogBytes bytes() const { return is_decoded_ ? BytesOf(decoded_) : raw_; }
  bool is_decoded() const { return is_decoded_; }

 private:
  LogBytes raw_;
  std::string decoded_;
  bool is_decoded_ = false;
};

}  // namespace skyquilt::flight
