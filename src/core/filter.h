// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "core/math.h"
#include "core/params.h"

namespace brume {

/// Largest half-width of a filter [pixels]: bounds the work per sample.
inline constexpr float kMaxFilterRadius = 64;
/// Range of the half-widths that filters declare.
inline constexpr Range<float> kFilterRadiusRange{0.f, kMaxFilterRadius, true};

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
  /// Whether the weight is 1 everywhere within the radius: the film need not ask for it.
  virtual bool isConstant() const { return false; }
};

}  // namespace brume
