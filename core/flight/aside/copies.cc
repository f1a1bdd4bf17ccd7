#include "core/flight/aside/copies.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "core/flight/aside/alike.h"
#include "core/flight/aside/picture_name.h"
#include "core/flight/aside/previews.h"
#include "core/geo/geodesic.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kMaxMarks = 4;  // "DJI_0001 - Copy (2)-edited"
constexpr std::chrono::seconds kOneSecond{1};

bool HasFraction(UtcTime time) { return time.time_since_epoch() % kOneSecond != std::chrono::seconds(0); }

enum class Moments { kUnknown, kDiffer, kSameSecond, kSameInstant };

// By the camera's clock as it was written, which copies keep; UTC of the maker's tags is lost with these.
Moments MomentsOf(const Photo& a, const Photo& b) {
  if (!a.origin.clock || !b.origin.clock) return Moments::kUnknown;
  const UtcTime at_a = *a.origin.clock, at_b = *b.origin.clock;
  if (HasFraction(at_a) && HasFraction(at_b)) {
    constexpr std::chrono::milliseconds kRounding{10};
    return std::chrono::abs(at_a - at_b) <= kRounding ? Moments::kSameInstant : Moments::kDiffer;
  }
  return std::chrono::floor<std::chrono::seconds>(at_a) == std::chrono::floor<std::chrono::seconds>(at_b)
             ? Moments::kSameSecond
             : Moments::kDiffer;
}

// False where the records of two pictures cannot be of one exposure.
bool MayBeOneExposure(const Photo& a, const Photo& b) {
  const auto agree = [](const std::string& one, const std::string& other) {
    return one.empty() || other.empty() || one == other;
  };
  constexpr double kSameTime = 0.01;
  return agree(a.make, b.make) && agree(a.model, b.model) && agree(a.band_name, b.band_name) &&
         (a.lens == Lens::kUnsaid || b.lens == Lens::kUnsaid || a.lens == b.lens) &&
         (!a.exposure_time_s || !b.exposure_time_s ||
          AreNear(*a.exposure_time_s, *b.exposure_time_s, kSameTime));
}

// One picture in search of its original.
struct Picture {
  PictureName name;
  std::string plain;  // the stem without all marks of copies
  int marks = 0;      // how many these are
};

// The better is nearer to what the camera wrote. Of a file and what exiftool kept of it the changed one is
// meant, unless it lost what the other has.
auto RankOf(const Photo& photo, const Picture& picture) {
  return std::tuple(photo.origin.makers_records, photo.origin.clock.has_value(), !photo.origin.is_edited,
                    PhotoPixels(photo), photo.position.has_value(), !picture.name.is_before_a_change,
                    -picture.marks);
}

// Whether the copy has less of what cameras write, or names an editor that the other does not.
bool LostRecords(const Photo& copy, const Photo& original) {
  return copy.origin.makers_records < original.origin.makers_records ||
         copy.origin.is_edited > original.origin.is_edited;
}

// `mark`: the surest of those that one of the two names has more than the other.
bool IsCopyByName(const Photo& copy, const Photo& original, CopyMark mark) {
  const Moments moments = MomentsOf(copy, original);
  if (moments == Moments::kDiffer || !MayBeOneExposure(copy, original)) return false;
  if (mark == CopyMark::kNone && AreOfTwoSensors(copy, original)) return false;
  if (moments == Moments::kUnknown) {
    // Its records are gone: another flight's photo of that name would look the same but for its mark.
    return mark == CopyMark::kWord ||
           (mark != CopyMark::kNone && (copy.origin.is_edited || IsReducedTo(copy, original)));
  }
  if (LostRecords(copy, original) || IsReducedTo(copy, original) || mark == CopyMark::kWord) return true;
  // Numbered by an editor, or twice the same instant: no series has that.
  return mark != CopyMark::kNone &&
         (copy.origin.is_edited || (mark == CopyMark::kBrackets && moments == Moments::kSameInstant));
}

enum class Places { kUnknown, kSame, kMoved, kImpossible };

// Of two pictures of one second.
Places PlacesOf(const Photo& a, const Photo& b) {
  if (!a.position || !b.position) return Places::kUnknown;
  const double moved_m = geo::MetresApart(a.position->position, b.position->position);
  constexpr double kRoundingM = 0.5, kFastestM = 100.0;  // nothing that maps flies faster: a stale fix
  return moved_m <= kRoundingM ? Places::kSame : moved_m > kFastestM ? Places::kImpossible : Places::kMoved;
}

// Unlike a picture as its camera wrote it.
bool IsReworked(const Photo& photo) { return photo.origin.is_edited || photo.origin.makers_records == 0; }

class CopyFinder {
 public:
  // Those that `is_out` names are neither copies nor originals here.
  CopyFinder(const std::vector<Photo>& photos, const std::vector<std::optional<std::size_t>>& is_out)
      : photos_(photos) {
    for (std::size_t i = 0; i < photos.size(); ++i) {
      Picture picture;
      picture.name = PictureNameOf(photos[i].name);
      const std::vector<Unmarked> stems = StemsOf(picture);
      picture.plain = stems.back().stem;
      picture.marks = static_cast<int>(stems.size()) - 1;
      pictures_.push_back(std::move(picture));
      if (is_out[i]) continue;
      for (const Unmarked& stem : stems) by_stem_[stem.stem].push_back({i, stem.mark});
      if (photos[i].origin.clock) by_second_[SecondOf(i)].push_back(i);
      if (photos[i].origin.clock && photos[i].position && IsReworked(photos[i]))
        reworked_at_[PlaceKey(photos[i])].insert(SecondOf(i));
    }
  }

  // The best picture that `copy` is a copy of.
  std::optional<std::size_t> OriginalOf(std::size_t copy) const {
    std::optional<std::size_t> best;
    LookByName(copy, best);
    if (!best) LookByMoment(copy, best);
    return best;
  }

  bool IsBeforeAChange(std::size_t i, std::size_t of) const {
    return pictures_[i].name.is_before_a_change && AreOneFile(i, of);
  }

 private:
  struct Named {
    std::size_t photo = 0;
    CopyMark mark = CopyMark::kNone;  // that its name has beyond the stem
  };

  // The stem of a name, then without one mark of a copy after the other; beside each the surest taken.
  static std::vector<Unmarked> StemsOf(const Picture& picture) {
    std::vector<Unmarked> stems{{picture.name.stem, CopyMark::kNone}};
    while (stems.size() <= kMaxMarks) {
      auto next = WithoutCopyMark(stems.back().stem);
      if (!next) break;
      next->mark = std::max(next->mark, stems.back().mark);
      stems.push_back(*std::move(next));
    }
    return stems;
  }

  std::int64_t SecondOf(std::size_t i) const {
    return std::chrono::floor<std::chrono::seconds>(*photos_[i].origin.clock).time_since_epoch().count();
  }

  static std::pair<double, double> PlaceKey(const Photo& photo) {
    return {photo.position->position.lat_deg, photo.position->position.lon_deg};
  }

  // One that reworked pictures of several moments share. Alone, a place that is far away is that of another
  // aircraft in the same second.
  bool HasStalePosition(std::size_t i) const {
    const auto found = reworked_at_.find(PlaceKey(photos_[i]));
    return found != reworked_at_.end() && found->second.size() > 1;
  }

  // One is what exiftool kept of the other. What it changed may be the clock and the camera's name.
  bool AreOneFile(std::size_t i, std::size_t other) const {
    return pictures_[i].name.is_before_a_change != pictures_[other].name.is_before_a_change &&
           pictures_[i].name.file == pictures_[other].name.file &&
           PhotoPixels(photos_[i]) == PhotoPixels(photos_[other]);
  }

  // A total order: of two that equal in all else the first given.
  bool IsBetter(std::size_t i, std::size_t than) const {
    const auto a = RankOf(photos_[i], pictures_[i]), b = RankOf(photos_[than], pictures_[than]);
    return a != b ? a > b : i < than;
  }

  void Take(std::size_t i, std::optional<std::size_t>& best) const {
    if (!best || IsBetter(i, *best)) best = i;
  }

  void LookByName(std::size_t copy, std::optional<std::size_t>& best) const {
    const Photo& photo = photos_[copy];
    for (const Unmarked& stem : StemsOf(pictures_[copy])) {
      const std::vector<Named>& others = by_stem_.at(stem.stem);
      for (std::size_t k = 0; k < std::min(others.size(), kMaxLookedAt); ++k) {
        const std::size_t other = others[k].photo;
        if (other == copy || !IsBetter(other, copy)) continue;
        // Two copies of one that is not there: only where both are known to be copies.
        const bool are_both_marked = stem.mark != CopyMark::kNone && others[k].mark != CopyMark::kNone;
        if (are_both_marked && (!photo.origin.is_edited || !photos_[other].origin.is_edited)) continue;
        const bool is_one_kept =
            pictures_[copy].name.is_before_a_change != pictures_[other].name.is_before_a_change;
        const CopyMark mark = is_one_kept ? CopyMark::kWord : std::max(stem.mark, others[k].mark);
        if (AreOneFile(copy, other) || IsCopyByName(photo, photos_[other], mark)) Take(other, best);
      }
    }
  }

  // Renamed copies: only such as lost records or name an editor, of the one picture that they can be of.
  void LookByMoment(std::size_t copy, std::optional<std::size_t>& best) const {
    const Photo& photo = photos_[copy];
    if (!photo.origin.clock || photo.make.empty() || photo.model.empty()) return;
    if (!IsReworked(photo)) return;
    const std::vector<std::size_t>& others = by_second_.at(SecondOf(copy));
    if (others.size() > kMaxLookedAt) return;  // a clock that stands still tells nothing
    std::optional<std::size_t> elsewhere;
    std::size_t candidates = 0;
    for (const std::size_t other : others) {
      const Photo& original = photos_[other];
      const bool is_different =
          photo.software != original.software || PhotoPixels(photo) != PhotoPixels(original);
      if (other == copy || !is_different || !IsBetter(other, copy) || !LostRecords(photo, original) ||
          photo.make != original.make || photo.model != original.model ||
          !MayBeOneExposure(photo, original) || AreOfTwoSensors(photo, original) ||
          MomentsOf(photo, original) == Moments::kDiffer ||
          AreOfOneCounter(pictures_[copy].plain, pictures_[other].plain) || !SeeAlike(photo, original))
        continue;
      ++candidates;
      const Places places = PlacesOf(photo, original);
      if (places == Places::kSame) Take(other, best);
      if (places == Places::kUnknown || (places == Places::kImpossible && HasStalePosition(copy)))
        elsewhere = other;
    }
    if (!best && candidates == 1) best = elsewhere;
  }

  const std::vector<Photo>& photos_;
  std::vector<Picture> pictures_;
  std::unordered_map<std::string, std::vector<Named>> by_stem_;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> by_second_;
  std::map<std::pair<double, double>, std::set<std::int64_t>> reworked_at_;  // by place, in which seconds
};

}  // namespace

std::vector<std::optional<CopyOf>> FindCopies(const std::vector<Photo>& photos) {
  const auto previews = FindPreviews(photos);
  const CopyFinder finder(photos, previews);
  std::vector<std::optional<CopyOf>> copies(photos.size());
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const auto original = previews[i] ? previews[i] : finder.OriginalOf(i);
    if (original) copies[i] = CopyOf{*original, Aside::kCopy};
  }
  // Of a copy of a copy: each step goes to a better picture, so that it ends. None goes to a preview.
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!copies[i]) continue;
    std::size_t& original = copies[i]->original;
    while (copies[original]) original = copies[original]->original;
    if (finder.IsBeforeAChange(i, original)) copies[i]->why = Aside::kOlderMetadata;
  }
  return copies;
}

void LeaveOutCopies(std::vector<Photo>& photos, std::vector<LeftOutPhoto>& left_out) {
  const auto copies = FindCopies(photos);
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (copies[i])
      left_out.push_back(LeftAside(photos[i].name, copies[i]->why, photos[copies[i]->original].name));
  }
  std::size_t k = 0;
  std::erase_if(photos, [&](const Photo&) { return copies[k++].has_value(); });
}

}  // namespace skyquilt::flight
