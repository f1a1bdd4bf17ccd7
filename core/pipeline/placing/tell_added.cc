#include "core/pipeline/placing/tell_added.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <variant>

#include "core/pipeline/placing/recall_flight.h"
#include "core/pipeline/report/judge_map.h"

namespace skyquilt::pipeline {
namespace {

using alignment::AlignedPhoto;
using alignment::AlignPairReport;
using alignment::AlignPhotoReport;
using alignment::Placement;
using flight::Remark;
using flight::RemarkCode;

// Does it name photos, and none of these?
bool IsOfOthers(const Remark& said, const std::set<std::string>& added) {
  bool names_any = false;
  for (const char* which : {"photo", "first", "last"}) {
    const auto value = said.values.find(which);
    const std::string* name =
        value == said.values.end() ? nullptr : std::get_if<std::string>(&value->second.is);
    if (name == nullptr) continue;
    if (added.contains(*name)) return false;
    names_any = true;
  }
  return names_any;
}

bool IsSaid(const Remark& now, const std::vector<Remark>& said) {
  return std::any_of(said.begin(), said.end(),
                     [&](const Remark& one) { return AreSameButForNumbers(one, now); });
}

bool IsOfGroups(const Remark& said) {
  return said.code == RemarkCode::kGroups || said.code == RemarkCode::kNoTies;
}

}  // namespace

void AddFigures(const alignment::AlignReport& part, const std::set<std::string>& added,
                const std::vector<AlignedPhoto>& photos, alignment::AlignReport& known) {
  double square_px = known.observations * known.residual_rms_px * known.residual_rms_px;
  const auto count = [&](const AlignPhotoReport& photo, int sign) {
    known.photos += sign;
    if (photo.placement == Placement::kAligned) known.aligned += sign;
    known.observations += sign * photo.observations;
    square_px += sign * photo.observations * photo.residual_rms_px * photo.residual_rms_px;
  };
  const auto count_pair = [&](const AlignPairReport& pair, int sign) {
    int& pairs = pair.is_by_direct ? known.pairs_by_direct : known.pairs_linked;
    pairs = std::max(0, pairs + sign);
    if (!pair.is_by_direct) known.pairs_tried = std::max(0, known.pairs_tried + sign);
  };
  const auto is_of_added = [&](const AlignPairReport& pair) {
    return added.contains(pair.first) || added.contains(pair.second);
  };
  std::erase_if(known.photo_reports, [&](const AlignPhotoReport& photo) {
    if (!added.contains(photo.name)) return false;
    count(photo, -1);
    return true;
  });
  std::erase_if(known.pairs, [&](const AlignPairReport& pair) {
    if (!is_of_added(pair)) return false;
    count_pair(pair, -1);
    return true;
  });
  for (const AlignPhotoReport& photo : part.photo_reports) {
    if (!added.contains(photo.name)) continue;
    count(photo, 1);
    known.photo_reports.push_back(photo);
  }
  for (const AlignPairReport& pair : part.pairs) {
    if (!is_of_added(pair)) continue;
    count_pair(pair, 1);
    known.pairs.push_back(pair);
  }
  known.tie_points += part.tie_points_of_new;
  known.observations = std::max(0, known.observations);
  if (known.observations > 0)
    known.residual_rms_px = std::sqrt(std::max(0.0, square_px) / known.observations);
  for (const Remark& correction : part.corrections) {
    if (!IsOfOthers(correction, added) && !IsSaid(correction, known.corrections))
      known.corrections.push_back(correction);
  }
  known.components = GroupsByTies(photos, known.pairs).count;
}

bool SayAnew(const Remark& now, std::vector<Remark>& warnings) {
  bool is_said = false;
  for (Remark& said : warnings) {
    if (AreSameButForNumbers(said, now)) {
      said = now;
      is_said = true;
      continue;
    }
    for (auto& [name, value] : said.values) {
      auto* within = std::get_if<std::vector<Remark>>(&value.is);
      if (within != nullptr && SayAnew(now, *within)) is_said = true;
    }
  }
  return is_said;
}

void TellPosed(const std::vector<Remark>& posed, bool is_placed, std::vector<Remark>& warnings) {
  std::vector<Remark> now = posed;
  // Somebody said since where it lies, or surveyed points did.
  if (is_placed)
    std::erase_if(now, [](const Remark& one) { return one.code == RemarkCode::kReckonedFromNowhere; });
  std::erase_if(warnings, [&](const Remark& said) { return !HasRemark(now, said) && IsSaid(said, now); });
  for (const Remark& one : now) {
    if (!HasRemark(warnings, one)) warnings.push_back(one);
  }
}

void TellAligned(const std::vector<Remark>& aligned, const std::set<std::string>& added,
                 std::vector<Remark>& warnings) {
  for (const Remark& now : aligned) {
    if (!IsOfGroups(now) && !IsOfOthers(now, added) && !IsSaid(now, warnings)) warnings.push_back(now);
  }
}

void TellGroups(int groups, std::size_t photos, std::vector<Remark>& warnings) {
  const auto before = std::find_if(warnings.begin(), warnings.end(), IsOfGroups);
  if (groups == 1 || photos < 2) {
    std::erase_if(warnings, IsOfGroups);
    return;
  }
  Remark now = groups == 0 ? Remark(RemarkCode::kNoTies) : Remark(RemarkCode::kGroups, {{"groups", groups}});
  if (before == warnings.end())
    warnings.push_back(std::move(now));
  else
    *before = std::move(now);
}

void TellAdded(std::size_t photos, std::vector<Remark>& warnings) {
  auto all = static_cast<std::int64_t>(photos);
  std::erase_if(warnings, [&](const Remark& said) {
    if (said.code != RemarkCode::kPhotosAdded) return false;
    const auto before = said.values.find("photos");
    const std::int64_t* count =
        before == said.values.end() ? nullptr : std::get_if<std::int64_t>(&before->second.is);
    if (count != nullptr) all += *count;
    return true;
  });
  warnings.push_back({RemarkCode::kPhotosAdded, {{"photos", all}}});
}

}  // namespace skyquilt::pipeline
