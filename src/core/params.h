// SPDX-License-Identifier: Apache-2.0
// Parameters: what a scene file gave (ParamSet) and what a plugin declares (its Params::visit). One
// declaration serves reading, range checks, error texts, the manual and the metadata of the image.
//
//   struct Params {
//     float radius = 1;
//     void visit(ParamVisitor& v) { v(radius, "radius", kPositive, Unit::Length, "radius of the
//     sphere"); }
//   };
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/error.h"
#include "core/math.h"
#include "core/rgb.h"
#include "core/texture.h"

namespace brume {

class Log;

/// The types of the scene language; Color stands for color, rgb, xyz, blackbody and spectrum, all
/// converted on reading.
enum class ParamType { Float, Integer, Bool, Point, Vector, Normal, String, Texture, Color };
std::string_view toString(ParamType type);

/// One "type name" [values] of a scene file.
struct Param {
  using Values = std::variant<std::vector<float>, std::vector<int>, std::vector<bool>,
                              std::vector<Vec3>, std::vector<Rgb>, std::vector<std::string>>;
  ParamType type = ParamType::Float;
  std::string name;
  SourceLocation where;
  Values values;
  bool used = false;  ///< some plugin has declared it

  std::size_t count() const;
};

/// The parameter list of one directive. A later parameter of the same type and name replaces the
/// earlier.
class ParamSet {
 public:
  ParamSet() = default;
  explicit ParamSet(const SourceLocation& where) : where_(where) {}

  void add(Param param);
  Param* find(ParamType type, std::string_view name);
  /// Any parameter of that name, whatever its type.
  const Param* findName(std::string_view name) const;
  std::span<Param> params() { return params_; }
  std::span<const Param> params() const { return params_; }
  const SourceLocation& where() const { return where_; }

 private:
  SourceLocation where_;
  std::vector<Param> params_;
};

/// Closed interval [lo, hi], or (lo, hi] when open; values outside are errors, never clamped.
template <class T>
struct Range {
  T lo = std::numeric_limits<T>::lowest();
  T hi = std::numeric_limits<T>::max();
  bool openLo = false;
  constexpr bool contains(T v) const { return (openLo ? v > lo : v >= lo) && v <= hi; }
};
inline constexpr Range<float> kAnyFloat{};
inline constexpr Range<float> kPositive{0.f, std::numeric_limits<float>::max(), true};
inline constexpr Range<float> kNonNegative{0.f};
inline constexpr Range<float> kUnitInterval{0.f, 1.f};
inline constexpr Range<int> kAnyInt{};
inline constexpr Range<int> kPositiveInt{1};
inline constexpr Range<int> kNonNegativeInt{0};

enum class Unit {
  None,
  Length,
  InverseLength,
  Degrees,
  Radiance,
  RadiantIntensity,
  RadiancePerLength,
  Time,
  Pixels,
  Samples,
  Photons,
  Seconds
};
std::string_view toString(Unit unit);

/// A string parameter that names a file, resolved against the search directory of the scene.
struct Filename {
  std::string path;     ///< resolved; empty when not given
  std::string written;  ///< as in the scene
  SourceLocation where;
  bool isGiven() const { return !path.empty(); }
};

/// One declared parameter, as the visitors see it.
struct ParamDecl {
  std::string_view name;
  ParamType type = ParamType::Float;
  bool isList = false;        ///< any number of values
  std::size_t listCount = 0;  ///< exact number of values for a list of fixed size, 0 = any
  bool isTexture = false;     ///< a value of `type` or a texture of it
  bool isFile = false;
  Unit unit = Unit::None;
  double lo = std::numeric_limits<double>::lowest(), hi = std::numeric_limits<double>::max();
  bool openLo = false;
  std::vector<std::string> choices;  ///< not empty: one of these strings
  std::string_view text;
};

/// What Params::visit calls, once per parameter. Fields keep their default when the scene is
/// silent; an optional field stays empty and the plugin's text says what that means.
class ParamVisitor {
 public:
  virtual ~ParamVisitor() = default;

  void operator()(float& v, std::string_view name, Range<float> range, Unit unit,
                  std::string_view text);
  void operator()(std::optional<float>& v, std::string_view name, Range<float> range, Unit unit,
                  std::string_view text);
  void operator()(int& v, std::string_view name, Range<int> range, Unit unit,
                  std::string_view text);
  void operator()(std::optional<int>& v, std::string_view name, Range<int> range, Unit unit,
                  std::string_view text);
  void operator()(bool& v, std::string_view name, std::string_view text);
  void operator()(std::string& v, std::string_view name, std::string_view text);
  void operator()(Filename& v, std::string_view name, std::string_view text);
  void operator()(Rgb& v, std::string_view name, Range<float> range, Unit unit,
                  std::string_view text);
  void operator()(FloatSlot& v, std::string_view name, Range<float> range, Unit unit,
                  std::string_view text);
  void operator()(RgbSlot& v, std::string_view name, Range<float> range, Unit unit,
                  std::string_view text);
  void operator()(std::optional<FloatSlot>& v, std::string_view name, Range<float> range, Unit unit,
                  std::string_view text);
  void operator()(std::vector<float>& v, std::string_view name, Range<float> range, Unit unit,
                  std::string_view text);
  void operator()(std::vector<int>& v, std::string_view name, Range<int> range, Unit unit,
                  std::string_view text);
  void operator()(std::vector<std::string>& v, std::string_view name, std::string_view text);
  /// Exactly four floats (screen and crop windows).
  void operator()(std::optional<std::array<float, 4>>& v, std::string_view name, Range<float> range,
                  Unit unit, std::string_view text);

  void point(Vec3& v, std::string_view name, Unit unit, std::string_view text) {
    vec3(ParamType::Point, v, name, unit, text);
  }
  void vector(Vec3& v, std::string_view name, Unit unit, std::string_view text) {
    vec3(ParamType::Vector, v, name, unit, text);
  }
  void points(std::vector<Vec3>& v, std::string_view name, std::string_view text) {
    vec3s(ParamType::Point, v, name, text);
  }
  void vectors(std::vector<Vec3>& v, std::string_view name, std::string_view text) {
    vec3s(ParamType::Vector, v, name, text);
  }
  void normals(std::vector<Vec3>& v, std::string_view name, std::string_view text) {
    vec3s(ParamType::Normal, v, name, text);
  }

  /// One of a fixed set of words: v(mode, "mode", {{"all", Mode::All}, {"one", Mode::One}},
  /// "text").
  template <class E>
  requires std::is_enum_v<E>
  void operator()(E& v, std::string_view name,
                  std::initializer_list<std::pair<const char*, E>> words, std::string_view text) {
    ParamDecl decl = make(name, ParamType::String, Unit::None, text);
    std::size_t index = 0, i = 0;
    for (const auto& [word, value] : words) {
      decl.choices.emplace_back(word);
      if (value == v) index = i;
      ++i;
    }
    visitChoice(decl, index);
    v = (words.begin() + index)->second;
  }

  /// A second name for a parameter declared afterwards (trianglemesh "st" = "uv").
  virtual void alias(std::string_view other, std::string_view name) = 0;

 protected:
  virtual void visitFloat(const ParamDecl&, std::optional<float>&) = 0;
  virtual void visitInt(const ParamDecl&, std::optional<int>&) = 0;
  virtual void visitBool(const ParamDecl&, bool&) = 0;
  virtual void visitString(const ParamDecl&, std::string&) = 0;
  virtual void visitFile(const ParamDecl&, Filename&) = 0;
  virtual void visitChoice(const ParamDecl&, std::size_t& index) = 0;
  virtual void visitColor(const ParamDecl&, Rgb&) = 0;
  virtual void visitVec3(const ParamDecl&, Vec3&) = 0;
  virtual void visitFloatTexture(const ParamDecl&, std::optional<FloatSlot>&) = 0;
  virtual void visitRgbTexture(const ParamDecl&, RgbSlot&) = 0;
  virtual void visitFloats(const ParamDecl&, std::optional<std::vector<float>>&) = 0;
  virtual void visitInts(const ParamDecl&, std::vector<int>&) = 0;
  virtual void visitVec3s(const ParamDecl&, std::vector<Vec3>&) = 0;
  virtual void visitStrings(const ParamDecl&, std::vector<std::string>&) = 0;

  static ParamDecl make(std::string_view name, ParamType type, Unit unit, std::string_view text);

 private:
  void vec3(ParamType type, Vec3& v, std::string_view name, Unit unit, std::string_view text);
  void vec3s(ParamType type, std::vector<Vec3>& v, std::string_view name, std::string_view text);
};

/// Finds named textures for a ParamReader; the SceneBuilder implements it.
class TextureLookup {
 public:
  virtual ~TextureLookup() = default;
  /// Null when no texture of that name exists in the name space.
  virtual const Texture<float>* findFloatTexture(const std::string& name) = 0;
  virtual const Texture<Rgb>* findRgbTexture(const std::string& name) = 0;
  /// For the error message.
  virtual std::vector<std::string> textureNames(bool isFloat) const = 0;
};

/// Fills a Params from parameter sets, the first one first. Texture parameters look for: texture in
/// each set in turn, then value in each set in turn, then the default (PBRT-v2's order). Long lists
/// are moved out of their set. Throws SceneError for a wrong type, count, range, NaN, unknown word
/// or unknown texture.
class ParamReader final : public ParamVisitor {
 public:
  ParamReader(std::vector<ParamSet*> sets, std::string pluginName, std::string searchDirectory,
              TextureLookup* textures, Log& log);

  const SourceLocation& where() const;  ///< of the directive
  const std::string& pluginName() const { return pluginName_; }
  Log& log() { return log_; }
  /// Where a parameter was given, else the directive.
  SourceLocation whereOf(std::string_view name) const;
  bool isGiven(std::string_view name) const;
  /// Names declared so far by this plugin's visit, for spelling suggestions.
  const std::vector<std::string>& declared() const { return declared_; }

  void alias(std::string_view other, std::string_view name) override;

 protected:
  void visitFloat(const ParamDecl&, std::optional<float>&) override;
  void visitInt(const ParamDecl&, std::optional<int>&) override;
  void visitBool(const ParamDecl&, bool&) override;
  void visitString(const ParamDecl&, std::string&) override;
  void visitFile(const ParamDecl&, Filename&) override;
  void visitChoice(const ParamDecl&, std::size_t& index) override;
  void visitColor(const ParamDecl&, Rgb&) override;
  void visitVec3(const ParamDecl&, Vec3&) override;
  void visitFloatTexture(const ParamDecl&, std::optional<FloatSlot>&) override;
  void visitRgbTexture(const ParamDecl&, RgbSlot&) override;
  void visitFloats(const ParamDecl&, std::optional<std::vector<float>>&) override;
  void visitInts(const ParamDecl&, std::vector<int>&) override;
  void visitVec3s(const ParamDecl&, std::vector<Vec3>&) override;
  void visitStrings(const ParamDecl&, std::vector<std::string>&) override;

 private:
  Param* find(const ParamDecl& decl, ParamType type, std::size_t exactCount);
  Param* findTexture(const ParamDecl& decl);
  void declare(const ParamDecl& decl);
  [[noreturn]] void fail(const Param& param, const std::string& text) const;
  void checkRange(const Param& param, const ParamDecl& decl, double value) const;

  std::vector<ParamSet*> sets_;
  std::string pluginName_;
  std::string searchDirectory_;
  TextureLookup* textures_;
  Log& log_;
  std::vector<std::string> declared_;
  std::vector<std::pair<std::string, std::string>> aliases_;  // other, name
};

/// One declared parameter with its present value as text: the manual (defaults) and the metadata
/// (effective values).
struct ParamRecord {
  std::string name, type, value, unit, range, text;
  std::vector<std::string> choices;
};

/// Lists what a Params declares and holds.
class ParamRecorder final : public ParamVisitor {
 public:
  std::vector<ParamRecord> records;

  void alias(std::string_view other, std::string_view name) override;

 protected:
  void visitFloat(const ParamDecl&, std::optional<float>&) override;
  void visitInt(const ParamDecl&, std::optional<int>&) override;
  void visitBool(const ParamDecl&, bool&) override;
  void visitString(const ParamDecl&, std::string&) override;
  void visitFile(const ParamDecl&, Filename&) override;
  void visitChoice(const ParamDecl&, std::size_t& index) override;
  void visitColor(const ParamDecl&, Rgb&) override;
  void visitVec3(const ParamDecl&, Vec3&) override;
  void visitFloatTexture(const ParamDecl&, std::optional<FloatSlot>&) override;
  void visitRgbTexture(const ParamDecl&, RgbSlot&) override;
  void visitFloats(const ParamDecl&, std::optional<std::vector<float>>&) override;
  void visitInts(const ParamDecl&, std::vector<int>&) override;
  void visitVec3s(const ParamDecl&, std::vector<Vec3>&) override;
  void visitStrings(const ParamDecl&, std::vector<std::string>&) override;

 private:
  void record(const ParamDecl& decl, std::string value);
};

/// Warns (PBRT-v2's plugins) or throws (brume's own) for every parameter of the set that nobody
/// declared.
enum class Origin { PbrtV2, Brume };
void reportUnusedParams(const ParamSet& set, std::string_view pluginName, Origin origin,
                        const std::vector<std::string>& declared, Log& log);

}  // namespace brume
