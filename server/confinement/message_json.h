// What the messages between our processes share when they are written and read as JSON
// (server/jobs/job_messages.h, server/preview/preview_messages.h). Pure.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace skyquilt::server {

inline constexpr std::size_t kMaxErrorBytes = 4 * 1024;  // of an error's message, and of its detail
inline constexpr int kMaxPhotos = 10'000'000;            // that a message may speak of

// On one line. Texts of photos may hold any bytes: those that are no UTF-8 are replaced.
std::string DumpMessage(const nlohmann::json& json);

// A number beyond 0..kMaxPhotos comes as -1, which no figure is. Throws nlohmann::json::exception where it is
// no number.
int CountOf(const nlohmann::json& json);

}  // namespace skyquilt::server
