// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace brume {

/// Makes `array` n items long, for a user that writes all of them again: the items are what they
/// were or default ones. Arrays that every pass fills keep their memory, because to fault its pages
/// in anew takes longer than to fill them. One that must grow does by a sixteenth more, so that
/// lengths that vary at random let it grow once, and its old items are not copied.
template <class T>
void resizeForReuse(std::vector<T>& array, std::size_t n) {
  if (n > array.capacity()) {
    array = {};
    array.reserve(n + n / 16);
  }
  array.resize(n);
}

}  // namespace brume
