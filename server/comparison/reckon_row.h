// ReckonRow: dead reckoning as a row of the comparison: how far displacement from raw inertial samples
// between captures drifts from what GNSS recorded (core/poses/reckoning). It places no photo. None where no
// log has raw inertial samples that cover two photos. Starts threads: call it after the methods' processes.
// Blocking.
#pragma once

#include <optional>
#include <vector>

#include "server/comparison/compare_methods.h"

namespace skyquilt::server {

std::optional<MethodOutcome> ReckonRow(const std::vector<flight::InputFile>& files);

}  // namespace skyquilt::server
