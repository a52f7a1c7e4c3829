// SPDX-License-Identifier: Apache-2.0
// Optical depth along beams in a few operations, for photons that ask for it again and again.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/medium_along_ray.h"

namespace brume {

/// A stretch of a beam on which the density is a cubic. With x = (s - s0) perLength, kept in
/// [0, 1], s the length from the beam's t0,
///   D(s) = depth + x (c[0] + x (c[1] + x (c[2] + x c[3])))
/// Up to `next`, where the next stretch begins, D stays what it is at x = 1: there is no medium.
struct DepthSegment {
  float s0, next, perLength, depth;
  std::array<float, 4> c;
};

/// Tables of optical depth, each filled from a MediumAlongRay when it is asked for the first time.
/// The depth of channel k is sigma[k] D_k(s); one D serves all channels wherever they are
/// proportional. Grids are exact to rounding in float (about 1e-7 of the depth), exponential
/// densities to 1e-6 of it. Memory: 36 bytes for each piece of medium and curve; at kMostSegments
/// all tables are forgotten and filled anew.
class DepthTables {
 public:
  /// 64 MB.
  static constexpr std::size_t kMostSegments = std::size_t{1} << 21;

  /// `count` tables, none of them filled.
  void reset(std::size_t count);
  bool isFilled(std::size_t table) const { return tables_[table].curves != 0; }
  /// s is counted from t0.
  void fill(std::size_t table, const MediumAlongRay& medium, float t0);

  struct Depth {
    std::array<float, 3> of;  ///< channels
    bool isGrey;              ///< they are equal
  };
  /// At s, of a table that is filled.
  Depth at(std::size_t table, float s) const;

 private:
  struct Table {
    std::uint32_t first = 0, count = 0;  // segments of the first curve; the others follow
    float begin = 0, bucketsPerLength = 0;
    std::array<float, 3> sigma{};
    std::uint32_t curves = 0;  // 0: not filled
    bool isGrey = true;
  };
  class Filler;

  std::vector<Table> tables_;
  std::vector<DepthSegment> segments_;
  /// As many as segments, evenly spread over s, at Table::first: the last segment of the first
  /// curve that begins before each.
  std::vector<std::uint32_t> buckets_;
};

inline DepthTables::Depth DepthTables::at(std::size_t index, float s) const {
  const Table& table = tables_[index];
  const float place = std::clamp((s - table.begin) * table.bucketsPerLength, 0.f,
                                 static_cast<float>(table.count - 1));
  const DepthSegment* segment =
      &segments_[buckets_[table.first + static_cast<std::uint32_t>(place)]];
  while (s >= segment->next) ++segment;
  const float x = std::clamp((s - segment->s0) * segment->perLength, 0.f, 1.f);
  const auto value = [x](const DepthSegment& d) {
    return d.depth + x * (d.c[0] + x * (d.c[1] + x * (d.c[2] + x * d.c[3])));
  };
  if (table.curves == 1) {
    const float D = value(*segment);
    return {{table.sigma[0] * D, table.sigma[1] * D, table.sigma[2] * D}, table.isGrey};
  }
  return {{value(*segment), value(segment[table.count]), value(segment[2 * table.count])}, false};
}

}  // namespace brume
