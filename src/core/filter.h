// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "core/math.h"
#include "core/params.h"

namespace brume {

/// A separable reconstruction filter, w(x, y) = wx(x) wy(y), zero outside its radius. Not
/// normalised: the film divides by the sum of weights.
class Filter {
 public:
  static constexpr std::string_view kPluginKind = "PixelFilter";
  struct FactoryContext {
    SourceLocation where;
    Log* log = nullptr;
  };
  virtual ~Filter() = default;
  /// Half-widths [pixels].
  virtual Vec2 radius() const = 0;
  virtual float weightX(float dx) const = 0;
  virtual float weightY(float dy) const = 0;
  float weight(float dx, float dy) const { return weightX(dx) * weightY(dy); }
};

}  // namespace brume
