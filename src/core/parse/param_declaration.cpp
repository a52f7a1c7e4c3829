// SPDX-License-Identifier: Apache-2.0
#include "core/parse/param_declaration.h"

#include <fmt/format.h>

#include <algorithm>

namespace brume {

namespace {

struct TypeWord {
  std::string_view word;
  ValueKind kind;
  ParamType type;
};
constexpr TypeWord kTypeWords[] = {{"float", ValueKind::Float, ParamType::Float},
                                   {"integer", ValueKind::Integer, ParamType::Integer},
                                   {"bool", ValueKind::Bool, ParamType::Bool},
                                   {"point", ValueKind::Point, ParamType::Point},
                                   {"vector", ValueKind::Vector, ParamType::Vector},
                                   {"normal", ValueKind::Normal, ParamType::Normal},
                                   {"string", ValueKind::String, ParamType::String},
                                   {"texture", ValueKind::Texture, ParamType::Texture},
                                   {"color", ValueKind::Rgb, ParamType::Color},
                                   {"rgb", ValueKind::Rgb, ParamType::Color},
                                   {"xyz", ValueKind::Xyz, ParamType::Color},
                                   {"blackbody", ValueKind::Blackbody, ParamType::Color},
                                   {"spectrum", ValueKind::Spectrum, ParamType::Color}};

constexpr std::string_view kBlanks = " \t\r\n";

/// The first word of the text, which is cut off.
std::string takeWord(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  const std::string word(text.substr(0, text.find_first_of(kBlanks)));
  text.remove_prefix(word.size());
  return word;
}

}  // namespace

ParamDeclaration parseDeclaration(const Token& token) {
  std::string_view rest = token.text;
  const std::string type = takeWord(rest), name = takeWord(rest), more = takeWord(rest);
  const auto* known = std::find_if(std::begin(kTypeWords), std::end(kTypeWords),
                                   [&](const TypeWord& w) { return type == w.word; });
  if (known == std::end(kTypeWords)) {
    std::vector<std::string> words;
    for (const TypeWord& w : kTypeWords) words.emplace_back(w.word);
    throw SceneError(token.where,
                     fmt::format("{} does not begin with a parameter type: {}{}", quote(token.text),
                                 listChoices(words), nearestSpelling(type, words)));
  }
  if (name.empty())
    throw SceneError(token.where,
                     fmt::format("the parameter {} has a type but no name", quote(token.text)));
  if (!more.empty())
    throw SceneError(token.where, fmt::format("{} must be a type and a name", quote(token.text)));
  return {known->kind, known->type, quote(type + " " + name, '"'), name, token.where};
}

}  // namespace brume
