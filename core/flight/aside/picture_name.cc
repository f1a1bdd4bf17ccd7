#include "core/flight/aside/picture_name.h"

#include <array>
#include <span>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::flight {
namespace {

constexpr std::string_view kNameDigits = "0123456789";
constexpr std::string_view kNameSeparators = " -_.~";

// Where the digits at the end begin.
std::size_t CounterOf(std::string_view stem) { return stem.find_last_not_of(kNameDigits) + 1; }

std::string_view WithoutSeparators(std::string_view stem) {
  return stem.substr(0, stem.find_last_not_of(kNameSeparators) + 1);
}

std::optional<std::string_view> BeforeBrackets(std::string_view stem) {
  if (!stem.ends_with(")")) return std::nullopt;
  const std::string_view inner = stem.substr(0, stem.size() - 1);
  const std::size_t digits = CounterOf(inner);
  constexpr std::size_t kMaxDigits = 3;
  if (digits == inner.size() || inner.size() - digits > kMaxDigits || digits == 0 || inner[digits - 1] != '(')
    return std::nullopt;
  return WithoutSeparators(inner.substr(0, digits - 1));
}

std::optional<std::string_view> BeforeOneOf(std::span<const std::string_view> words, std::string_view stem) {
  for (const std::string_view word : words) {
    if (!stem.ends_with(word) || stem.size() <= word.size()) continue;
    const std::string_view before = stem.substr(0, stem.size() - word.size());
    if (kNameSeparators.find(before.back()) != std::string_view::npos) return WithoutSeparators(before);
  }
  return std::nullopt;
}

std::optional<std::string_view> BeforeWord(std::string_view stem) {
  constexpr std::array<std::string_view, 24> kWords = {
      "copy",      "kopie",    "copie",  "copia",     "edited",  "edit",     "enhanced", "bearbeitet",
      "modified",  "modifie",  "export", "exported",  "resized", "reduced",  "small",    "web",
      "retouched", "retouche", "lowres", "lightroom", "lr",      "snapseed", "original", "orig"};
  return BeforeOneOf(kWords, stem);
}

// "dji_0021-2", but neither "dji_0021" nor "20240601_0021": a copy's number is small, and what stands before
// it ends as a camera's name does, or with a word of a copy.
std::optional<std::string_view> BeforeNumber(std::string_view stem) {
  const std::size_t digits = CounterOf(stem);
  constexpr std::size_t kMaxDigits = 2;
  if (digits == stem.size() || stem.size() - digits > kMaxDigits || digits == 0 || stem[digits] == '0' ||
      kNameSeparators.find(stem[digits - 1]) == std::string_view::npos)
    return std::nullopt;
  const std::string_view before = WithoutSeparators(stem.substr(0, digits));
  if (before.empty()) return std::nullopt;
  const bool is_named = kNameDigits.find(before.back()) != std::string_view::npos ||
                        !LensMark(before).empty() || BeforeWord(before);
  return is_named ? std::optional(before) : std::nullopt;
}

}  // namespace

PictureName PictureNameOf(std::string_view name) {
  PictureName read;
  read.file = LowerCase(name);
  constexpr std::string_view kBefore = "_original";
  const std::size_t dot = read.file.rfind('.');
  if (read.file.ends_with(kBefore) && dot != std::string::npos && dot < read.file.size() - kBefore.size()) {
    read.is_before_a_change = true;
    read.file.erase(read.file.size() - kBefore.size());
  }
  std::string_view stem = std::string_view(read.file).substr(read.file.find_last_of("/\\") + 1);
  if (const std::size_t ending = stem.rfind('.'); ending != std::string_view::npos && ending > 0) {
    stem = stem.substr(0, ending);  // with what follows: "a.jpg (2)" is the second file of that name
  }
  read.stem = stem;
  return read;
}

std::optional<Unmarked> WithoutCopyMark(std::string_view stem) {
  const auto kept = [](std::optional<std::string_view> before, CopyMark mark) -> std::optional<Unmarked> {
    if (!before || before->empty()) return std::nullopt;
    return Unmarked{std::string(*before), mark};
  };
  if (auto unmarked = kept(BeforeBrackets(stem), CopyMark::kBrackets)) return unmarked;
  if (auto unmarked = kept(BeforeWord(stem), CopyMark::kWord)) return unmarked;
  for (const std::string_view start : {"copy of ", "kopie von ", "copie de ", "copia de "}) {
    if (stem.starts_with(start)) return kept(stem.substr(start.size()), CopyMark::kWord);
  }
  return kept(BeforeNumber(stem), CopyMark::kNumber);
}

std::optional<std::string_view> WithoutTagMark(std::string_view stem) {
  constexpr std::array<std::string_view, 8> kTagWords = {"geotag", "geotagged", "geo", "gps",
                                                         "tagged", "ppk",       "rtk", "corrected"};
  return BeforeOneOf(kTagWords, stem);
}

std::string_view LensMark(std::string_view stem) {
  const std::size_t line = stem.rfind('_');
  if (line == std::string_view::npos || line == 0) return "";
  const std::string_view mark = stem.substr(line + 1);
  return IsOneOf(mark, {"w", "z", "t", "v", "s", "ir"}) ? mark : std::string_view();
}

bool AreOfOneCounter(std::string_view stem, std::string_view other) {
  if (const std::string_view mark = LensMark(stem); !mark.empty() && mark == LensMark(other)) {
    stem.remove_suffix(mark.size() + 1);
    other.remove_suffix(mark.size() + 1);
  }
  const std::size_t a = CounterOf(stem), b = CounterOf(other);
  return a < stem.size() && b < other.size() && stem.substr(0, a) == other.substr(0, b) &&
         stem.substr(a) != other.substr(b);
}

}  // namespace skyquilt::flight
