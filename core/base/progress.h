// Progress: how a long stage says how far it is and learns that it should stop.
// Stages take it last. Report and IsCancelled may be called from any thread of the stage.
#pragma once

#include <string_view>

namespace skyquilt {

class Progress {
 public:
  virtual ~Progress() = default;
  // A stage begins: `stage` is a stable word ("read", "pose", "align", "render", "export").
  virtual void BeginStage(std::string_view stage) = 0;
  // Fraction of the present stage, 0..1, with a short message for a person.
  virtual void Report(double fraction, std::string_view message) = 0;
  virtual bool IsCancelled() const = 0;
};

// Says nothing and is never cancelled.
class SilentProgress final : public Progress {
 public:
  void BeginStage(std::string_view) override {}
  void Report(double, std::string_view) override {}
  bool IsCancelled() const override { return false; }
};

}  // namespace skyquilt
