// WithComposedLetters: names of files as most systems write them. macOS writes a letter with a mark ("ü") as
// two characters, the letter and the mark, others as one, which looks the same. Pure; any thread.
#pragma once

#include <string>
#include <string_view>

namespace skyquilt::flight {

// UTF-8 with each letter and the marks after it (U+0300 to U+036F) as one character where Unicode has one
// below U+1F00: Latin letters, Vietnamese ones too, Greek and Cyrillic. All else, also what is no UTF-8,
// stays as it is; so do voiced kana and syllables of Hangul, which have no such marks.
std::string WithComposedLetters(std::string_view text);

}  // namespace skyquilt::flight
