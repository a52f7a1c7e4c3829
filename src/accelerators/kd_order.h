// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace brume {

class StridedPoints;

/// The order of finite points in which each block of 8, each 8 blocks, each 8 of those... is
/// compact: ranges are halved at whole children of the node above, across the widest side of their
/// box.
std::vector<std::uint32_t> kdOrder(const StridedPoints& points);

}  // namespace brume
