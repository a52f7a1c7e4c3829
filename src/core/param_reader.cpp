// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>

#include "core/log.h"
#include "core/params.h"

namespace brume {

namespace {

/// Lists longer than this are moved out of the parameter set, which nobody reads twice.
constexpr std::size_t kMovedListLength = 64;

template <class T>
std::vector<T> takeList(Param& param) {
  auto& list = std::get<std::vector<T>>(param.values);
  return list.size() > kMovedListLength ? std::move(list) : list;
}

std::string rangeText(const ParamDecl& decl) {
  const bool hasLo = decl.lo > std::numeric_limits<float>::lowest(),
             hasHi = decl.hi < std::numeric_limits<int>::max();
  // As the float that was declared, which has fewer digits than its double.
  const auto bound = [&decl](double v) {
    return decl.type == ParamType::Integer ? fmt::format("{}", v)
                                           : fmt::format("{}", static_cast<float>(v));
  };
  if (hasLo && hasHi) return fmt::format("between {} and {}", bound(decl.lo), bound(decl.hi));
  if (hasLo) return fmt::format("{} {}", decl.openLo ? "greater than" : "at least", bound(decl.lo));
  return fmt::format("at most {}", bound(decl.hi));
}

}  // namespace

ParamReader::ParamReader(std::vector<ParamSet*> sets, std::string pluginName,
                         std::string searchDirectory, TextureLookup* textures, Log& log)
    : sets_(std::move(sets)),
      pluginName_(std::move(pluginName)),
      searchDirectory_(std::move(searchDirectory)),
      textures_(textures),
      log_(log) {
  BRUME_CHECK(!sets_.empty());
}

const SourceLocation& ParamReader::where() const { return sets_.front()->where(); }

SourceLocation ParamReader::whereOf(std::string_view name) const {
  for (const ParamSet* set : sets_)
    if (const Param* p = set->findName(name)) return p->where;
  return where();
}

bool ParamReader::isGiven(std::string_view name) const {
  for (const ParamSet* set : sets_)
    if (set->findName(name)) return true;
  return false;
}

void ParamReader::alias(std::string_view other, std::string_view name) {
  aliases_.emplace_back(other, name);
  declared_.emplace_back(other);
}

void ParamReader::declare(const ParamDecl& decl) { declared_.emplace_back(decl.name); }

void ParamReader::fail(const Param& param, const std::string& text) const {
  throw SceneError(param.where, fmt::format("parameter \"{} {}\" of '{}' {}", toString(param.type),
                                            param.name, pluginName_, text));
}

void ParamReader::checkRange(const Param& param, const ParamDecl& decl, double value) const {
  if (!std::isfinite(value)) fail(param, "is not a finite number");
  const bool inside = (decl.openLo ? value > decl.lo : value >= decl.lo) && value <= decl.hi;
  if (!inside) fail(param, fmt::format("is {}, but must be {}", value, rangeText(decl)));
}

/// The parameter of this name and type from the first set that has it, its count checked (0: any).
/// A parameter of that name with another type is an error.
Param* ParamReader::find(const ParamDecl& decl, ParamType type, std::size_t exactCount) {
  std::vector<std::string_view> names{decl.name};
  for (const auto& [other, name] : aliases_)
    if (name == decl.name) names.push_back(other);

  const Param* otherType = nullptr;
  for (ParamSet* set : sets_) {
    for (std::string_view name : names) {
      if (Param* p = set->find(type, name)) {
        p->used = true;
        if (exactCount != 0 && p->count() != exactCount)
          fail(*p, fmt::format("has {} values, but takes {}", p->count(), exactCount));
        return p;
      }
      const Param* p = set->findName(name);
      const bool isTexture = decl.isTexture && p && p->type == ParamType::Texture;
      if (p && !isTexture && !p->used && !otherType) otherType = p;
    }
  }
  if (otherType)
    fail(*otherType,
         fmt::format("has the wrong type: it takes \"{} {}\"{}", toString(type), decl.name,
                     decl.isTexture ? fmt::format(" or \"texture {}\"", decl.name) : ""));
  return nullptr;
}

Param* ParamReader::findTexture(const ParamDecl& decl) {
  for (ParamSet* set : sets_) {
    if (Param* p = set->find(ParamType::Texture, decl.name)) {
      p->used = true;
      if (p->count() != 1)
        fail(*p, fmt::format("has {} values, but takes one texture name", p->count()));
      return p;
    }
  }
  return nullptr;
}

void ParamReader::visitFloat(const ParamDecl& decl, std::optional<float>& v) {
  declare(decl);
  if (const Param* p = find(decl, ParamType::Float, 1)) {
    v = std::get<std::vector<float>>(p->values).front();
    checkRange(*p, decl, *v);
  }
}

void ParamReader::visitInt(const ParamDecl& decl, std::optional<int>& v) {
  declare(decl);
  if (const Param* p = find(decl, ParamType::Integer, 1)) {
    v = std::get<std::vector<int>>(p->values).front();
    checkRange(*p, decl, *v);
  }
}

void ParamReader::visitBool(const ParamDecl& decl, bool& v) {
  declare(decl);
  if (const Param* p = find(decl, ParamType::Bool, 1))
    v = std::get<std::vector<bool>>(p->values).front();
}

void ParamReader::visitString(const ParamDecl& decl, std::string& v) {
  declare(decl);
  if (const Param* p = find(decl, ParamType::String, 1))
    v = std::get<std::vector<std::string>>(p->values).front();
}

void ParamReader::visitFile(const ParamDecl& decl, Filename& v) {
  declare(decl);
  const Param* p = find(decl, ParamType::String, 1);
  if (!p) return;
  v.written = std::get<std::vector<std::string>>(p->values).front();
  v.where = p->where;
  if (v.written.empty()) return;
  if (v.written.find('\0') != std::string::npos) fail(*p, "is no file name: it holds a zero byte");
  const std::filesystem::path path(v.written);
  v.path =
      path.is_absolute() ? v.written : (std::filesystem::path(searchDirectory_) / path).string();
}

void ParamReader::visitChoice(const ParamDecl& decl, std::size_t& index) {
  declare(decl);
  const Param* p = find(decl, ParamType::String, 1);
  if (!p) return;
  const std::string& word = std::get<std::vector<std::string>>(p->values).front();
  const auto it = std::find(decl.choices.begin(), decl.choices.end(), word);
  if (it == decl.choices.end())
    fail(*p, fmt::format("is '{}', but must be {}{}", word, listChoices(decl.choices),
                         nearestSpelling(word, decl.choices)));
  index = static_cast<std::size_t>(it - decl.choices.begin());
}

void ParamReader::visitColor(const ParamDecl& decl, Rgb& v) {
  declare(decl);
  if (const Param* p = find(decl, ParamType::Color, 1)) {
    v = std::get<std::vector<Rgb>>(p->values).front();
    for (int c = 0; c < 3; ++c) checkRange(*p, decl, v[c]);
  }
}

void ParamReader::visitVec3(const ParamDecl& decl, Vec3& v) {
  declare(decl);
  if (const Param* p = find(decl, decl.type, 1)) v = std::get<std::vector<Vec3>>(p->values).front();
}

void ParamReader::visitFloatTexture(const ParamDecl& decl, std::optional<FloatSlot>& v) {
  declare(decl);
  if (const Param* p = findTexture(decl)) {
    const std::string& name = std::get<std::vector<std::string>>(p->values).front();
    const Texture<float>* texture = textures_ ? textures_->findFloatTexture(name) : nullptr;
    if (!texture) {
      const auto names = textures_ ? textures_->textureNames(true) : std::vector<std::string>{};
      fail(*p, fmt::format("names '{}', but there is no float texture of that name{}", name,
                           nearestSpelling(name, names)));
    }
    v = FloatSlot{0, texture};
  } else if (const Param* value = find(decl, ParamType::Float, 1)) {
    v = FloatSlot{std::get<std::vector<float>>(value->values).front(), nullptr};
    checkRange(*value, decl, v->constant);
  }
}

void ParamReader::visitRgbTexture(const ParamDecl& decl, RgbSlot& v) {
  declare(decl);
  if (const Param* p = findTexture(decl)) {
    const std::string& name = std::get<std::vector<std::string>>(p->values).front();
    const Texture<Rgb>* texture = textures_ ? textures_->findRgbTexture(name) : nullptr;
    if (!texture) {
      const auto names = textures_ ? textures_->textureNames(false) : std::vector<std::string>{};
      fail(*p, fmt::format("names '{}', but there is no color texture of that name{}", name,
                           nearestSpelling(name, names)));
    }
    v = RgbSlot{Rgb(), texture};
  } else if (const Param* value = find(decl, ParamType::Color, 1)) {
    Rgb color = std::get<std::vector<Rgb>>(value->values).front();
    // Reflectances that were given as spectra may lie outside of Rec. 709: PBRT-v2 cuts them at 0.
    if (decl.lo == 0 && color.isFinite() && color.minChannel() < 0) {
      log_.warning(value->where, fmt::format("\"{}\" has a negative component, ({:g}, {:g}, {:g}); "
                                             "it counts as 0",
                                             decl.name, color.r, color.g, color.b));
      color = max(color, 0.f);
    }
    v = RgbSlot{color, nullptr};
    for (int c = 0; c < 3; ++c) checkRange(*value, decl, color[c]);
  }
}

void ParamReader::visitFloats(const ParamDecl& decl, std::optional<std::vector<float>>& v) {
  declare(decl);
  if (Param* p = find(decl, ParamType::Float, decl.listCount)) {
    v = takeList<float>(*p);
    for (float x : *v) checkRange(*p, decl, x);
  }
}

void ParamReader::visitInts(const ParamDecl& decl, std::vector<int>& v) {
  declare(decl);
  if (Param* p = find(decl, ParamType::Integer, decl.listCount)) {
    v = takeList<int>(*p);
    for (int x : v) checkRange(*p, decl, x);
  }
}

void ParamReader::visitVec3s(const ParamDecl& decl, std::vector<Vec3>& v) {
  declare(decl);
  if (Param* p = find(decl, decl.type, decl.listCount)) v = takeList<Vec3>(*p);
}

void ParamReader::visitStrings(const ParamDecl& decl, std::vector<std::string>& v) {
  declare(decl);
  if (Param* p = find(decl, ParamType::String, decl.listCount)) v = takeList<std::string>(*p);
}

}  // namespace brume
