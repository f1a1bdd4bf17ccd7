#include <algorithm>
#include <array>

#include "core/flight/remarks/remark_words.h"
#include "core/flight/remarks/sentences_on_failures.h"
#include "core/flight/remarks/sentences_on_files.h"
#include "core/flight/remarks/sentences_on_inputs.h"
#include "core/flight/remarks/sentences_on_logs.h"
#include "core/flight/remarks/sentences_on_maps.h"

namespace skyquilt::flight {
namespace {

constexpr auto kSentences = [] {
  std::array<RemarkSentence, kSentencesOnInputs.size() + kSentencesOnLogs.size() + kSentencesOnMaps.size() +
                                 kSentencesOnFailures.size() + kSentencesOnFiles.size()>
      all{};
  auto end = std::copy(kSentencesOnInputs.begin(), kSentencesOnInputs.end(), all.begin());
  end = std::copy(kSentencesOnLogs.begin(), kSentencesOnLogs.end(), end);
  end = std::copy(kSentencesOnMaps.begin(), kSentencesOnMaps.end(), end);
  end = std::copy(kSentencesOnFailures.begin(), kSentencesOnFailures.end(), end);
  std::copy(kSentencesOnFiles.begin(), kSentencesOnFiles.end(), end);
  return all;
}();

constexpr bool StandInOrder() {
  for (std::size_t i = 0; i < kSentences.size(); ++i) {
    if (static_cast<std::size_t>(kSentences[i].code) != i) return false;
  }
  return kSentences.size() == static_cast<std::size_t>(RemarkCode::kNothingToStartFrom) + 1;
}
static_assert(StandInOrder(), "every code has a sentence, in the order of the codes");

}  // namespace

std::span<const RemarkSentence> RemarkSentences() { return kSentences; }

}  // namespace skyquilt::flight
