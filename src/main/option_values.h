// SPDX-License-Identifier: Apache-2.0
// Values of command-line options. Each function throws SceneError that names the option, what was
// written and what is wanted.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/math.h"

namespace brume {

/// An option as it was written: `name` with its dashes, for messages.
struct WrittenOption {
  std::string name, value;
};

/// A whole number in [lo, hi].
std::int64_t parseWhole(const WrittenOption& option, std::int64_t lo, std::int64_t hi);
/// Any unsigned 64-bit number.
std::uint64_t parseSeed(const WrittenOption& option);
/// A finite number that is above zero, or zero where that makes sense.
enum class Zero { Allowed, Refused };
double parseNumber(const WrittenOption& option, Zero zero);
/// "60s", "2m", "1.5h" or plain seconds.
double parseDuration(const WrittenOption& option);
/// "640x480".
Vec2i parseResolution(const WrittenOption& option);
/// "x0,x1,y0,y1": fractions of the image with x0 < x1 and y0 < y1.
std::array<float, 4> parseCrop(const WrittenOption& option);

}  // namespace brume
