// SPDX-License-Identifier: Apache-2.0
// ParamSet and the declarations' common part; param_reader.cpp reads, param_recorder.cpp lists.
#include "core/params.h"

#include <fmt/format.h>

#include "core/log.h"

namespace brume {

std::string_view toString(ParamType type) {
  switch (type) {
    case ParamType::Float:
      return "float";
    case ParamType::Integer:
      return "integer";
    case ParamType::Bool:
      return "bool";
    case ParamType::Point:
      return "point";
    case ParamType::Vector:
      return "vector";
    case ParamType::Normal:
      return "normal";
    case ParamType::String:
      return "string";
    case ParamType::Texture:
      return "texture";
    case ParamType::Color:
      return "color";
  }
  return "";
}

std::string_view toString(Unit unit) {
  switch (unit) {
    case Unit::None:
      return "";
    case Unit::Length:
      return "scene length";
    case Unit::InverseLength:
      return "1/scene length";
    case Unit::Degrees:
      return "degrees";
    case Unit::Radiance:
      return "W m^-2 sr^-1";
    case Unit::RadiantIntensity:
      return "W/sr";
    case Unit::RadiancePerLength:
      return "W m^-2 sr^-1 per scene length";
    case Unit::Time:
      return "shutter time";
    case Unit::Pixels:
      return "pixels";
    case Unit::Samples:
      return "samples";
    case Unit::Photons:
      return "photons";
    case Unit::Seconds:
      return "s";
  }
  return "";
}

std::size_t Param::count() const {
  return std::visit([](const auto& list) { return list.size(); }, values);
}

void ParamSet::add(Param param) {
  if (Param* before = find(param.type, param.name))
    *before = std::move(param);
  else
    params_.push_back(std::move(param));
}

Param* ParamSet::find(ParamType type, std::string_view name) {
  for (Param& p : params_)
    if (p.type == type && p.name == name) return &p;
  return nullptr;
}

const Param* ParamSet::findName(std::string_view name) const {
  for (const Param& p : params_)
    if (p.name == name) return &p;
  return nullptr;
}

void reportUnusedParams(const ParamSet& set, std::string_view pluginName, Origin origin,
                        const std::vector<std::string>& declared, Log& log) {
  for (const Param& p : set.params()) {
    if (p.used) continue;
    std::string hint = nearestSpelling(p.name, declared);
    if (hint.empty() && !declared.empty()) hint = fmt::format("; choose {}", listChoices(declared));
    const std::string text = fmt::format("'{}' has no parameter \"{} {}\"{}", pluginName,
                                         toString(p.type), p.name, hint);
    if (origin == Origin::Brume) throw SceneError(p.where, text);
    log.warning(p.where, text);
  }
}

ParamDecl ParamVisitor::make(std::string_view name, ParamType type, Unit unit,
                             std::string_view text) {
  ParamDecl decl;
  decl.name = name;
  decl.type = type;
  decl.unit = unit;
  decl.text = text;
  return decl;
}

namespace {

template <class T>
ParamDecl withRange(ParamDecl decl, Range<T> range) {
  decl.lo = static_cast<double>(range.lo);
  decl.hi = static_cast<double>(range.hi);
  decl.openLo = range.openLo;
  return decl;
}

}  // namespace

void ParamVisitor::operator()(float& v, std::string_view name, Range<float> range, Unit unit,
                              std::string_view text) {
  std::optional<float> value = v;
  visitFloat(withRange(make(name, ParamType::Float, unit, text), range), value);
  v = *value;
}

void ParamVisitor::operator()(std::optional<float>& v, std::string_view name, Range<float> range,
                              Unit unit, std::string_view text) {
  visitFloat(withRange(make(name, ParamType::Float, unit, text), range), v);
}

void ParamVisitor::operator()(int& v, std::string_view name, Range<int> range, Unit unit,
                              std::string_view text) {
  std::optional<int> value = v;
  visitInt(withRange(make(name, ParamType::Integer, unit, text), range), value);
  v = *value;
}

void ParamVisitor::operator()(std::optional<int>& v, std::string_view name, Range<int> range,
                              Unit unit, std::string_view text) {
  visitInt(withRange(make(name, ParamType::Integer, unit, text), range), v);
}

void ParamVisitor::operator()(bool& v, std::string_view name, std::string_view text) {
  visitBool(make(name, ParamType::Bool, Unit::None, text), v);
}

void ParamVisitor::operator()(std::string& v, std::string_view name, std::string_view text) {
  visitString(make(name, ParamType::String, Unit::None, text), v);
}

void ParamVisitor::operator()(Filename& v, std::string_view name, std::string_view text) {
  ParamDecl decl = make(name, ParamType::String, Unit::None, text);
  decl.isFile = true;
  visitFile(decl, v);
}

void ParamVisitor::operator()(Rgb& v, std::string_view name, Range<float> range, Unit unit,
                              std::string_view text) {
  visitColor(withRange(make(name, ParamType::Color, unit, text), range), v);
}

void ParamVisitor::operator()(FloatSlot& v, std::string_view name, Range<float> range, Unit unit,
                              std::string_view text) {
  std::optional<FloatSlot> slot = v;
  ParamDecl decl = withRange(make(name, ParamType::Float, unit, text), range);
  decl.isTexture = true;
  visitFloatTexture(decl, slot);
  v = *slot;
}

void ParamVisitor::operator()(std::optional<FloatSlot>& v, std::string_view name,
                              Range<float> range, Unit unit, std::string_view text) {
  ParamDecl decl = withRange(make(name, ParamType::Float, unit, text), range);
  decl.isTexture = true;
  visitFloatTexture(decl, v);
}

void ParamVisitor::operator()(RgbSlot& v, std::string_view name, Range<float> range, Unit unit,
                              std::string_view text) {
  ParamDecl decl = withRange(make(name, ParamType::Color, unit, text), range);
  decl.isTexture = true;
  visitRgbTexture(decl, v);
}

void ParamVisitor::operator()(std::vector<float>& v, std::string_view name, Range<float> range,
                              Unit unit, std::string_view text) {
  ParamDecl decl = withRange(make(name, ParamType::Float, unit, text), range);
  decl.isList = true;
  std::optional<std::vector<float>> list = std::move(v);
  visitFloats(decl, list);
  v = std::move(*list);
}

void ParamVisitor::operator()(std::optional<std::array<float, 4>>& v, std::string_view name,
                              Range<float> range, Unit unit, std::string_view text) {
  ParamDecl decl = withRange(make(name, ParamType::Float, unit, text), range);
  decl.isList = true;
  decl.listCount = 4;
  std::optional<std::vector<float>> list;
  if (v) list = std::vector<float>(v->begin(), v->end());
  visitFloats(decl, list);
  if (list) {
    v.emplace();
    std::copy_n(list->begin(), 4, v->begin());
  }
}

void ParamVisitor::operator()(std::vector<int>& v, std::string_view name, Range<int> range,
                              Unit unit, std::string_view text) {
  ParamDecl decl = withRange(make(name, ParamType::Integer, unit, text), range);
  decl.isList = true;
  visitInts(decl, v);
}

void ParamVisitor::operator()(std::vector<std::string>& v, std::string_view name,
                              std::string_view text) {
  ParamDecl decl = make(name, ParamType::String, Unit::None, text);
  decl.isList = true;
  visitStrings(decl, v);
}

void ParamVisitor::vec3(ParamType type, Vec3& v, std::string_view name, Unit unit,
                        std::string_view text) {
  visitVec3(make(name, type, unit, text), v);
}

void ParamVisitor::vec3s(ParamType type, std::vector<Vec3>& v, std::string_view name,
                         std::string_view text) {
  ParamDecl decl = make(name, type, Unit::None, text);
  decl.isList = true;
  visitVec3s(decl, v);
}

}  // namespace brume
