// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <type_traits>

#include "core/error.h"
#include "core/math.h"
#include "core/rgb.h"
#include "core/transform.h"

namespace brume {

/// Where and how widely a texture is looked up.
struct TextureContext {
  Vec3 p{0};              ///< scene space (the scene file's world; render space + sceneOrigin)
  Vec3 dpdx{0}, dpdy{0};  ///< its change to the next sample in raster x and y
  Vec2 uv{0};             ///< surface parameters
  float dudx = 0, dvdx = 0, dudy = 0, dvdy = 0;
};

class FileCache;
class Log;

/// What a texture plugin is made from, beside its parameters.
struct TextureFactoryContext {
  Transform textureToScene;  ///< CTM at the Texture directive (start time), scene space
  SourceLocation where;
  Log* log = nullptr;
  FileCache* files = nullptr;  ///< of the scene; null outside of one
};

/// A value of type T (float or Rgb) over surfaces. Immutable and thread-safe.
template <class T>
class Texture {
 public:
  static constexpr std::string_view kPluginKind =
      std::is_same_v<T, float> ? "Texture float" : "Texture spectrum";
  using FactoryContext = TextureFactoryContext;
  virtual ~Texture() = default;
  virtual T evaluate(const TextureContext& at) const = 0;
};

/// A parameter that is a constant or a texture. A constant costs no virtual call. The Scene owns
/// the texture.
template <class T>
struct TextureSlot {
  T constant{};
  const Texture<T>* texture = nullptr;

  T evaluate(const TextureContext& at) const { return texture ? texture->evaluate(at) : constant; }
  bool isConstant() const { return texture == nullptr; }
};
using FloatSlot = TextureSlot<float>;
using RgbSlot = TextureSlot<Rgb>;

}  // namespace brume
