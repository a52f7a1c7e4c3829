// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/bsdf.h"
#include "core/interaction.h"
#include "core/params.h"

namespace brume {

/// How a surface scatters. Immutable and thread-safe.
class Material {
 public:
  static constexpr std::string_view kPluginKind = "Material";
  /// Named materials, for mix.
  struct FactoryContext {
    class Lookup {
     public:
      virtual ~Lookup() = default;
      virtual const Material* findMaterial(const std::string& name) = 0;
      virtual std::vector<std::string> materialNames() const = 0;
    };
    Lookup* named = nullptr;
    SourceLocation where;
    Log* log = nullptr;
    FileCache* files = nullptr;  ///< of the scene; null outside of one
  };

  virtual ~Material() = default;
  /// Fills bsdf (reset is called here, with the bumped shading frame) for the point `at`, whose
  /// footprint is computed.
  void evaluate(const SurfaceInteraction& at, Bsdf& bsdf) const;
  /// Whether any point of it can have a specular lobe (caustics), a non-specular one (visible
  /// points).
  virtual bool hasSpecular() const = 0;
  virtual bool hasNonSpecular() const = 0;
  /// Adds the lobes with the scale that the bsdf has.
  virtual void addLobes(const SurfaceInteraction& at, Bsdf& bsdf) const = 0;
  /// The most lobes that addLobes can add: mix refuses sums above Bsdf::kMaxLobes.
  virtual int maxLobes() const = 0;
  /// Displacement [scene length] for bump mapping; none by default.
  virtual const FloatSlot* bumpMap() const { return nullptr; }
  /// Whether evaluate looks at the tangents of the surface, which other rays than those with a
  /// footprint need not compute: for a bump map, or a lobe that differs along u and v.
  virtual bool usesTangents() const { return bumpMap() != nullptr; }
};

/// Shading normal and tangents of a displaced surface (Blinn 1978), as PBRT-v2: half-pixel steps in
/// u and v, 0.01 without footprint.
struct BumpedFrame {
  Vec3 ns, dpdu;
};
BumpedFrame bumpFrame(const SurfaceInteraction& at, const FloatSlot& displacement);

}  // namespace brume
