#include "core/pipeline/placing/recall_flight.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <variant>

#include "core/base/parallel_for.h"
#include "core/flight/remarks/remark.h"
#include "core/pipeline/placing/move_flight.h"
#include "core/poses/evidence/repeated_positions.h"

namespace skyquilt::pipeline {
namespace {

using flight::Remark;
using flight::RemarkCode;

// As AreSameButForNumbers has it, of one value.
bool AreAlike(const flight::RemarkValue& a, const flight::RemarkValue& b) {
  const auto is_number = [](const flight::RemarkValue& value) {
    return std::holds_alternative<std::int64_t>(value.is) || std::holds_alternative<double>(value.is);
  };
  if (is_number(a) && is_number(b)) return true;
  const auto *within = std::get_if<std::vector<Remark>>(&a.is),
             *other = std::get_if<std::vector<Remark>>(&b.is);
  if (within == nullptr || other == nullptr) return a == b;
  return std::equal(within->begin(), within->end(), other->begin(), other->end(), AreSameButForNumbers);
}

// Was it said of one photo what is said of several now?
bool IsOfOneAmong(const Remark& said, const Remark& now) {
  if (said.code != RemarkCode::kOfPhoto || now.code != RemarkCode::kOfPhotos) return false;
  const auto was = said.values.find("said"), is = now.values.find("said");
  return was != said.values.end() && is != now.values.end() && was->second == is->second;
}

// Of reading these lists, not of what became of their points.
bool IsOfLists(const Remark& said, const std::set<std::string>& lists) {
  const auto file = said.values.find("file");
  const std::string* name = file == said.values.end() ? nullptr : std::get_if<std::string>(&file->second.is);
  return name != nullptr && lists.contains(*name) && !IsOfControl(said);
}

}  // namespace

std::vector<NamedDigest> DigestsOf(const std::vector<flight::InputFile>& files,
                                   const std::map<std::string, Digest>& known, int threads) {
  std::vector<Result<Digest>> read(files.size(), Digest{});
  ParallelFor(files.size(), threads, [&](std::size_t i) {
    const auto found = known.find(files[i].name);
    read[i] = found != known.end() ? Result<Digest>(found->second) : DigestOfFile(files[i].path);
  });
  std::vector<NamedDigest> digests;
  for (std::size_t i = 0; i < files.size(); ++i) {
    // A file that cannot be read is reported where it is needed; until then it has no twin.
    digests.push_back({files[i], read[i] ? *read[i] : Digest{}});
  }
  return digests;
}

std::optional<Recalled> RecallFiles(const pyramid::MapMemory& memory, const std::vector<NamedDigest>& inputs,
                                    const std::set<std::string>& apart) {
  Result<FlightFacts> facts = ParseFacts(memory.Recall());
  // Facts that cannot be read are as good as none: the flight is placed anew.
  if (!facts || facts->inputs.empty()) return std::nullopt;
  std::map<std::string, Digest> given;
  for (const NamedDigest& input : inputs) {
    if (!given.emplace(input.file.name, input.digest).second) return std::nullopt;  // which one was which?
  }
  std::set<std::string> known;
  for (const NamedDigest& input : facts->inputs) {
    if (apart.contains(input.file.name)) continue;
    const auto same = given.find(input.file.name);
    if (same == given.end() || same->second != input.digest) return std::nullopt;
    known.insert(input.file.name);
  }
  Recalled recalled{*std::move(facts), {}};
  for (const NamedDigest& input : inputs) {
    if (!known.contains(input.file.name) && !apart.contains(input.file.name)) recalled.added.push_back(input);
  }
  return recalled;
}

std::optional<Recalled> RecallPlaced(const pyramid::MapMemory& memory, const MosaicOptions& options,
                                     const std::vector<NamedDigest>& inputs) {
  std::optional<Recalled> recalled = RecallFiles(memory, inputs);
  if (recalled && recalled->facts.options != DigestOfPlacing(options)) return std::nullopt;
  // An earlier version did not ask whether anything leans.
  if (recalled && options.surface == MapGround::kAuto && !recalled->facts.ground_choice) return std::nullopt;
  return recalled;
}

std::optional<FlightFacts> RecallPlacedByHand(const pyramid::MapMemory& memory, const MosaicOptions& options,
                                              const std::vector<NamedDigest>& inputs) {
  Result<FlightFacts> facts = ParseFacts(memory.Recall());
  if (!facts || !facts->is_by_hand || facts->options != DigestOfPlacing(options)) return std::nullopt;
  std::map<std::string, Digest> given;
  for (const NamedDigest& input : inputs) given.emplace(input.file.name, input.digest);
  std::set<std::string> still;
  for (const NamedDigest& input : facts->inputs) {
    const auto same = given.find(input.file.name);
    if (same != given.end() && same->second == input.digest) still.insert(input.file.name);
  }
  const std::vector<alignment::AlignedPhoto>& photos = facts->flight.photos;
  const auto shown = std::count_if(photos.begin(), photos.end(), [&](const alignment::AlignedPhoto& photo) {
    return still.contains(photo.photo.name);
  });
  if (2 * static_cast<std::size_t>(shown) <= photos.size()) return std::nullopt;
  return *std::move(facts);
}

bool MayAppend(const Recalled& recalled, const flight::Flight& read, const MosaicOptions& options) {
  if (recalled.facts.is_by_images) return false;
  if (!recalled.facts.appearance || 2 * recalled.added.size() > recalled.facts.flight.photos.size())
    return false;
  if (options.method != AlignMethod::kAuto && options.method != AlignMethod::kImu) return false;
  std::set<std::string> photos;
  for (const flight::Photo& photo : read.photos) photos.insert(photo.name);
  for (const flight::LeftOutPhoto& photo : read.left_out) photos.insert(photo.name);
  return std::all_of(recalled.added.begin(), recalled.added.end(),
                     [&](const NamedDigest& input) { return photos.contains(input.file.name); });
}

std::set<std::string> NamesOf(const std::vector<flight::GcpList>& lists) {
  std::set<std::string> names;
  for (const flight::GcpList& list : lists) names.insert(list.file_name);
  return names;
}

bool MayMove(const Recalled& recalled, const flight::Flight& read, const MosaicOptions& options) {
  if (options.method != AlignMethod::kAuto || !recalled.facts.is_placed) return false;
  const std::set<std::string> lists = NamesOf(read.gcp_lists);
  return lists.size() == recalled.added.size() &&
         std::all_of(recalled.added.begin(), recalled.added.end(),
                     [&](const NamedDigest& input) { return lists.contains(input.file.name); });
}

bool HasAllPhotosOf(const alignment::AlignedFlight& known, const flight::Flight& read) {
  std::set<std::string> names;
  for (const flight::Photo& photo : read.photos) names.insert(photo.name);
  return std::all_of(known.photos.begin(), known.photos.end(),
                     [&](const alignment::AlignedPhoto& photo) { return names.contains(photo.photo.name); });
}

void FillPhotos(const flight::Flight& read, alignment::AlignedFlight& flight) {
  // Lists and events place photos otherwise than these say themselves. Maps of earlier versions do not know.
  const bool are_known =
      std::any_of(flight.photos.begin(), flight.photos.end(),
                  [](const alignment::AlignedPhoto& photo) { return photo.photo.position.has_value(); });
  std::vector<flight::Photo> photos = read.photos;
  // A fix that photos repeat is one, as it was when the map was made.
  const bool repeats = std::any_of(
      flight.warnings.begin(), flight.warnings.end(),
      [](const flight::Remark& said) { return said.code == flight::RemarkCode::kPositionsRepeated; });
  if (repeats && !are_known) poses::MoveRepeatedPositions(photos);
  std::map<std::string, const flight::Photo*> by_name;
  for (const flight::Photo& photo : photos) by_name[photo.name] = &photo;
  for (alignment::AlignedPhoto& photo : flight.photos) {
    const auto found = by_name.find(photo.photo.name);
    if (found == by_name.end()) continue;
    const flight::Photo before = std::exchange(photo.photo, *found->second);
    if (before.sample_range) photo.photo.sample_range = before.sample_range;
    if (are_known) photo.photo.position = before.position;
  }
}

bool HasRemark(const std::vector<Remark>& remarks, const Remark& one) {
  return std::find(remarks.begin(), remarks.end(), one) != remarks.end();
}

bool AreSameButForNumbers(const Remark& a, const Remark& b) {
  return a.code == b.code && std::equal(a.values.begin(), a.values.end(), b.values.begin(), b.values.end(),
                                        [](const auto& one, const auto& other) {
                                          return one.first == other.first &&
                                                 AreAlike(one.second, other.second);
                                        });
}

void TellReading(const flight::Flight& read, alignment::AlignedFlight& flight) {
  const std::set<std::string> lists = NamesOf(read.gcp_lists);
  std::erase_if(flight.warnings, [&](const Remark& said) {
    if (HasRemark(read.warnings, said)) return false;
    return said.code == RemarkCode::kOfPhotos || said.code == RemarkCode::kMoreOfPhotos ||
           IsOfLists(said, lists) ||
           std::any_of(read.warnings.begin(), read.warnings.end(), [&](const Remark& now) {
             return AreSameButForNumbers(said, now) || IsOfOneAmong(said, now);
           });
  });
  for (const Remark& now : read.warnings) {
    if (!HasRemark(flight.warnings, now)) flight.warnings.push_back(now);
  }
}

}  // namespace skyquilt::pipeline
