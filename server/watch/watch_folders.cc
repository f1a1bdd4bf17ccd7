#include "server/watch/watch_folders.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/base/process/folder_events.h"
#include "core/base/text/printable.h"
#include "core/base/try.h"

namespace skyquilt::server {
namespace {

using std::chrono::milliseconds;
namespace fs = std::filesystem;

// How long a look lasts where nothing wakes us, and where something would.
constexpr milliseconds kLookAgain{3'000}, kLookAgainThough{60'000}, kMounted{1'000};
constexpr std::size_t kPlacesLookedAt = 256;
constexpr milliseconds kFirstPause{2'000}, kLongestPause{60'000}, kAfterRefusal{600'000};

class Watch {
 public:
  Watch(const WatchOptions& options, SentLedger ledger, WatchTalk& talk)
      : options_(options),
        ledger_(std::move(ledger)),
        talk_(talk),
        card_(options.folders, options.rules.settle, options.passes_over) {}

  Result<WatchEnd> Run() {
    while (!talk_.IsCancelled()) {
      card_.Look([this] { return !talk_.IsCancelled(); });
      TellWhatIsThere();
      const CardFile::Clock::time_point now = CardFile::Clock::now();
      bool is_all_done = card_.roots_away().empty();
      for (const CardFlight& flight : FlightsOf(card_, options_.rules, now)) {
        if (talk_.IsCancelled()) break;
        const auto state = states_.find(flight.signature);
        if (state != states_.end() && state->second.is_done) continue;
        const bool must_wait = state != states_.end() && state->second.not_before > CardFile::Clock::now();
        if (!flight.is_settled || must_wait) {
          const bool was_refused = must_wait && state->second.is_refused;
          is_all_done = is_all_done && options_.once && was_refused;
          continue;
        }
        SKYQUILT_TRY(Treat(flight));
        is_all_done = false;
      }
      if (options_.once) {
        if (!card_.roots_away().empty())
          return Error{ErrorCode::kNotFound, card_.roots_away().front().string() + " is not there."};
        if (is_all_done && !IsAnythingUnread()) return end_;
      }
      Wait();
    }
    if (options_.once) return Error{ErrorCode::kCancelled, "Ended before all was sent."};
    return end_;
  }

 private:
  struct State {
    bool is_done = false, is_refused = false;
    CardFile::Clock::time_point not_before;
  };

  bool IsAnythingUnread() const {
    return std::any_of(card_.files().begin(), card_.files().end(), [&](const auto& entry) {
      const bool may_end = entry.second.kind == CardKind::kCut &&
                           CardFile::Clock::now() - entry.second.changed_at < 3 * options_.rules.settle;
      return may_end || entry.second.kind == CardKind::kUnread;
    });
  }

  bool IsAnythingUnsettled() const {
    const auto since = CardFile::Clock::now() - options_.rules.settle - milliseconds(500);
    return IsAnythingUnread() || is_waiting_ ||
           std::any_of(card_.files().begin(), card_.files().end(),
                       [&](const auto& entry) { return entry.second.changed_at > since; });
  }

  void TellWhatIsThere() {
    const std::vector<fs::path> away = card_.roots_away();
    for (const fs::path& root : options_.folders) {
      const bool is_away = std::find(away.begin(), away.end(), root) != away.end();
      talk_.SayOnce(root.string(),
                    is_away ? root.string() + " is not there; waiting for it" : "Watching " + root.string());
    }
    if (card_.has_too_many())
      talk_.SayOnce("many", fmt::format("There are more than {} files; the others are not looked at.",
                                        CardFiles::kMaxFiles));
    if (!card_.denied().empty())
      talk_.SayOnce("denied",
                    fmt::format("Not read, for want of permission: {} ({} first).",
                                Counted(card_.denied().size(), "folder"), card_.denied().front().string()));
    if (!card_.passed_over().empty())
      talk_.SayOnce("maps", fmt::format("Not sent, as parts of a map that was made there: {} ({} first).",
                                        Counted(card_.passed_over().size(), "file"),
                                        card_.passed_over().front().string()));
    const auto films = std::count_if(card_.files().begin(), card_.files().end(),
                                     [](const auto& entry) { return entry.second.kind == CardKind::kFilm; });
    if (films > 0)
      talk_.SayOnce("films", fmt::format("{} there; \"skyquilt upload\" sends films.",
                                         Counted(films, "film stays", "films stay")));
  }

  // Sends it, or says what keeps it from that and when it is tried again.
  Result<void> Treat(const CardFlight& flight) {
    talk_.BeginStage("upload");
    const Result<SentNow> sent = SendCardFlight(flight, card_, ledger_, options_.send, talk_);
    talk_.EndProgress();
    State& state = states_[flight.signature];
    if (sent) {
      state = {true, false, {}};
      away_since_.reset();
      pause_ = kFirstPause;
      talk_.Forget("server");
      Tell(flight, *sent);
      return {};
    }
    const Error& error = sent.error();
    switch (error.code) {
      case ErrorCode::kCancelled:
        return {};
      case ErrorCode::kUnauthorized:
      case ErrorCode::kInvalidArgument:
      case ErrorCode::kOutOfSpace:
        return error;
      case ErrorCode::kIo:
        // The disk went away, as a rule; what it is, the next look shows.
        talk_.SayOnce("disk " + flight.name, error.message + " Trying again when it can be read.");
        state.not_before = CardFile::Clock::now() + kFirstPause;
        return {};
      case ErrorCode::kUnavailable:
        return WaitForServer(error, state);
      default:
        if (!state.is_refused) ++end_.refused;
        state = {false, true, CardFile::Clock::now() + kAfterRefusal};
        talk_.SayOnce("refused " + flight.name, flight.name + " was not taken: " + error.message);
        return {};
    }
  }

  Result<void> WaitForServer(const Error& error, State& state) {
    const CardFile::Clock::time_point now = CardFile::Clock::now();
    if (!away_since_) away_since_ = now;
    if (options_.once && now - *away_since_ > options_.patience) return error;
    talk_.SayOnce("server", error.message + " It is asked again; nothing is lost.");
    state.not_before = now + pause_;
    pause_ = std::min(2 * pause_, kLongestPause);
    return {};
  }

  void Tell(const CardFlight& flight, const SentNow& sent) {
    if (sent.flight_id.empty()) {
      talk_.Say(fmt::format("{}: {}, sent before", flight.name, Counted(flight.photos.size(), "photo")));
      return;
    }
    end_.flights += sent.is_new ? 1 : 0;
    end_.files += sent.files;
    talk_.Say(fmt::format("{}: {} sent{}: {}/#/flights/{}", flight.name, Counted(sent.files, "file"),
                          sent.is_new ? "" : " to the flight they belong to", options_.send.server.url,
                          sent.flight_id));
    if (flight.cut_photos > 0)
      talk_.Say(fmt::format("{}: {} cut off or cannot be read; what is whole later follows", flight.name,
                            Counted(flight.cut_photos, "photo is", "photos are")));
  }

  // Until something happens in the folders, a disk comes or goes, a pause is over or a signal comes.
  void Wait() {
    events_.Watch(card_.folders());
    const CardFile::Clock::time_point now = CardFile::Clock::now();
    milliseconds time = events_.IsReliable() ? kLookAgainThough : kLookAgain;
    is_waiting_ = false;
    for (const auto& [signature, state] : states_) {
      if (state.is_done || state.not_before <= now) continue;
      time = std::min(time, std::chrono::ceil<milliseconds>(state.not_before - now));
    }
    if (IsAnythingUnsettled() || options_.once)
      time = std::clamp(options_.rules.settle / 4, milliseconds(100), milliseconds(2'000));
    const auto places = Places();
    for (const CardFile::Clock::time_point end = now + time;
         CardFile::Clock::now() < end && !talk_.IsCancelled();) {
      const auto left = std::chrono::ceil<milliseconds>(end - CardFile::Clock::now());
      if (events_.Wait(std::clamp(left, milliseconds(1), kMounted))) {
        events_.Wait(milliseconds(100));  // where one file comes, more do
        is_waiting_ = true;
        return;
      }
      if (Places() != places) return;
    }
  }

  std::vector<std::optional<std::pair<std::uint64_t, std::uint64_t>>> Places() const {
    std::vector<std::optional<std::pair<std::uint64_t, std::uint64_t>>> places;
    for (const fs::path& folder : options_.folders) places.push_back(PlaceOf(folder));
    // A card may be mounted below.
    const std::vector<fs::path>& found = card_.folders();
    for (std::size_t i = 0; i < std::min(found.size(), kPlacesLookedAt); ++i)
      places.push_back(PlaceOf(found[i]));
    return places;
  }

  const WatchOptions& options_;
  SentLedger ledger_;
  WatchTalk& talk_;
  CardFiles card_;
  FolderEvents events_;
  std::map<std::string, State> states_;
  std::optional<CardFile::Clock::time_point> away_since_;
  milliseconds pause_ = kFirstPause;
  bool is_waiting_ = false;
  WatchEnd end_;
};

}  // namespace

Result<WatchEnd> WatchFolders(const WatchOptions& options, WatchTalk& talk) {
  SKYQUILT_TRY_ASSIGN(SentLedger ledger, SentLedger::Open(options.ledger));
  return Watch(options, std::move(ledger), talk).Run();
}

}  // namespace skyquilt::server
