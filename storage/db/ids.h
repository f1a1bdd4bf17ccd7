// Ids made by the server: 26 characters of [0-9a-z] (Crockford's alphabet), 48 bits of time and 80 of the
// kernel's randomness, so that they cannot be guessed and sort by age; those of one process in the very order
// they were made. Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace skyquilt::storage {

// The kernel's randomness.
void FillWithRandom(std::span<std::uint8_t> bytes);
std::string NewId();
// What NewId makes from here on comes after this one, whatever the clock says; what is no id changes nothing.
void MakeIdsAfter(const std::string& id);
// True for what NewId could have made; everything else from outside is refused before it comes near a path.
bool IsId(std::string_view text);

}  // namespace skyquilt::storage
