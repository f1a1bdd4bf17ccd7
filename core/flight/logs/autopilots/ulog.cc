#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/autopilots/ulog_topics.h"
#include "core/flight/logs/formats.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

constexpr std::array<std::uint8_t, 7> kMagic = {0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35};
constexpr std::array<std::uint8_t, 8> kSync = {0x2F, 0x73, 0x13, 0x20, 0x25, 0x0C, 0xBB, 0x12};
constexpr std::string_view kMessageTypes = "BFIMPQARDLCSO";
constexpr std::size_t kHeader = 16;
// A log of PX4 has a few hundred.
constexpr std::uint64_t kMaxSubscriptions = 10'000;

class UlogParser {
 public:
  UlogParser(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed)
      : name_(name), bytes_(bytes), consumed_(consumed), builder_("ulog", name), topics_(builder_) {}

  Result<FlightLog> Parse() {
    std::size_t at = kHeader;
    ConsumedSteps steps(consumed_);
    while (bytes_.size() - at >= 3) {
      steps.At(at);
      const std::size_t size = LoadLittle<std::uint16_t>(bytes_.data() + at);
      const auto type = static_cast<char>(bytes_[at + 2]);
      if (kMessageTypes.find(type) == std::string_view::npos || size == 0) {
        at = Resync(at);
        continue;
      }
      // A section that appended data follows may end inside a message.
      const std::size_t end = SectionEnd(at);
      if (at + 3 + size > end) {
        if (end == bytes_.size()) {
          cut_ = true;
          break;
        }
        at = end;
        continue;
      }
      Take(type, bytes_.subspan(at + 3, size));
      if (stop_) break;
      at += 3 + size;
    }
    if (bytes_.size() - at < 3 && at < bytes_.size()) cut_ = true;
    return Finish();
  }

 private:
  std::size_t SectionEnd(std::size_t at) const {
    std::size_t end = bytes_.size();
    for (const std::uint64_t offset : appended_) {
      if (offset > at && offset < end) end = static_cast<std::size_t>(offset);
    }
    return end;
  }

  // After damage: the next sync mark, an appended section, or a row of plausible messages.
  std::size_t Resync(std::size_t from) {
    std::size_t at = from + 1;
    for (; bytes_.size() - at >= 3; ++at) {
      if (IsSync(at) || std::find(appended_.begin(), appended_.end(), at) != appended_.end() ||
          LooksLikeMessages(at))
        break;
    }
    if (bytes_.size() - at < 3) at = bytes_.size();
    damaged_ += at - from;
    return at;
  }

  bool IsSync(std::size_t at) const {
    return bytes_.size() - at >= 11 && bytes_[at] == 8 && bytes_[at + 1] == 0 && bytes_[at + 2] == 'S' &&
           std::equal(kSync.begin(), kSync.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at) + 3);
  }

  bool LooksLikeMessages(std::size_t at) const {
    for (int i = 0; i < 4; ++i) {
      if (bytes_.size() - at < 5) return false;
      const std::size_t size = LoadLittle<std::uint16_t>(bytes_.data() + at);
      const auto type = static_cast<char>(bytes_[at + 2]);
      if (size == 0 || kMessageTypes.find(type) == std::string_view::npos || at + 3 + size > bytes_.size())
        return false;
      if (type == 'D' && !IsSubscribed(LoadLittle<std::uint16_t>(bytes_.data() + at + 3))) return false;
      at += 3 + size;
    }
    return true;
  }

  bool IsSubscribed(std::uint16_t id) const {
    return id < subscriptions_.size() && !subscriptions_[id].topic.empty();
  }

  void Take(char type, LogBytes payload) {
    switch (type) {
      case 'D':
        TakeData(payload);
        break;
      case 'A':
        Subscribe(payload);
        break;
      case 'F':
        if (!types_.Define(TextOf(payload))) builder_.Warn(RemarkCode::kFormatMalformed);
        break;
      case 'B':
        TakeFlags(payload);
        break;
      case 'O':
        ++dropouts_;
        if (payload.size() >= 2) dropout_ms_ += LoadLittle<std::uint16_t>(payload.data());
        break;
      case 'R':
        if (payload.size() >= 2 && IsSubscribed(LoadLittle<std::uint16_t>(payload.data()))) {
          subscriptions_[LoadLittle<std::uint16_t>(payload.data())].reader.reset();
        }
        break;
      default:
        break;
    }
  }

  void TakeFlags(LogBytes payload) {
    if (payload.size() < 40) return;
    bool unknown = false;
    for (std::size_t i = 8; i < 16; ++i) unknown = unknown || (payload[i] & (i == 8 ? 0xFE : 0xFF)) != 0;
    if (unknown) {
      builder_.Warn(RemarkCode::kUlogTooNew);
      stop_ = true;
    }
    // The message stands once, at the start.
    if ((payload[8] & 1) == 0 || !appended_.empty()) return;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto offset = LoadLittle<std::uint64_t>(payload.data() + 16 + 8 * i);
      if (offset > kHeader && offset < bytes_.size()) appended_.push_back(offset);
    }
  }

  void Subscribe(LogBytes payload) {
    if (payload.size() < 4) return;
    const std::uint8_t instance = payload[0];
    const auto id = LoadLittle<std::uint16_t>(payload.data() + 1);
    const std::string_view topic = TextOf(payload.subspan(3));
    if (topic.size() > 256) return;
    if (++subscribed_ > kMaxSubscriptions) return;
    if (id >= subscriptions_.size()) subscriptions_.resize(std::size_t{id} + 1);
    Subscription& subscription = subscriptions_[id];
    FlushCount(subscription);
    subscription.topic = topic;
    subscription.instance = instance;
    subscription.reader = nullptr;
    if (!types_.Knows(topic)) {
      builder_.Warn({RemarkCode::kTopicWithoutFormat, {{"topic", std::string(topic)}}});
    } else if (instance == 0) {
      subscription.reader = topics_.MakeReader(types_, subscription.topic);
    }
  }

  void TakeData(LogBytes payload) {
    if (payload.size() < 2) return;
    const auto id = LoadLittle<std::uint16_t>(payload.data());
    if (!IsSubscribed(id)) {
      ++unknown_;
      return;
    }
    Subscription& subscription = subscriptions_[id];
    ++subscription.count;
    ++messages_;
    if (subscription.reader) subscription.reader->Take(payload.subspan(2));
  }

  struct Subscription {
    std::string topic;
    int instance = 0;
    std::uint64_t count = 0;
    std::unique_ptr<UlogTopics::Reader> reader;
  };

  void FlushCount(Subscription& subscription) {
    if (subscription.topic.empty() || subscription.count == 0) return;
    const std::string suffix = subscription.instance == 0 ? "" : fmt::format("[{}]", subscription.instance);
    builder_.Count(subscription.topic + suffix, subscription.count);
    subscription.count = 0;
  }

  Result<FlightLog> Finish() {
    if (messages_ == 0) {
      return Because(ErrorCode::kCorrupt, {RemarkCode::kUlogEmpty, {{"file", name_}}},
                     fmt::format("{} bytes", bytes_.size()));
    }
    for (Subscription& subscription : subscriptions_) FlushCount(subscription);
    topics_.Finish();
    if (dropouts_ > 0) {
      builder_.Warn({RemarkCode::kRecorderDroppedOut,
                     {{"dropouts", dropouts_}, {"lost_s", static_cast<double>(dropout_ms_) * 1e-3}}});
    }
    if (damaged_ > 0) builder_.Warn({RemarkCode::kBytesDamaged, {{"bytes", damaged_}}});
    if (unknown_ > 0) builder_.Warn({RemarkCode::kMessagesUnknown, {{"messages", unknown_}}});
    if (subscribed_ > kMaxSubscriptions)
      builder_.Warn({RemarkCode::kSubscriptionsBeyond, {{"most", kMaxSubscriptions}}});
    if (cut_) builder_.Warn(RemarkCode::kCutInMessage);
    return std::move(builder_).Finish();
  }

  std::string_view name_;
  LogBytes bytes_;
  const ConsumedUpTo& consumed_;
  LogBuilder builder_;
  UlogTypes types_;
  UlogTopics topics_;
  std::vector<Subscription> subscriptions_;
  std::vector<std::uint64_t> appended_;
  std::uint64_t subscribed_ = 0;
  std::uint64_t messages_ = 0;
  std::uint64_t unknown_ = 0;
  std::uint64_t damaged_ = 0;
  std::uint64_t dropouts_ = 0;
  std::uint64_t dropout_ms_ = 0;
  bool cut_ = false;
  bool stop_ = false;
};

}  // namespace

bool LooksLikeUlog(LogBytes head) {
  return head.size() >= kMagic.size() && std::equal(kMagic.begin(), kMagic.end(), head.begin());
}

Result<FlightLog> ParseUlog(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  if (!LooksLikeUlog(bytes) || bytes.size() < kHeader) {
    return Because(ErrorCode::kCorrupt, {RemarkCode::kUlogBeginsOtherwise, {{"file", name}}});
  }
  return UlogParser(name, bytes, consumed).Parse();
}

}  // namespace skyquilt::flight
