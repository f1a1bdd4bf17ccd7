// The sentences that a map which lies nowhere on Earth carries among its warnings, in one place because they
// go once it is placed. Pure; any thread.
#pragma once

#include <string>
#include <vector>

namespace skyquilt::poses {

// Drawn at a local origin, as if a photo showed that much ground.
std::string NotGeoreferencedWords(double guessed_width_m);
// Reckoned from a start that nobody named.
std::string ReckonedFromNowhereWords();

// Takes these sentences out of the warnings.
void EraseUnplacedWords(std::vector<std::string>& warnings);

}  // namespace skyquilt::poses
