// JobOption: the options of a job, a row each: what clients call it, its type, range, unit and choices, what
// it is good for, and where it stands in MosaicOptions. Command line, JSON, checks and contract read this
// table. Those whose values are places, areas and lists stand in it by name alone, and are read where their
// form is known. Values; any thread.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/pipeline/mosaic_options.h"

namespace skyquilt::pipeline {

enum class JobOptionKind { kNumber, kWhole, kYesNo, kChoice, kOther };

struct JobOption {
  const char* name = "";  // in JSON; on the command line with dashes
  JobOptionKind kind = JobOptionKind::kOther;
  const char* unit = "";           // of a number, after its range
  double least = 0.0, most = 0.0;  // of a number
  bool may_be_open = false;        // null in JSON: as the photos have it
  bool decides_of_map = false;     // two maps that differ in it are two maps (MosaicOptions::InWords)
  std::span<const char* const> choices = {};
  const char* help = "";
  // A number as clients write it, the place of a choice among them, 1 for yes; nothing where it is open.
  std::optional<double> (*get)(const MosaicOptions& options) = nullptr;
  void (*set)(double value, MosaicOptions* options) = nullptr;

  std::string Flag() const;  // --max-look-deg
  // What a value must be, for messages: "must be a number between 10 and 75 degrees off the vertical".
  std::string Rule() const;
  bool Takes(double value) const { return value >= least && value <= most; }
};

std::span<const JobOption> JobOptionTable();
const JobOption* FindJobOption(std::string_view name);  // null: there is none

}  // namespace skyquilt::pipeline
