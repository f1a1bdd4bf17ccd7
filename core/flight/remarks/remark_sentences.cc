#include <algorithm>
#include <array>

#include "core/flight/remarks/remark_words.h"
#include "core/flight/remarks/sentences_on_attempts.h"
#include "core/flight/remarks/sentences_on_deliverables.h"
#include "core/flight/remarks/sentences_on_failures.h"
#include "core/flight/remarks/sentences_on_files.h"
#include "core/flight/remarks/sentences_on_inputs.h"
#include "core/flight/remarks/sentences_on_logs.h"
#include "core/flight/remarks/sentences_on_maps.h"

namespace skyquilt::flight {
namespace {

template <std::size_t... kSizes>
constexpr auto Joined(const std::array<RemarkSentence, kSizes>&... parts) {
  std::array<RemarkSentence, (kSizes + ...)> all{};
  auto end = all.begin();
  ((end = std::copy(parts.begin(), parts.end(), end)), ...);
  return all;
}

constexpr auto kSentences = Joined(kSentencesOnAttempts, kSentencesOnDeliverables, kSentencesOnFailures,
                                   kSentencesOnFiles, kSentencesOnInputs, kSentencesOnLogs, kSentencesOnMaps);

constexpr bool StandInOrder() {
  for (std::size_t i = 0; i < kSentences.size(); ++i) {
    if (static_cast<std::size_t>(kSentences[i].code) != i) return false;
  }
  return kSentences.size() == static_cast<std::size_t>(RemarkCode::kCount);
}
static_assert(StandInOrder(), "every code has a sentence, in the order of the codes");

}  // namespace

std::span<const RemarkSentence> RemarkSentences() { return kSentences; }

}  // namespace skyquilt::flight
