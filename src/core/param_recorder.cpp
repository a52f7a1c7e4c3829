// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/params.h"

namespace brume {

namespace {

/// Longer lists are recorded by their length alone.
constexpr std::size_t kShownValues = 16;

std::string text(float v) { return fmt::format("{}", v); }
std::string text(int v) { return fmt::format("{}", v); }
std::string text(const std::string& v) { return fmt::format("\"{}\"", v); }
std::string text(const Vec3& v) { return fmt::format("{} {} {}", v.x, v.y, v.z); }
std::string text(const Rgb& v) { return fmt::format("{} {} {}", v.r, v.g, v.b); }

template <class T>
std::string listText(const std::vector<T>& list) {
  if (list.size() > kShownValues) return fmt::format("({} values)", list.size());
  std::string result;
  for (const T& v : list) {
    if (!result.empty()) result += ' ';
    result += text(v);
  }
  return result;
}

std::string typeText(const ParamDecl& decl) {
  std::string result(toString(decl.type));
  if (decl.isFile) result = "string (file)";
  if (decl.isTexture) result += " or texture";
  if (decl.listCount > 0) return fmt::format("{}[{}]", result, decl.listCount);
  return decl.isList ? result + "[]" : result;
}

std::string rangeText(const ParamDecl& decl) {
  const bool isNumber = decl.type == ParamType::Float || decl.type == ParamType::Integer ||
                        decl.type == ParamType::Color;
  if (!isNumber) return {};
  const bool isInt = decl.type == ParamType::Integer;
  const bool hasLo = decl.lo > (isInt ? std::numeric_limits<int>::min()
                                      : double{std::numeric_limits<float>::lowest()});
  const bool hasHi = decl.hi < (isInt ? std::numeric_limits<int>::max()
                                      : double{std::numeric_limits<float>::max()});
  // As the float that was declared, which has fewer digits than its double.
  const auto bound = [isInt](double v) {
    return isInt ? fmt::format("{}", v) : text(static_cast<float>(v));
  };
  if (hasLo && hasHi)
    return fmt::format("{}{}, {}]", decl.openLo ? "(" : "[", bound(decl.lo), bound(decl.hi));
  if (hasLo) return fmt::format("{} {}", decl.openLo ? ">" : ">=", bound(decl.lo));
  return hasHi ? fmt::format("<= {}", bound(decl.hi)) : std::string();
}

}  // namespace

void ParamRecorder::record(const ParamDecl& decl, std::string value) {
  records.push_back({std::string(decl.name), typeText(decl), std::move(value),
                     std::string(toString(decl.unit)), rangeText(decl), std::string(decl.text),
                     decl.choices});
}

void ParamRecorder::alias(std::string_view other, std::string_view name) {
  ParamRecord r;
  r.name = other;
  r.type = "alias";
  r.text = fmt::format("another name for \"{}\"", name);
  records.push_back(std::move(r));
}

void ParamRecorder::visitFloat(const ParamDecl& d, std::optional<float>& v) {
  record(d, v ? text(*v) : "");
}
void ParamRecorder::visitInt(const ParamDecl& d, std::optional<int>& v) {
  record(d, v ? text(*v) : "");
}
void ParamRecorder::visitBool(const ParamDecl& d, bool& v) { record(d, v ? "true" : "false"); }
void ParamRecorder::visitString(const ParamDecl& d, std::string& v) { record(d, text(v)); }
void ParamRecorder::visitFile(const ParamDecl& d, Filename& v) { record(d, text(v.written)); }
void ParamRecorder::visitChoice(const ParamDecl& d, std::size_t& index) {
  record(d, text(d.choices[index]));
}
void ParamRecorder::visitColor(const ParamDecl& d, Rgb& v) { record(d, text(v)); }
void ParamRecorder::visitVec3(const ParamDecl& d, Vec3& v) { record(d, text(v)); }
void ParamRecorder::visitFloatTexture(const ParamDecl& d, std::optional<FloatSlot>& v) {
  record(d, !v ? "" : v->isConstant() ? text(v->constant) : "(texture)");
}
void ParamRecorder::visitRgbTexture(const ParamDecl& d, RgbSlot& v) {
  record(d, v.isConstant() ? text(v.constant) : "(texture)");
}
void ParamRecorder::visitFloats(const ParamDecl& d, std::optional<std::vector<float>>& v) {
  record(d, v ? listText(*v) : "");
}
void ParamRecorder::visitInts(const ParamDecl& d, std::vector<int>& v) { record(d, listText(v)); }
void ParamRecorder::visitVec3s(const ParamDecl& d, std::vector<Vec3>& v) { record(d, listText(v)); }
void ParamRecorder::visitStrings(const ParamDecl& d, std::vector<std::string>& v) {
  record(d, listText(v));
}

}  // namespace brume
